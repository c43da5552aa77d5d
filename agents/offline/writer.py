"""Writes a dataset with Minari, as a process of its own: `python -m agents.offline.writer`.

HDF5 cannot close a file that it could not write: it goes on to print tracebacks by the thousand and to crash.
"""

import os
import pickle
import re
import subprocess
import sys
import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import gymnasium as gym
import numpy as np
from gymnasium.envs.registration import EnvSpec
from numpy.typing import NDArray

from agents.provenance import ROOT, provenance
from grind_env.envs.splits import SPLITS
from grind_env.policies.problem import Problem
from grind_env.scores import find_reference

PLACE = "MINARI_DATASETS_PATH"
"""Environment variable that names the folder in which Minari keeps datasets."""
SPLIT = "split"
"""Entry of the metadata."""
SCALE = (
    " Scores are those of grind_env.scores: 0 for the best fixed plan, 1 for the planner that knows the whole episode."
)
NUMBER = re.compile(r"errno[ =]+(\d+)", re.IGNORECASE)
"""By which HDF5 and Python tell why a file cannot be written."""


class Recorded(NamedTuple):
    """N episodes of T steps at most, as an environment would have shown them."""

    observations: NDArray[np.float32]
    """Shape (N, T + 1, entries); the last one is the observation after the last block."""
    actions: NDArray[np.float32]
    """Of the Box, shape (N, T, 2)."""
    rewards: NDArray[np.float64]
    """Shape (N, T)."""
    steps: NDArray[np.int64]
    """Of each episode, shape (N,); what is behind its last one means nothing."""
    scrap: NDArray[np.float64]
    """Probability that the part which a block finished is scrap, `cost` of its `info="full"`, shape (N, T)."""


class Content(NamedTuple):
    """What a dataset is made of."""

    id: str
    problem: Problem
    title: str
    """Of the problem."""
    policy: str
    sees: str
    seeds: range
    split: str
    """That the contexts are drawn from."""
    data: Recorded


def write_apart(content: Content, folder: Path, lock: int) -> None:
    """Let another process write a dataset to the place that its id has below a folder.

    Args:
        content: of the dataset.
        folder: an absolute path.
        lock: descriptor that the process keeps open, so that a lock lasts as long as it writes.

    Raises:
        OSError: if a file cannot be written.
        RuntimeError: if the process ended for another reason.
    """
    ended = subprocess.run(
        [sys.executable, "-m", __name__],
        input=pickle.dumps(content),
        stderr=subprocess.PIPE,
        check=False,
        cwd=ROOT,
        env={**os.environ, PLACE: str(folder)},
        pass_fds=[lock],
    )
    if ended.returncode:
        said = ended.stderr.decode(errors="replace")
        number = NUMBER.search(said)
        if number is None:
            raise RuntimeError(f"the process that writes the dataset ended with {ended.returncode}: {said}")
        raise OSError(int(number[1]), os.strerror(int(number[1])))


def write(content: Content) -> None:
    """Let Minari write a dataset where it keeps them."""
    import minari
    from minari.data_collector import EpisodeBuffer

    data, seeds = content.data, content.seeds
    n = len(data.rewards)
    buffers = [
        EpisodeBuffer(
            id=i,
            seed=seeds[i],
            observations=data.observations[i, : steps + 1],
            actions=data.actions[i, :steps],
            rewards=data.rewards[i, :steps],
            terminations=np.arange(steps) == steps - 1,
            truncations=np.zeros(steps, bool),
            infos={"cost": np.concatenate([[0.0], data.scrap[i, :steps]])},
        )
        for i, steps in enumerate(data.steps.tolist())
    ]
    spec, made_with = environment_spec(content.problem), provenance(seeds)
    known = None if SPLITS[content.split].beyond else find_reference(content.problem.id)
    scale: dict[str, Any] = {} if known is None else {"ref_min_score": known.zero, "ref_max_score": known.hundred}
    with warnings.catch_warnings():
        # it misses an address to write to
        warnings.filterwarnings("ignore", message="`author", category=UserWarning)
        dataset = minari.create_dataset_from_buffers(
            content.id,
            buffers,
            env=spec,
            eval_env=spec,
            algorithm_name=content.policy,
            code_permalink=str(made_with["commit"]),
            description=f"{content.title}: {n} episodes of {content.policy}, which sees {content.sees}, on split"
            f" {content.split}.{'' if known is None else SCALE}",
            requirements=[f"grind_env=={made_with['grind_env']}"],
            **scale,
        )
    dataset.storage.update_metadata(
        {"policy": content.policy, "policy_sees": content.sees, SPLIT: content.split, "made_with": made_with}
    )


def environment_spec(problem: Problem) -> EnvSpec:
    """The environment of a dataset: the problem's own, with measured observations."""
    spec = gym.spec(problem.id)
    return replace(spec, kwargs={**spec.kwargs, **dict(problem.arguments), "observation": "measured", "info": "full"})


if __name__ == "__main__":
    write(pickle.load(sys.stdin.buffer))

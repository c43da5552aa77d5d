"""Offline data: a Minari dataset of the episodes of one policy on one task."""

import os
import re
import tempfile
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import gymnasium as gym
import numpy as np
from gymnasium.envs.registration import EnvSpec
from numpy.typing import NDArray

from agents.cells import RUNS
from agents.evaluate import start_episodes
from agents.policy import Policy, reveal
from agents.provenance import provenance
from grind_env.envs.actions import ActionCodec
from grind_env.envs.names import environment_id
from grind_env.envs.rows import Outcome
from grind_env.envs.simulation import Simulation
from grind_env.envs.tasks import Task
from grind_env.errors import GrindError
from grind_env.scores import find_reference

PLACE = "MINARI_DATASETS_PATH"
"""Environment variable that names the folder in which Minari keeps datasets."""
DATASETS = RUNS / "datasets"
"""That folder where the variable is not set."""

VERSION = 0
NOT_IN_IDS = re.compile("[^A-Za-z0-9]+")
REWARD, GOOD, FINISHED = (Outcome._fields.index(name) for name in ("reward", "good", "finished"))


class Recorded(NamedTuple):
    """N episodes of T blocks as an environment would have shown them."""

    observations: NDArray[np.float32]
    """Shape (N, T + 1, entries); the last one is the observation after the last block."""
    actions: NDArray[np.float32]
    """Of the Box, shape (N, T, 2)."""
    rewards: NDArray[np.float64]
    """Shape (N, T)."""
    scrap: NDArray[np.float64]
    """Probability that the part which a block finished is scrap, `info["cost"]` of the environment, shape (N, T)."""


def recorded(policy: Policy, task: Task, seeds: Sequence[int]) -> Recorded:
    """Run a policy through the episode of each seed, side by side, and keep what it saw, did and earned."""
    simulation, codec, n = Simulation(task), ActionCodec(task), len(seeds)
    episodes = start_episodes(simulation, seeds)
    observations, actions, outcomes = [simulation.observe(episodes)], [], []
    policy.begin(task, n)
    for _ in range(task.blocks):
        decision = policy.act(observations[-1], reveal(policy.sees, task, episodes))
        actions.append(np.asarray(codec.encode(*decision), np.float32))
        outcomes.append(simulation.step(episodes, *codec.decode(actions[-1]))[0])
        observations.append(simulation.observe(episodes))
    blocks = np.stack(outcomes, axis=1)
    return Recorded(
        np.stack(observations, axis=1),
        np.stack(actions, axis=1),
        np.ascontiguousarray(blocks[..., REWARD]),
        np.where(blocks[..., FINISHED] > 0.0, 1.0 - blocks[..., GOOD], 0.0),
    )


def dataset_id(task: Task, policy: Policy) -> str:
    """Id of the dataset of a policy: `grind/power_limited/adaptive-rule-v0`."""
    return f"grind/{task.name}/{NOT_IN_IDS.sub('-', policy.name)}-v{VERSION}"


def make_dataset(policy: Policy, task: Task, seeds: range, *, fresh: bool = False) -> Path:
    """Record a policy and store the dataset, whole or not at all; see `datasets_folder`.

    Observations are the measured ones and actions those of the Box of the task's environment, whatever the policy
    sees. Every episode has its seed: `env.reset(seed=...)` and its actions give the same rewards again. Infos hold
    `cost`, the probability of scrap, for safe reinforcement learning; the first entry is that of the reset.

    Args:
        policy: what acts.
        task: what it grinds.
        seeds: of the episodes.
        fresh: put it in place of a dataset of that id.

    Returns:
        Folder of the dataset.

    Raises:
        GrindError: if there is a dataset of that id and `fresh` is not asked for.
    """
    name, folder = dataset_id(task, policy), datasets_folder()
    path = folder / name
    if path.exists() and not fresh:
        raise GrindError(f"there is a dataset {name} in {folder} already: --fresh puts a new one in its place")
    data = recorded(policy, task, seeds)
    path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=folder, prefix=".grind-") as unfinished:
        with kept_in(Path(unfinished)):
            _write(name, policy, task, seeds, data)
        with kept_in(folder):
            _make_namespace(name)
        if path.exists():
            path.rename(Path(unfinished) / "old")
        (Path(unfinished) / name).rename(path)
    return path


def environment_spec(task: Task) -> EnvSpec:
    """The environment of a dataset: the task's own, with measured observations."""
    spec = gym.spec(environment_id(task.name))
    return replace(spec, kwargs={**spec.kwargs, "observation": "measured"})


def datasets_folder() -> Path:
    """The folder that `MINARI_DATASETS_PATH` names, or `runs/datasets`."""
    return Path(os.environ.get(PLACE, DATASETS))


@contextmanager
def kept_in(folder: Path) -> Iterator[None]:
    """Let Minari keep its datasets in a folder for a while."""
    before = os.environ.get(PLACE)
    os.environ[PLACE] = str(folder)
    try:
        yield
    finally:
        if before is None:
            del os.environ[PLACE]
        else:
            os.environ[PLACE] = before


def _write(name: str, policy: Policy, task: Task, seeds: range, data: Recorded) -> None:
    """Let Minari write a dataset where it keeps them."""
    import minari
    from minari.data_collector import EpisodeBuffer

    n, blocks = data.rewards.shape
    last = np.arange(blocks) == blocks - 1
    buffers = [
        EpisodeBuffer(
            id=i,
            seed=seeds[i],
            observations=data.observations[i],
            actions=data.actions[i],
            rewards=data.rewards[i],
            terminations=last,
            truncations=np.zeros(blocks, bool),
            infos={"cost": np.concatenate([[0.0], data.scrap[i]])},
        )
        for i in range(n)
    ]
    spec, made_with = environment_spec(task), provenance(seeds)
    known = find_reference(environment_id(task.name))
    scale: dict[str, Any] = {} if known is None else {"ref_min_score": known.zero, "ref_max_score": known.hundred}
    with warnings.catch_warnings():
        # it misses an address to write to
        warnings.filterwarnings("ignore", message="`author", category=UserWarning)
        dataset = minari.create_dataset_from_buffers(
            name,
            buffers,
            env=spec,
            eval_env=spec,
            algorithm_name=policy.name,
            code_permalink=made_with["commit"],
            description=f"{task.title}: {n} episodes of {policy.name}, which sees {policy.sees}. Scores are those of"
            " grind_env.scores: 0 for the best fixed plan, 1 for the planner that knows the whole episode.",
            requirements=[f"grind_env=={made_with['grind_env']}"],
            **scale,
        )
    dataset.storage.update_metadata({"policy": policy.name, "policy_sees": policy.sees, "made_with": made_with})


def _make_namespace(name: str) -> None:
    """Let Minari know the folder of a dataset."""
    from minari.namespace import create_namespace, list_local_namespaces

    namespace = name.rpartition("/")[0]
    if namespace not in list_local_namespaces():
        create_namespace(namespace)

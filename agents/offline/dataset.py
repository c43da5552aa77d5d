"""Offline data: a Minari dataset of the episodes of one policy on one task."""

import dataclasses
import os
import re
import warnings
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any
from unittest.mock import patch

import gymnasium as gym
import numpy as np

from agents.cells import RUNS
from agents.provenance import provenance
from grind_env.envs.actions import ActionCodec
from grind_env.envs.simulation import advance
from grind_env.envs.splits import EVERY, SPLITS
from grind_env.envs.tables import Outcome
from grind_env.errors import GrindError
from grind_env.files import FileError
from grind_env.policies.evaluation import start_episodes
from grind_env.policies.held import model_beside, parted
from grind_env.policies.policy import Policy, reveal
from grind_env.policies.problem import Problem
from grind_env.scores import find_reference

if TYPE_CHECKING:
    from minari import MinariDataset

PLACE = "MINARI_DATASETS_PATH"
"""Environment variable that names the folder in which Minari keeps datasets; by default `runs/datasets`."""
NOT_IN_IDS, NOT_IN_FOLDERS = re.compile("[^A-Za-z0-9]+"), re.compile(r"[^\w-]+")
"""What the name of a policy, and that of a problem, cannot have in an id of Minari."""
SCALE = " Scores are those of grind_env.scores: 0 for the best fixed plan, 1 for the planner that knows all."
Steps = tuple[Any, ...]
"""Observations, actions, rewards and probabilities of scrap of one episode."""
REWARD, GOOD, FINISHED = (Outcome._fields.index(name) for name in ("reward", "good", "finished"))


def recorded(policy: Policy, problem: Problem, seeds: Sequence[int], split: str = EVERY) -> list[Steps]:
    """Run a policy through the episode of each seed, side by side; return what it saw, did, earned and spoiled.

    On a machine that is not the model, the policy holds the model.
    """
    simulation, model, n = problem.simulation(), model_beside(problem), len(seeds)
    codec = ActionCodec(simulation.task)
    episodes = start_episodes(simulation, seeds, split)
    observations, actions, outcomes = [simulation.observe(episodes)], [], []
    steps = np.zeros(n, np.int64)
    held, shown = model or simulation, parted(policy, simulation, model, episodes)
    policy.begin(held, n)
    while (running := ~simulation.over(episodes)).any():
        decision = policy.act(observations[-1], reveal(policy.sees, held, shown(episodes)))
        actions.append(np.asarray(codec.encode(*decision), np.float32))
        choice = simulation.taken(episodes, codec.decode(actions[-1]))
        outcomes.append(advance(simulation, episodes, *choice)[0])
        observations.append(simulation.observe(episodes))
        steps += running
    blocks = np.stack(outcomes, axis=1)
    seen, done = np.stack(observations, axis=1), np.stack(actions, axis=1)
    scrap = np.where(blocks[..., FINISHED] > 0.0, 1.0 - blocks[..., GOOD], 0.0)
    return [(seen[i, : n + 1], done[i, :n], blocks[i, :n, REWARD], scrap[i, :n]) for i, n in enumerate(steps)]


def stored_episodes(dataset: "MinariDataset") -> list[Steps]:
    """Return the episodes of a dataset."""
    return [(e.observations, e.actions, e.rewards, e.infos["cost"][1:]) for e in dataset.iterate_episodes()]


def dataset_id(problem: Problem, policy: Policy) -> str:
    """Id of the dataset of a policy: `grind/power_limited/adaptive-rule-v0`."""
    return f"grind/{NOT_IN_FOLDERS.sub('-', problem.name)}/{NOT_IN_IDS.sub('-', policy.name)}-v0"


def make_dataset(policy: Policy, problem: Problem, seeds: range, split: str = EVERY, *, fresh: bool = False) -> Path:
    """Record a policy and store the dataset in the folder that `PLACE` names; return its folder.

    Observations are the measured ones and actions those of the Box of the task's environment, whatever the policy
    sees. `env.reset(seed=..., options={"split": ...})` and the actions of an episode give the same rewards again. Infos
    hold `cost`, the probability of scrap, for safe reinforcement learning; the first entry is that of the reset.

    Raises:
        GrindError: there is a dataset of that id and `fresh` is not asked for, or no such split.
        FileError: the dataset cannot be written.
    """
    import minari
    from minari.data_collector import EpisodeBuffer

    name, folder = dataset_id(problem, policy), Path(os.environ.get(PLACE, RUNS / "datasets")).absolute()
    if (folder / name).exists() and not fresh:
        raise GrindError(f"there is a dataset {name} in {folder} already: --fresh puts a new one in its place")
    data, made = recorded(policy, problem, seeds, split), provenance(seeds)
    known = None if SPLITS[split].beyond else find_reference(problem.id)
    scale: dict[str, Any] = {} if known is None else {"ref_min_score": known.zero, "ref_max_score": known.hundred}
    buffers = [
        EpisodeBuffer(
            id=i,
            seed=seeds[i],
            observations=observations,
            actions=actions,
            rewards=rewards,
            terminations=np.arange(len(rewards)) == len(rewards) - 1,
            truncations=np.zeros(len(rewards), bool),
            infos={"cost": np.concatenate([[0.0], scrap])},
        )
        for i, (observations, actions, rewards, scrap) in enumerate(data)
    ]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with TemporaryDirectory(dir=folder, prefix=".grind-") as place, patch.dict(os.environ, {PLACE: place}):
            spec = gym.spec(problem.id)
            kwargs = {**spec.kwargs, **dict(problem.arguments), "observation": "measured", "info": "full"}
            spec = dataclasses.replace(spec, kwargs=kwargs)
            with warnings.catch_warnings():
                # it misses an address to write to
                warnings.filterwarnings("ignore", message="`author", category=UserWarning)
                dataset = minari.create_dataset_from_buffers(
                    name,
                    buffers,
                    env=spec,
                    eval_env=spec,
                    algorithm_name=policy.name,
                    code_permalink=str(made["commit"]),
                    description=f"{problem.simulation().task.title}: {len(seeds)} episodes of {policy.name}, which sees"
                    f" {policy.sees}, on split {split}.{'' if known is None else SCALE}",
                    requirements=[f"grind_env=={made['grind_env']}"],
                    **scale,
                )
            about = {"policy": policy.name, "policy_sees": policy.sees, "split": split, "made_with": made}
            dataset.storage.update_metadata(about)
            for each in Path(place).rglob("namespace_metadata.json"):
                (folder / each.relative_to(place)).parent.mkdir(parents=True, exist_ok=True)
                each.replace(folder / each.relative_to(place))
            if (folder / name).exists():
                (folder / name).rename(Path(place, "before"))
            Path(place, name).rename(folder / name)
    except OSError as error:
        raise FileError(
            f"the dataset cannot be written to {folder} ({error.strerror or error}): make room, or name another folder"
            f" in {PLACE}"
        ) from None
    return folder / name

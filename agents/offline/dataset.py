"""Offline data: a Minari dataset of the episodes of one policy on one task."""

import os
import re
import shutil
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from agents.cells import RUNS
from agents.offline.writer import PLACE, SPLIT, Content, Recorded, write_apart
from grind_env.envs.actions import ActionCodec
from grind_env.envs.simulation import advance
from grind_env.envs.splits import EVERY
from grind_env.envs.tables import Outcome
from grind_env.errors import GrindError
from grind_env.files import FileError
from grind_env.lock import alone
from grind_env.policies.evaluation import start_episodes
from grind_env.policies.held import model_beside, parted
from grind_env.policies.policy import Policy, reveal
from grind_env.policies.problem import Problem

DATASETS = RUNS / "datasets"
"""Where Minari keeps datasets if `PLACE` is not set."""

VERSION = 0
NOT_IN_IDS, NOT_IN_FOLDERS = re.compile("[^A-Za-z0-9]+"), re.compile(r"[^\w-]+")
"""What the name of a policy, and that of a problem, cannot have in an id of Minari."""
EPISODE_BYTES = 20_000
"""What HDF5 takes for an episode beside its numbers."""
STEP_BYTES = 26
"""Of a block: action, reward, scrap and two flags."""
PIECE = 1 << 20
"""Bytes that are reserved at once."""
BEFORE = "before"
"""Name in the workshop of the dataset that is replaced."""
NAMESPACE = "namespace_metadata.json"
"""File by which Minari knows a folder of datasets."""
Steps = tuple[Any, ...]
"""Arrays of one episode."""
REWARD, GOOD, FINISHED = (Outcome._fields.index(name) for name in ("reward", "good", "finished"))


def recorded(policy: Policy, problem: Problem, seeds: Sequence[int], split: str = EVERY) -> Recorded:
    """Run a policy through the episode of each seed, side by side, and keep what it saw, did and earned.

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
    return Recorded(
        observations=np.stack(observations, axis=1),
        actions=np.stack(actions, axis=1),
        rewards=np.ascontiguousarray(blocks[..., REWARD]),
        steps=steps,
        scrap=np.where(blocks[..., FINISHED] > 0.0, 1.0 - blocks[..., GOOD], 0.0),
    )


def dataset_id(problem: Problem, policy: Policy) -> str:
    """Id of the dataset of a policy: `grind/power_limited/adaptive-rule-v0`."""
    return f"grind/{NOT_IN_FOLDERS.sub('-', problem.name)}/{NOT_IN_IDS.sub('-', policy.name)}-v{VERSION}"


def make_dataset(policy: Policy, problem: Problem, seeds: range, split: str = EVERY, *, fresh: bool = False) -> Path:
    """Record a policy and store the dataset, whole or not at all; see `datasets_folder`.

    Observations are the measured ones and actions those of the Box of the task's environment, whatever the policy
    sees. Every episode has its seed: `env.reset(seed=..., options={"split": ...})` and its actions give the same
    rewards again; the metadata name the split. Infos hold `cost`, the probability of scrap, for safe reinforcement
    learning; the first entry is that of the reset.

    Killed at any moment, the same call goes on to the same dataset. A dataset of the very same episodes stays.

    Args:
        policy: what acts.
        problem: what it grinds.
        seeds: of the episodes.
        split: that their contexts are drawn from.
        fresh: put it in place of a dataset of that id.

    Returns:
        Folder of the dataset.

    Raises:
        GrindError: if there is a dataset of that id with other episodes and `fresh` is not asked for, or no such split.
        FileError: if there is no room for it; that is seen before the recording.
    """
    name, folder = dataset_id(problem, policy), datasets_folder().absolute()
    path = folder / name
    simulation = problem.simulation()
    size = len(seeds) * (EPISODE_BYTES + simulation.most_steps * (STEP_BYTES + 4 * len(simulation.entries)))
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with alone(path.with_name(f".grind-{path.name}.lock")) as lock, workshop(path) as unfinished:
            if path.exists() and not fresh:
                if not holds(path, seeds, split, recorded(policy, problem, seeds, split)):
                    raise GrindError(
                        f"there is a dataset {name} in {folder} already: --fresh puts a new one in its place"
                    )
                return path
            with reserved(unfinished / "room", size):
                data = recorded(policy, problem, seeds, split)
            content = Content(name, problem, simulation.task.title, policy.name, policy.sees, seeds, split, data)
            write_apart(content, unfinished, lock)
            _put_in_place(unfinished, folder, path)
    except OSError as error:
        raise FileError(
            f"the dataset cannot be written to {folder} ({error.strerror or error}): it needs about"
            f" {size / 1e6:.1f} MB; make room, or name another folder in {PLACE}, and run the same command again"
        ) from None
    return path


def stored_episodes(path: Path) -> list[Steps]:
    """The episodes of a dataset: observations, actions, rewards and probabilities of scrap of each."""
    import minari

    stored = minari.MinariDataset(path / "data").iterate_episodes()
    return [(e.observations, e.actions, e.rewards, e.infos["cost"][1:]) for e in stored]


def recorded_episodes(data: Recorded) -> list[Steps]:
    """The same of what was recorded, without what is behind the last step of each."""
    return [
        (data.observations[i, : n + 1], data.actions[i, :n], data.rewards[i, :n], data.scrap[i, :n])
        for i, n in enumerate(data.steps.tolist())
    ]


def holds(path: Path, seeds: range, split: str, data: Recorded) -> bool:
    """Whether a dataset has these very episodes."""
    import minari

    try:
        stored = minari.MinariDataset(path / "data")
        drawn_from = stored.storage.metadata.get(SPLIT, EVERY)
        kept = [each["seed"] for each in stored.storage.get_episode_metadata(range(stored.total_episodes))]
        found = stored_episodes(path)
    # what lies there is no dataset of ours, or a damaged one
    except (OSError, ValueError, KeyError, TypeError):
        return False
    new = recorded_episodes(data)
    same = (np.array_equal(a, b) for old, each in zip(found, new, strict=False) for a, b in zip(old, each, strict=True))
    return drawn_from == split and kept == list(seeds) and len(found) == len(new) and all(same)


def datasets_folder() -> Path:
    """The folder that `MINARI_DATASETS_PATH` names, or `runs/datasets`."""
    return Path(os.environ.get(PLACE, DATASETS))


@contextmanager
def workshop(path: Path) -> Iterator[Path]:
    """An empty folder beside a dataset in which its successor is made; for who is `alone`."""
    folder = path.with_name(f".grind-{path.name}")
    _clear(folder, path)
    folder.mkdir()
    try:
        yield folder
    finally:
        _clear(folder, path)


def _clear(folder: Path, path: Path) -> None:
    """Remove the folder of a run that has ended or was killed."""
    before = folder / BEFORE
    # the old dataset was put aside, but no new one took its place
    if before.exists() and not path.exists():
        before.rename(path)
    shutil.rmtree(folder, ignore_errors=True)


@contextmanager
def reserved(path: Path, size: int) -> Iterator[None]:
    """Hold so many bytes of the disk for a while.

    Raises:
        OSError: if they are not there.
    """
    with path.open("wb") as file:
        for start in range(0, size, PIECE):
            file.write(bytes(min(PIECE, size - start)))
    yield
    path.unlink()


def _put_in_place(unfinished: Path, folder: Path, path: Path) -> None:
    """Move what Minari made below one folder to the same place below another."""
    for namespace in unfinished.rglob(NAMESPACE):
        known = folder / namespace.relative_to(unfinished)
        if not known.exists():
            namespace.rename(known)
    if path.exists():
        path.rename(unfinished / BEFORE)
    (unfinished / path.relative_to(folder)).rename(path)

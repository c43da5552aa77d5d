"""`python -m agents dataset`."""

import os
import re
import shutil
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Annotated

import gymnasium as gym
import numpy as np
import typer

from agents.evaluation_cache import RUNS
from agents.provenance import provenance
from grind_env.envs.actions import ActionCodec
from grind_env.envs.distribution_splits import EVERY, SPLITS
from grind_env.errors import GrindError
from grind_env.files import FileError
from grind_env.message_text import printable
from grind_env.policies.evaluation import SEEDS, episode_seeds, run_seeds
from grind_env.policies.nominal_model import model_beside
from grind_env.policies.policy import Policy
from grind_env.policies.problem_lookup import Problem, find_problem
from grind_env.policy_commands import Configs, JobFile, NamedPolicy, NamedProblem, Parts, Split
from grind_env.score_scale import find_reference

if TYPE_CHECKING:
    from minari import MinariDataset

PLACE = "MINARI_DATASETS_PATH"  #: environment variable that names the folder in which Minari keeps datasets


def dataset(
    task: NamedProblem = "power_limited",
    job: JobFile = None,
    parts: Parts = 1,
    policy: NamedPolicy = None,
    episodes: Annotated[int, typer.Option(min=1, help="Number of episodes.")] = 200,
    seeds: Annotated[str, typer.Option(help=f"Seeds: {', '.join(SEEDS)}.")] = "training",
    split: Split = EVERY,
    configs: Configs = None,
) -> None:
    """Record episodes as a Minari dataset, for offline RL."""
    from grind_env.policies.policy_lookup import chosen_policy

    problem = find_problem(task, job, parts)
    acts = chosen_policy(policy, problem.simulation(), configs)
    made = make_dataset(acts, problem, episode_seeds(seeds, episodes), split)
    print(printable(f"{made.id}: {made.total_episodes} episodes, {made.total_steps} steps"))
    print(printable(f"load it by minari.load_dataset({made.id!r}) with {PLACE}={os.environ[PLACE]}"))


def make_dataset(policy: Policy, problem: Problem, seeds: range, split: str = EVERY) -> "MinariDataset":
    """Record a policy in the folder `MINARI_DATASETS_PATH`, by default `runs/datasets`.

    For every policy, observations are measurements, and actions are in the Box of the task's environment.
    `env.reset(seed=..., options={"split": ...})` and the actions of an episode reproduce its rewards.

    Raises:
        GrindError: the dataset exists already, the split does not exist, or the disk has no room.
    """
    import minari
    from minari.data_collector import EpisodeBuffer

    task, maker = (re.sub(r"[^A-Za-z0-9_]+", "-", name) for name in (problem.name, policy.name.replace("_", "-")))
    name, folder = f"grind/{task}/{maker}-v0", Path(os.environ.get(PLACE, RUNS / "datasets")).absolute()
    if (folder / name).exists():
        raise GrindError(f"there is a dataset {name} in {folder}: delete it, or name another folder in {PLACE}")
    usual, simulation, made_with = gym.spec(problem.id), problem.simulation(), provenance(seeds)
    shown = {**usual.kwargs, **dict(problem.arguments), "observation": "measured", "info": "full"}
    env, codec, buffers = gym.make(spec := replace(usual, kwargs=shown)), ActionCodec(simulation.task), []
    run = run_seeds(policy, simulation, seeds, split, model_beside(problem))
    for k, seed in enumerate(seeds):
        taken = ~np.isnan(run.speeds[k])
        actions = codec.encode(run.speeds[k, taken], run.executions[k, taken])
        first, steps = env.reset(seed=seed, options={"split": split})[0], [env.step(action) for action in actions]
        seen, rewards, over, cut, infos = zip(*steps, strict=True)
        scrap = {"cost": np.array([0.0, *(each["cost"] for each in infos)])}
        numbers = np.stack([first, *seen]), actions, np.array(rewards), np.array(over), np.array(cut)
        buffers.append(EpisodeBuffer(k, seed, None, *numbers, scrap))
    known = None if SPLITS[split].leaves_task else find_reference(problem.id)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        size = sum(20_000 + 2 * each.observations.nbytes for each in buffers)
        if shutil.disk_usage(folder).free < size:  # HDF5 crashes on a full disk
            raise OSError(f"it needs {size / 1e6:.1f} MB")
        with TemporaryDirectory(dir=folder, prefix=".grind-") as place:
            os.environ[PLACE] = place
            made = minari.create_dataset_from_buffers(
                name,
                buffers,
                env=spec,
                eval_env=spec,
                algorithm_name=policy.name,
                author="grind_env",
                author_email="none",
                code_permalink=str(made_with["commit"]),
                description=f"{simulation.task.title}: {len(seeds)} episodes of {policy.name}, split {split}.",
                requirements=[f"grind_env=={made_with['grind_env']}"],
                ref_min_score=known and known.zero,
                ref_max_score=known and known.hundred,
            )
            made.storage.update_metadata({"policy_sees": policy.sees, "split": split, "made_with": made_with})
            os.renames(Path(place, name), folder / name)
    except OSError as error:
        raise FileError(f"the dataset cannot be written to {folder} ({error.strerror or error}): make room") from None
    finally:
        os.environ[PLACE] = str(folder)
    return minari.load_dataset(name)

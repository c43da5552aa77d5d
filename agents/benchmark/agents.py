"""Agents of the benchmark, trained once and cached: kinds of `gru_ppo`, and the training recipe."""

import hashlib
import inspect
import json
import time
from dataclasses import asdict
from pathlib import Path
from typing import NamedTuple

from safetensors import safe_open

from agents import train_sb3
from agents.benchmark.plan import RECIPE
from agents.benchmark.trained import ZIP
from agents.cells import RUNS, bare, behaviour, sources
from agents.provenance import commit, installed
from grind_env.envs.splits import EVERY
from grind_env.policies.learned.saved import ENTRY, SUFFIX, write_policy
from grind_env.policies.model_view import machines_name, model_of
from grind_env.policies.problem import Problem
from grind_env.training import gru_ppo
from grind_env.training.gru_ppo import Memory, Settings, form_of, policy_of, shown

RECIPE_STEPS = 1_000_000
LIBRARIES = ("torch", "numpy")
BESIDE = ("grind_env.envs.learning", "grind_env.policies.learned.view")
"""Where else lies what decides a training; what `gru_ppo` prints with does not."""


class AgentTraining(NamedTuple):
    """Training of an agent: environment steps, split of the contexts, and CPU time."""

    steps: int
    split: str
    cpu_seconds: float


def plain_agent(
    problem: Problem,
    kind: str,
    memory: Memory,
    seed: int,
    steps: int | None = None,
    folder: Path = RUNS,
    *,
    fresh: bool,
) -> Path:
    """Return the file of an agent, `<kind>-<seed>-<hash>.safetensors` in the problem's sub-folder of `folder`.

    It is trained, in about a minute, unless an agent of the same code, settings and seed is there.
    """
    settings = Settings(memory=memory) if steps is None else Settings(memory=memory, steps=steps)
    stem = folder / problem.name / f"{kind}-{seed}-{fingerprint(problem, settings, seed)}"
    path = stem.with_suffix(SUFFIX)
    if fresh or not path.exists():
        begin = time.process_time()
        agent, scale = gru_ppo.train(problem, settings, seed)
        policy = policy_of(agent, scale, problem, memory)
        training = AgentTraining(settings.steps, settings.split, time.process_time() - begin)
        beside = {
            "settings": asdict(settings) | {"seed": seed},
            "machines": machines_name(problem.simulation()),
            "training": training._asdict(),
            "commit": commit(),
        }
        write_policy(path, policy.actor, model_of(problem), kind, form_of(memory), beside)
    return path


def recipe_agent(problem: Problem, seed: int, steps: int | None, folder: Path, *, fresh: bool) -> Path:
    """Return the .zip of an agent that the recipe of `docs/howto/train.md` trains; arguments as of `plain_agent`."""
    steps = steps or RECIPE_STEPS
    decides = [
        *map(sources, (train_sb3.__name__, "grind_env.envs.wrappers", "grind_env.sb3.adapter")),
        behaviour(problem.simulation()),
        problem.simulation().task.reference_cost,
        *map(installed, (*LIBRARIES, "gymnasium", "stable_baselines3")),
        *(seed, steps),
    ]
    digest = hashlib.sha256("\0".join(map(str, decides)).encode()).hexdigest()[:12]
    path = folder / problem.name / f"{RECIPE}-{seed}-{digest}.zip"
    if fresh or not path.exists():
        train_sb3.train(problem, RECIPE, seed, steps, path)
    return path


def training_of(path: Path) -> AgentTraining:
    """Return the training of an agent that `plain_agent` or `recipe_agent` wrote."""
    if path.suffix == ZIP:
        steps, cpu_seconds = train_sb3.trained(path)
        return AgentTraining(steps, EVERY, cpu_seconds)
    with safe_open(path, "numpy") as file:
        return AgentTraining(**json.loads(file.metadata()[ENTRY])["training"])


def fingerprint(problem: Problem, settings: Settings, seed: int) -> str:
    """Return a fingerprint of all inputs of a training."""
    simulation = problem.simulation()
    parts = [
        bare(inspect.getsource(gru_ppo)),
        *map(sources, BESIDE),
        # what the true state reads is there in training, whoever is shown it later
        *(behaviour(each) for each in (simulation, shown(problem, "state").simulation())),
        simulation.task.reference_cost,
        settings,
        seed,
        *map(installed, LIBRARIES),
    ]
    return hashlib.sha256("\0".join(map(str, parts)).encode()).hexdigest()[:12]

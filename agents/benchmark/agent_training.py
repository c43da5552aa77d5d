"""Agents of the benchmark, trained once and cached: kinds of `gru_ppo`, and the training recipe."""

import hashlib
import inspect
import json
import time
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any, NamedTuple

from safetensors import safe_open

from agents import train_sb3
from agents.benchmark.agent_files import ZIP
from agents.benchmark.plan import LIMIT, PLAIN, PUBLIC, RECIPE, ROBUST, BenchmarkCell, Request
from agents.evaluation_cache import RUNS, bare, sources
from agents.provenance import commit, installed
from agents.study import of_problem
from grind_env.envs.distribution_splits import EVERY
from grind_env.policies.learned.saved import ENTRY, SUFFIX, write_policy
from grind_env.policies.nominal_model import machines_name, model_of, on, without_plant
from grind_env.policies.problem_lookup import Problem
from grind_env.policies.scoring import evaluate
from grind_env.score_scale import find_reference
from grind_env.training import gru_ppo
from grind_env.training.gru_ppo import Settings, form_of, policy_of, shown

LIBRARIES = ("torch", "numpy")
#: further modules that decide the result of a training; modules for the output of `gru_ppo` do not
BESIDE = ("grind_env.envs.learning_scales", "grind_env.policies.learned.agent_spaces")
POINTS, CURVE_EPISODES = 16, 64  #: number of points of a learning curve, and number of validation episodes per point


class AgentTraining(NamedTuple):
    """Training of an agent: environment steps, split of the contexts, CPU time, s, and learning curve.

    Each point of `curve` is a number of steps, and the score on validation seeds after them.
    """

    steps: int
    split: str
    cpu_seconds: float
    curve: Sequence[tuple[int, float]] = ()


class LearningCurve:
    """Learning curve of an agent, made in place of a checkpoint of `gru_ppo.train`."""

    def __init__(self, problem: Problem, settings: Settings) -> None:
        # an agent that is trained on other machines is scored on the model, too
        self.problem, self.settings = without_plant(problem), settings
        self.points, self.seconds, self.next = list[tuple[int, float]](), 0.0, 1

    def resume(self, training: gru_ppo.Training) -> gru_ppo.Training:
        return training

    def write(self, training: gru_ppo.Training) -> None:
        size = self.settings.envs * self.settings.rollout
        done = POINTS * training.updates // max(self.settings.steps // size, 1)
        if done < self.next:
            return
        self.next = done + 1
        begin = time.process_time()
        policy = policy_of(training.agent, training.episodes.scale, self.problem, self.settings.memory)
        found = evaluate(policy, self.problem, seeds="validation", episodes=CURVE_EPISODES)
        assert found.score is not None
        self.points.append((training.updates * size, found.score.value))
        self.seconds += time.process_time() - begin


def plain_agent(
    problem: Problem, kind: str, settings: Settings, seed: int, folder: Path = RUNS, *, fresh: bool = False
) -> Path:
    """Return the file of an agent, `<kind>-<seed>-<hash>.safetensors` in the problem's sub-folder of `folder`.

    The agent is trained, in about a minute, unless the file of the same code, settings and seed exists.
    """
    stem = folder / problem.name / f"{kind}-{seed}-{fingerprint(problem, settings, seed)}"
    path = stem.with_suffix(SUFFIX)
    if fresh or not path.exists():
        begin = time.process_time()
        known = find_reference(problem.id)
        curve: Any = LearningCurve(problem, settings) if known and not known.ratio else None
        agent, scale = gru_ppo.train(problem, settings, seed, checkpoint=curve)
        policy = policy_of(agent, scale, problem, settings.memory)
        seconds = time.process_time() - begin - (curve.seconds if curve else 0.0)
        beside = {
            "settings": asdict(settings) | {"seed": seed},
            "machines": machines_name(problem.simulation()),
            "training": AgentTraining(settings.steps, settings.split, seconds, curve.points if curve else ())._asdict(),
            "commit": commit(),
        }
        write_policy(path, policy.actor, model_of(problem), kind, form_of(settings.memory), beside)
    return path


def agent_of(cell: BenchmarkCell, request: Request) -> Path:
    """Return the file of the agent of a cell; train the agent if the file does not exist."""
    assert cell.seed is not None
    problem, steps = ground_by(cell), cell.steps or request.steps or LIMIT
    if cell.base in PLAIN:
        settings = Settings(memory=PLAIN[cell.base], steps=steps)
        return plain_agent(problem, cell.policy, settings, cell.seed, request.runs, fresh=request.fresh)
    path = request.runs / problem.name / f"{cell.name}-{code_of_training(cell, request)}.zip"
    if request.fresh or not path.exists():
        train_sb3.train(problem, RECIPE, cell.seed, steps, path)
    return path


def ground_by(cell: BenchmarkCell) -> Problem:
    """Return the problem on which the agent of a cell is trained."""
    return on(cell.problem, PUBLIC) if cell.base == ROBUST else cell.problem


def training_of(path: Path) -> AgentTraining:
    """Return the training of an agent that `agent_of` trained."""
    if path.suffix == ZIP:
        steps, cpu_seconds = train_sb3.trained(path)
        return AgentTraining(steps, EVERY, cpu_seconds)
    with safe_open(path, "numpy") as file:
        return AgentTraining(**json.loads(file.metadata()[ENTRY])["training"])


def code_of_training(cell: BenchmarkCell, request: Request) -> str:
    """Return a hash of all inputs that decide the trained agent of a cell."""
    assert cell.seed is not None
    steps = cell.steps or request.steps or LIMIT
    if cell.base in PLAIN:
        return fingerprint(ground_by(cell), Settings(memory=PLAIN[cell.base], steps=steps), cell.seed)
    modules = map(sources, (train_sb3.__name__, "grind_env.envs.wrappers", "grind_env.sb3.vec_env"))
    libraries = map(installed, (*LIBRARIES, "gymnasium", "stable_baselines3"))
    return digest(*modules, of_problem(cell.problem), *libraries, cell.seed, steps)


def fingerprint(problem: Problem, settings: Settings, seed: int) -> str:
    """Return a hash of all inputs that decide the agent of a training with `gru_ppo`."""
    # a training also uses the true state, whatever the agent sees later
    tasks = map(of_problem, (problem, shown(problem, "state")))
    modules = bare(inspect.getsource(gru_ppo)), *map(sources, BESIDE)
    return digest(*modules, *tasks, settings, seed, *map(installed, LIBRARIES))


def digest(*parts: object) -> str:
    """Return 12 digits of a hash."""
    return hashlib.sha256("\0".join(map(str, parts)).encode()).hexdigest()[:12]

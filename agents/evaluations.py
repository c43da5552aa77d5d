"""Evaluations of named policies as trials: chunks of episodes, cached for all studies."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from itertools import product
from pathlib import Path
from typing import Any

from agents.benchmark.cpu_time import DECISION, USUAL_DECISION
from agents.evaluation_cache import CHUNK, cached_file, code_of, read_cached, write_cached
from agents.study import Found, Study, StudyOptions
from grind_env.envs.distribution_splits import EVERY
from grind_env.policies.evaluation import Evaluation, episode_seeds, run_seeds
from grind_env.policies.nominal_model import model_beside
from grind_env.policies.policy_lookup import named_policy
from grind_env.policies.problem_lookup import Problem


@dataclass(frozen=True)
class Chunk:
    """Consecutive evaluation episodes of a policy, one trial of a study."""

    problem: Problem
    who: str
    seeds: range
    split: str = EVERY
    configs: Path | None = None

    def __str__(self) -> str:
        return f"{self.problem.name}, {self.split}: {self.who}, seeds {self.seeds.start} to {self.seeds.stop - 1}"


def run_chunk(chunk: Chunk) -> Evaluation:
    """Return the evaluation of a chunk; on any machine, a policy on measurements computes with the model."""
    policy = named_policy(chunk.who, chunk.problem.simulation(), chunk.configs)
    model = model_beside(chunk.problem) if policy.sees == "measurements" else None
    return run_seeds(policy, chunk.problem.simulation(), chunk.seeds, chunk.split, model)


@cache
def _code(problem: Problem, who: str, configs: Path | None) -> tuple[str, str]:
    policy = named_policy(who, problem.simulation(), configs)
    return policy.name, code_of(policy, problem)


def chunk_seconds(chunk: Chunk) -> float:
    """Return the estimated CPU time of a chunk, s."""
    decision = DECISION.get(chunk.who.rpartition(":")[2], USUAL_DECISION)
    return len(chunk.seeds) * chunk.problem.simulation().task.blocks * decision


@dataclass(frozen=True, kw_only=True)
class Evaluations(Study):
    """Study whose trials are chunks."""

    run: Callable[[Any], Any] = run_chunk
    seconds: Callable[[Any], float] = chunk_seconds

    def cached(self, trial: Chunk, runs: Path) -> Evaluation | None:
        return read_cached(*self._place(trial, runs))

    def cache(self, trial: Chunk, found: Evaluation, runs: Path) -> None:
        write_cached(*self._place(trial, runs), found)

    def _place(self, trial: Chunk, runs: Path) -> tuple[Path, str]:
        name, code = _code(trial.problem, trial.who, trial.configs)
        return cached_file(name, code, trial.problem, trial.seeds, trial.split, runs)


def chunks(
    asked: StudyOptions, policies: Callable[[Problem], Iterable[str]], splits: Iterable[str] = (EVERY,)
) -> list[Chunk]:
    """Return the chunks of a study: the evaluation episodes of the policies of each problem."""
    seeds = episode_seeds("evaluation", asked.episodes)
    return [
        Chunk(problem, who, seeds[first : first + CHUNK], split, asked.configs)
        for problem in asked.problems
        for who, split in product(policies(problem), splits)
        for first in range(0, asked.episodes, CHUNK)
    ]


def joined(found: Found) -> Mapping[tuple[Problem, str, str], Evaluation]:
    """Return the evaluations joined from chunks, by problem, split and policy."""
    parts: dict[tuple[Problem, str, str], list[Any]] = {}
    for chunk, evaluation in found.items():
        parts.setdefault((chunk.problem, chunk.split, chunk.who), []).append(evaluation)
    return {key: Evaluation.joined(each) for key, each in parts.items()}


def by_problem(found: Found) -> Mapping[Problem, Mapping[str, Evaluation]]:
    """Return the evaluations joined from chunks of one split, by problem and policy."""
    of: dict[Problem, dict[str, Evaluation]] = {}
    for (problem, _, who), evaluation in joined(found).items():
        of.setdefault(problem, {})[who] = evaluation
    return of

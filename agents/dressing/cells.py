"""The findings of a dress study as cells, each of which a node may find."""

import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from glob import escape
from pathlib import Path
from typing import NamedTuple

from agents.benchmark.trained import from_file
from agents.cells import RUNS
from agents.dressing.study import Finding, count, questions
from grind_env.policies.evaluation import episode_seeds
from grind_env.policies.held import on
from grind_env.policies.learned.saved import SUFFIX
from grind_env.policies.naming import SHIPPED
from grind_env.policies.policy import Policy
from grind_env.policies.problem import Problem
from grind_env.policies.registry import make_policy, policy_names

BASELINES = ("random", "handbook", "constant", "constant_per_kind")
"""Policies that do not decide when to dress."""


class Cell(NamedTuple):
    """A finding by its number in the study of a problem, and the policy that decides, if one does."""

    problem: Problem
    number: int
    policy: str | None

    def __str__(self) -> str:
        return f"{self.problem.name} {self.policy or f'finding {self.number + 1}'}"

    @property
    def files(self) -> tuple[str, ...]:
        """Pattern of what is kept of it."""
        name = escape(self.problem.name)
        return (f"{name}/dress_study/*" if self.policy is None else f"{name}/cells/{self.policy}/*",)

    @property
    def trains(self) -> bool:
        """No agent is trained."""
        return False


@dataclass(frozen=True, slots=True, kw_only=True)
class Request:
    """How findings are made.

    Attributes:
        episodes: evaluation episodes.
        runs: folder of what is kept.
        configs: folder of the tuned parameters; by default that of `tuned_folder`.
    """

    episodes: int
    runs: Path = RUNS
    configs: Path | None = None

    @property
    def size(self) -> int:
        """A finding tells nothing on the way."""
        return 1


def on_plant(problem: Problem, plant: str) -> Problem:
    """The problem on a machine, with a name of its own for what is kept and told."""
    machine = re.sub(r"[^\w.+]+", "-", plant)
    return replace(on(problem, plant), name=f"{problem.name}-{machine}")


def cells(problem: Problem) -> list[Cell]:
    """The cells of a study, those of planners, which take longest, first."""
    deciders = deciding(problem)
    fixed = count(problem, deciders) - len(deciders)
    names = [None] * fixed + [policy.name for policy in deciders]
    return [Cell(problem, number, name) for number, name in enumerate(names)][::-1]


def find(cell: Cell, request: Request, advance: Callable[[int], object]) -> Finding:
    """Make the finding of a cell, which is kept."""
    seeds = episode_seeds("evaluation", request.episodes)
    deciders = deciding(cell.problem, request.configs)
    found = questions(cell.problem, deciders, seeds, request.runs)[cell.number]()
    advance(1)
    return found


def deciding(problem: Problem, configs: Path | None = None) -> list[Policy]:
    """The policies of a problem that decide when to dress: scripted ones, planners, and the learned one shipped."""
    simulation = problem.simulation()
    made = partial(make_policy, simulation=simulation, folder=configs)
    scripted = [made(name) for name in policy_names(simulation) if name not in BASELINES]
    shipped = SHIPPED / f"{simulation.task.name}{SUFFIX}"
    return [*scripted, *([from_file(shipped, simulation, "learned")] if shipped.exists() else [])]

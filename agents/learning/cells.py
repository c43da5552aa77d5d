"""A training as a cell, which a node may do."""

from collections.abc import Callable
from dataclasses import dataclass
from glob import escape
from pathlib import Path
from typing import NamedTuple

from agents.learning.train import trained_agent
from grind_env.policies.problem import Problem


class Cell(NamedTuple):
    """An agent of a kind that is trained for a problem with a seed."""

    problem: Problem
    kind: str
    seed: int

    def __str__(self) -> str:
        return f"{self.problem.name} {self.kind} {self.seed}"

    @property
    def files(self) -> tuple[str, ...]:
        """Patterns of what is kept of it: the agent, its curve, its checkpoint, its metrics."""
        name, agent = escape(self.problem.name), f"{self.kind}-{self.seed}-*"
        return f"{name}/{agent}", f"{name}/tensorboard/{agent}/*"

    @property
    def trains(self) -> bool:
        """An agent is trained."""
        return True


@dataclass(frozen=True, slots=True, kw_only=True)
class Request:
    """How agents are trained; see `trained_agent`."""

    steps: int
    split: str | None
    runs: Path
    fresh: bool

    @property
    def size(self) -> int:
        """Steps of a training."""
        return self.steps


def train_away(cell: Cell, request: Request, advance: Callable[[int], object]) -> Path:
    """Train an agent; its file, below the folder of what is kept."""
    path = trained_agent(
        cell.problem,
        cell.kind,
        cell.seed,
        request.steps,
        request.runs,
        split=request.split,
        quiet=True,
        advance=advance,
    )
    return path.relative_to(request.runs)

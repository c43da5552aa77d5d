"""The cells of the track: what is tuned on a machine, and a run of an adapter on it; both are kept."""

import hashlib
import re
import time
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field, replace
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from agents.cells import RUNS, behaviour, sources
from agents.findings import keep, kept
from agents.track.adapter import Adapter
from agents.track.adapters import made
from agents.track.floor import Floor
from agents.track.knowing import KNOWING, Known, tune_on
from grind_env.errors import GrindError
from grind_env.plants import Plant
from grind_env.policies.held import model_of, on
from grind_env.policies.judging import check_policy
from grind_env.policies.policy import Policy
from grind_env.policies.problem import Problem

EPISODES = 64
"""That judge."""
TUNING = "tuning"
"""In the place of an adapter: what is tuned on a machine, for those that know it."""

Advance = Callable[[int], object]


class Cell(NamedTuple):
    """A run of an adapter on a machine, with lots, wheels and chances of a seed, judged on the way."""

    problem: Problem
    plant: str
    adapter: str
    seed: int
    blocks: tuple[int, ...]
    """Ground on the machine when it is judged, whole shifts, ascending."""

    def __str__(self) -> str:
        return f"{self.problem.name} on {self.plant}: {self.adapter}, seed {self.seed}"

    @property
    def files(self) -> tuple[str, ...]:
        """Pattern of what is kept of it."""
        names = (re.sub(r"[^\w.-]", "_", Path(name).name) for name in (self.plant, self.adapter))
        return (f"track/{self.problem.name}/{'/'.join(names)}-{self.seed}.json",)

    @property
    def trains(self) -> bool:
        """No agent is trained."""
        return False


@dataclass(frozen=True, slots=True, kw_only=True)
class Request:
    """How cells are worked on.

    Attributes:
        runs: folder of what is kept.
    """

    runs: Path = RUNS

    @property
    def size(self) -> int:
        """Of the bar of a cell."""
        return 100


@dataclass(frozen=True, slots=True, kw_only=True)
class Run:
    """What came of a cell.

    Attributes:
        costs: of each shift, $.
        scrap: expected number of bad parts of each.
        parts: of each.
        judged: by blocks ground before, a text, of each episode: cost, $, expected number of good parts, and parts.
        cpu_seconds: of all of it.
    """

    costs: list[float] = field(default_factory=list)
    scrap: list[float] = field(default_factory=list)
    parts: list[float] = field(default_factory=list)
    judged: dict[str, list[list[float]]] = field(default_factory=dict)
    cpu_seconds: float = 0.0


def tuning_of(cell: Cell) -> Cell:
    """What is tuned on the machine of a cell."""
    return cell._replace(adapter=TUNING, seed=0, blocks=())


def find(cell: Cell, request: Request, advance: Advance) -> dict[str, Any]:
    """What is found in a cell: the fields of a `Run`, or what was tuned. It is kept with the code that found it.

    Raises:
        GrindError: there is no such adapter, or its policies see more than measurements.
    """
    if (held := found_before(cell, request)) is not None:
        return dict(held)
    path = request.runs / cell.files[0]
    path.parent.mkdir(parents=True, exist_ok=True)
    if cell.adapter == TUNING:
        found: Mapping[str, Any] = tune_on(on(cell.problem, cell.plant), path.with_suffix(".db"))
    else:
        found = asdict(_run(cell, request, advance))
    return dict(keep(path, code(cell), found))


def _run(cell: Cell, request: Request, advance: Advance) -> Run:
    before = time.process_time()
    floor, knows = Floor(cell.problem, cell.plant, cell.seed), cell.adapter in KNOWING
    tuned = request.runs / tuning_of(cell).files[0]
    adapter: Adapter = Known(cell.adapter, tuned) if knows else made(cell.adapter)
    policy = adapter.start(on(cell.problem, cell.plant) if knows else cell.problem)
    result, ground, shift = Run(), 0, floor.simulation.most_steps
    for blocks in cell.blocks:
        while ground < blocks:
            done = floor.grind(_checked(policy, knows), knows=knows)
            result.costs.append(done.cost)
            result.scrap.append(done.scrap)
            result.parts.append(done.parts)
            policy = adapter.learn(done.shift)
            ground += shift
            advance(request.size * shift // cell.blocks[-1])
        judged = floor.judge(_checked(policy, knows), EPISODES, knows=knows)
        result.judged[f"{blocks}"] = [judged.cost.tolist(), judged.good.tolist(), judged.finished.tolist()]
    return replace(result, cpu_seconds=time.process_time() - before)


def _checked(policy: Policy, knows: bool) -> Policy:
    """The policy, if it may be run.

    Raises:
        GrindError: it is none, or sees what an adapter does not get.
    """
    check_policy(policy)
    if policy.sees != "measurements" and not knows:
        raise GrindError(f"{policy.name} sees the {policy.sees}, but on the track there are measurements alone")
    return policy


def found_before(cell: Cell, request: Request) -> Any:
    """What the same code has found in a cell before; None if there is nothing of it."""
    return kept(request.runs / cell.files[0], code(cell))


def code(cell: Cell) -> str:
    """Stands for all that decides what is found in a cell."""
    facts: list[object] = [_of_machine(cell.problem, cell.plant), cell[2:], sources(Known.__module__)]
    if cell.adapter != TUNING:
        facts += [sources(__name__), None if cell.adapter in KNOWING else _of_adapter(cell.problem, cell.adapter)]
    return hashlib.sha256("\0".join(map(str, facts)).encode()).hexdigest()[:16]


@cache
def _of_adapter(problem: Problem, name: str) -> str:
    """Stands for the code of an adapter, and for the parameters or the file of what it begins with."""
    adapter = made(name)
    policy = adapter.start(problem)
    return f"{sources(type(adapter).__module__)} {sources(type(policy).__module__)} {policy!r}"


@cache
def _of_machine(problem: Problem, plant: str) -> str:
    """Stands for a machine and its model, and for what a shift leaves to the next one."""
    machine = on(problem, plant).simulation()
    return f"{behaviour(machine)} {behaviour(model_of(problem))} {sources(Plant.__module__)}"

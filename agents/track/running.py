"""The cells of the track: what is tuned on a machine, and a run of an adapter on it; both are kept."""

import hashlib
import json
import time
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from functools import cache, partial
from pathlib import Path
from typing import Any, NamedTuple

from agents.cells import RUNS, behaviour, sources
from agents.track.adapter import Adapter
from agents.track.adapters import made
from agents.track.floor import Floor
from agents.track.knowing import KNOWING, Known, tune_on
from grind_env.errors import GrindError
from grind_env.files import read_text, write_atomically
from grind_env.plants import Plant
from grind_env.policies.held import model_of, on
from grind_env.policies.judging import check_policy
from grind_env.policies.policy import Policy
from grind_env.policies.problem import Problem

EPISODES = 64
"""That judge."""

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
        return (f"{folder_of(self.problem, self.plant)}/{plain(self.adapter)}-{self.seed}.json",)

    @property
    def trains(self) -> bool:
        """No agent is trained."""
        return False


class Tuning(NamedTuple):
    """What is tuned on a machine."""

    problem: Problem
    plant: str

    def __str__(self) -> str:
        return f"{self.problem.name} on {self.plant}: tuning"

    @property
    def files(self) -> tuple[str, ...]:
        """Pattern of what is kept of it."""
        return (f"{folder_of(self.problem, self.plant)}/tuned.json",)

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


def folder_of(problem: Problem, plant: str) -> str:
    """Where below `runs` what is found on a machine is kept."""
    return f"track/{problem.name}/{plain(plant)}"


def plain(name: str) -> str:
    """A name as part of a path."""
    return "".join(c if c.isalnum() or c in "._-" else "_" for c in Path(name).name)


def tune(cell: Tuning, request: Request, advance: Advance) -> dict[str, Any]:
    """What is tuned on a machine, which is kept."""
    if (held := kept(cell, request)) is not None:
        return held
    found = tune_on(on(cell.problem, cell.plant), (request.runs / cell.files[0]).with_suffix(".db"))
    advance(request.size)
    return _keep(cell, request, found)


def run(cell: Cell, request: Request, advance: Advance) -> Run:
    """What comes of an adapter on a machine, which is kept with the code that found it.

    Raises:
        GrindError: there is no such adapter, or its policies see more than measurements.
    """
    if (held := kept(cell, request)) is not None:
        return Run(**held)
    before = time.process_time()
    floor, knows = Floor(cell.problem, cell.plant, cell.seed), cell.adapter in KNOWING
    tunings = request.runs / Tuning(*cell[:2]).files[0]
    adapter: Adapter = Known(cell.adapter, tunings) if knows else made(cell.adapter)
    policy = adapter.start(on(cell.problem, cell.plant) if knows else cell.problem)
    result, ground = Run(), 0
    for blocks in cell.blocks:
        while ground < blocks:
            done = floor.grind(_checked(policy, knows), knows=knows)
            result.costs.append(done.cost)
            result.scrap.append(done.scrap)
            result.parts.append(done.parts)
            policy = adapter.learn(done.shift)
            ground += floor.simulation.most_steps
            advance(request.size * floor.simulation.most_steps // cell.blocks[-1])
        judged = floor.judge(_checked(policy, knows), EPISODES, knows=knows)
        result.judged[f"{blocks}"] = [judged.cost.tolist(), judged.good.tolist(), judged.finished.tolist()]
    numbers = asdict(result) | {"cpu_seconds": time.process_time() - before}
    return Run(**_keep(cell, request, numbers))


def _checked(policy: Policy, knows: bool) -> Policy:
    """The policy, if it may be run.

    Raises:
        GrindError: it is none, or sees what an adapter does not get.
    """
    check_policy(policy)
    if policy.sees != "measurements" and not knows:
        raise GrindError(f"{policy.name} sees the {policy.sees}, but on the track there are measurements alone")
    return policy


def kept(cell: Cell | Tuning, request: Request) -> dict[str, Any] | None:
    """What the same code has found in a cell before."""
    path = request.runs / cell.files[0]
    if not path.exists():
        return None
    held = json.loads(read_text(path))
    found: dict[str, Any] = held["found"]
    return found if held["code"] == code(cell) else None


def _keep(cell: Cell | Tuning, request: Request, found: Mapping[str, Any]) -> dict[str, Any]:
    path = request.runs / cell.files[0]
    path.parent.mkdir(parents=True, exist_ok=True)
    text = json.dumps({"code": code(cell), "found": found})
    write_atomically(path, partial(Path.write_text, data=text, encoding="utf-8"))
    held: dict[str, Any] = json.loads(text)["found"]
    return held


def code(cell: Cell | Tuning) -> str:
    """Stands for all that decides what is found in a cell."""
    facts: list[object] = [_of_machine(cell.problem, cell.plant), cell[2:]]
    if isinstance(cell, Tuning):
        facts += [sources(Known.__module__)]
    else:
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

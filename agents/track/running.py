"""The cells of the track: what is tuned on a machine, and a run of an adapter on it."""

import json
import time
from dataclasses import asdict, dataclass, field, replace
from functools import cache
from pathlib import Path
from typing import Any

from agents.budgets import TRACK_EPISODES
from agents.cells import behaviour, sources
from agents.track.adapter import Adapter
from agents.track.adapters import made
from agents.track.floor import TrackMachine
from agents.track.knowing import KNOWING, Known, tune_on
from grind_env.errors import GrindError
from grind_env.plants import Plant
from grind_env.policies.judging import check_policy
from grind_env.policies.model_view import model_of, on
from grind_env.policies.policy import Policy
from grind_env.policies.problem import Problem

TUNING = "tuning"
"""In the place of an adapter: what is tuned on a machine, for those that know it."""


@dataclass(frozen=True)
class TrackTrial:
    """A run of an adapter on a machine, with lots, wheels and chances of a seed, judged on the way."""

    problem: Problem
    plant: str
    adapter: str
    seed: int
    blocks: tuple[int, ...]
    """Ground on the machine when it is judged, whole shifts, ascending."""
    episodes: int = TRACK_EPISODES
    """That judge."""
    tuned: str = field(default="", repr=False, compare=False)
    """Parameters tuned on the machine, as JSON, for an adapter that knows the machine."""

    def __str__(self) -> str:
        return f"{self.problem.name} on {self.plant}: {Path(self.adapter).name}, seed {self.seed}"


@dataclass(frozen=True, slots=True, kw_only=True)
class TrackRun:
    """What came of a cell: $, bad parts and parts of each shift, and by blocks what judged it: $, good parts, parts."""

    costs: list[float] = field(default_factory=list)
    scrap: list[float] = field(default_factory=list)
    parts: list[float] = field(default_factory=list)
    judged: dict[str, list[list[float]]] = field(default_factory=dict)
    cpu_seconds: float = 0.0


def tuning_of(cell: TrackTrial) -> TrackTrial:
    """What is tuned on the machine of a cell."""
    return replace(cell, adapter=TUNING, seed=0, blocks=(), episodes=0)


def find(cell: TrackTrial) -> Any:
    """Return what is found in a cell: the fields of a `TrackRun`, or what was tuned."""
    return tune_on(on(cell.problem, cell.plant)) if cell.adapter == TUNING else asdict(run(cell))


def run(cell: TrackTrial) -> TrackRun:
    """Return what came of an adapter."""
    before = time.process_time()
    floor, knows = TrackMachine(cell.problem, cell.plant, cell.seed), cell.adapter in KNOWING
    adapter: Adapter = Known(cell.adapter, json.loads(cell.tuned)) if knows else made(cell.adapter)
    policy = adapter.start(on(cell.problem, cell.plant) if knows else cell.problem)
    result, ground, shift = TrackRun(), 0, floor.simulation.task.blocks
    for blocks in cell.blocks:
        while ground < blocks:
            done = floor.grind(_checked(policy, knows), knows=knows)
            result.costs.append(done.cost)
            result.scrap.append(done.scrap)
            result.parts.append(done.parts)
            policy = adapter.learn(done.shift)
            ground += shift
        judged = floor.judge(_checked(policy, knows), cell.episodes, knows=knows)
        result.judged[f"{blocks}"] = [judged.cost.tolist(), judged.good.tolist(), judged.finished.tolist()]
    return replace(result, cpu_seconds=time.process_time() - before)


def _checked(policy: Policy, knows: bool) -> Policy:
    """Return the policy, if it sees no more than an adapter gets."""
    check_policy(policy)
    if policy.sees != "measurements" and not knows:
        raise GrindError(f"{policy.name} sees the {policy.sees}, but on the track there are measurements alone")
    return policy


def decides(cell: TrackTrial) -> object:
    """Stands for the machine of a cell, its adapter, and what was tuned for it."""
    unknown = cell.adapter not in (TUNING, *KNOWING)
    return _of_machine(cell.problem, cell.plant), unknown and _of_adapter(cell.problem, cell.adapter), cell.tuned


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

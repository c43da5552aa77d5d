"""The track: which adapters are run on which machines, and how long that takes."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from rich.console import Console

from agents.pool import work_on_all
from agents.progress import CellT, FoundT
from agents.track.adapters import BLOCKS, HEADLINE, WIDE, made
from agents.track.knowing import ANCHORS, KNOWING
from agents.track.running import Cell, Request, Run, Tuning, kept, run, tune
from grind_env.errors import GrindError, quoted
from grind_env.plants import find_plants
from grind_env.policies.problem import Problem, find_problem

TASK, WIDE_TASK = "power_limited", "wide_rails"
MACHINES, WIDE_MACHINES, SEEDS = 20, 8, 3
WIDE_BLOCKS = (0, 300)
TUNING, SHIFT, JUDGING = 35.0, 0.3, 8.0
"""CPU-seconds, by measurement: of tuning on a machine, and at most of a shift and of judging once."""


class Part(NamedTuple):
    """Adapters on machines of one task."""

    problem: Problem
    plants: tuple[str, ...]
    adapters: tuple[str, ...]
    blocks: tuple[int, ...]

    def cells(self, seeds: int) -> list[Cell]:
        """Its runs and those of the anchors, machine by machine."""
        adapters = dict.fromkeys((*ANCHORS, *self.adapters))
        return [
            Cell(self.problem, plant, adapter, seed, self.blocks)
            for plant in self.plants
            for adapter in adapters
            for seed in range(seeds)
        ]


def held_out(count: int) -> tuple[str, ...]:
    """Names of the first machines that are held out."""
    return tuple(f"held-out:{seed}" for seed in range(1, count + 1))


def whole_track(*, wide: bool) -> list[Part]:
    """The headline on 20 machines; if `wide`, more adapters, and all on another task, on 8 of these."""
    task, other = find_problem(TASK), find_problem(WIDE_TASK)
    parts = [Part(task, held_out(MACHINES), HEADLINE, BLOCKS)]
    if wide:
        parts += [
            Part(task, held_out(WIDE_MACHINES), WIDE, BLOCKS),
            Part(other, held_out(WIDE_MACHINES), (*HEADLINE, *WIDE), WIDE_BLOCKS),
        ]
    return parts


def asked_for(
    task: str | None, machines: Sequence[str], adapters: Sequence[str], blocks: str | None, *, wide: bool
) -> list[Part]:
    """The parts of the track that somebody asks for, all where nothing is named.

    Raises:
        GrindError: there is no such task, machine or adapter, or the blocks are no whole shifts.
    """
    if not (task or machines or adapters or blocks):
        return whole_track(wide=wide)
    problem = find_problem(task or TASK)
    plants = [name for each in machines for name in (held_out(int(each)) if each.isdecimal() else [each])]
    for name in plants:
        if not find_plants(name, modules=True).one:
            raise GrindError(f"{name!r} is the name of many machines: give a seed, as '{name}:1'")
    for name in adapters:
        if name not in KNOWING:
            made(name).start(problem)
    usual = BLOCKS if problem.name == TASK else WIDE_BLOCKS
    chosen = usual if blocks is None else check_blocks(problem, blocks)
    names = adapters or ((*HEADLINE, *WIDE) if wide else HEADLINE)
    return [Part(problem, tuple(plants or held_out(MACHINES)), tuple(names), chosen)]


def check_blocks(problem: Problem, text: str) -> tuple[int, ...]:
    """Blocks on a machine, ascending, of numbers with commas between them.

    Raises:
        GrindError: they are no whole numbers of shifts.
    """
    shift = problem.simulation().most_steps
    for number in text.split(","):
        if not number.strip().isdecimal() or int(number) % shift:
            raise GrindError(
                f"--blocks has {quoted(number)}, but a shift of {problem.name} has {shift}: give multiples"
            )
    return tuple(sorted({int(number) for number in text.split(",")}))


def run_track(parts: Sequence[Part], seeds: int, *, jobs: int, console: Console, request: Request) -> dict[Cell, Run]:
    """Tune on every machine, then run every adapter on it; what the same code has found before is taken up again.

    Args:
        parts: of the track.
        seeds: of each adapter on each machine.
        jobs: processes.
        console: shows how far it is.
        request: where it is kept.

    Raises:
        GrindError: a cell failed.
    """
    cells = list(dict.fromkeys(cell for part in parts for cell in part.cells(seeds)))
    tuning = [each for each in dict.fromkeys(Tuning(*cell[:2]) for cell in cells) if kept(each, request) is None]
    running = [cell for cell in cells if kept(cell, request) is None]
    hours = (TUNING * len(tuning) + sum(map(seconds, running))) / 3600.0
    console.print(f"{len(cells)} cells, {len(running)} of them to be worked on: about {hours:.1f} core-hours at most")
    _all(*work_on_all(tuning, request, jobs, console, tune))
    return dict(zip(cells, _all(*work_on_all(cells, request, jobs, console, run)), strict=True))


def seconds(cell: Cell) -> float:
    """CPU-seconds that a cell takes at most, by measurement."""
    shifts = cell.blocks[-1] / cell.problem.simulation().most_steps
    return SHIFT * shifts + JUDGING * len(cell.blocks)


def _all(found: list[FoundT], failed: Mapping[CellT, str]) -> list[FoundT]:
    if failed:
        cell, why = next(iter(failed.items()))
        raise GrindError(f"{len(failed)} of {len(failed) + len(found)} cells failed: {cell}: {why}")
    return found

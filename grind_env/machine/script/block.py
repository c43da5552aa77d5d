"""A cycle block of a script, the motions up to the next block, and its part."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from grind_env.control import CyclePlan, Motion, Position, Programs
from grind_env.control.words import Block
from grind_env.errors import GrindError
from grind_env.machine.axes import cross_axis
from grind_env.machine.dress.program import DressPlan, DressRun
from grind_env.machine.job import Job, Station
from grind_env.machine.part.feeds import FEED


class ScriptError(GrindError):
    """A program whose strokes depend on more than the program."""


class RestTimes(NamedTuple):
    """The time of the program with the table at rest, s, from a cycle block to the next one."""

    before: float = 0.0
    """Time until the operator takes off or gauges the part, or until the next block without such a stop, s."""
    after: float = 0.0
    """Time after that stop, s."""


@dataclass(slots=True)
class ScriptBlock:
    """A cycle block, or a feed move that is a stroke, with the motions up to the next block."""

    block: Block
    inch: bool
    plan: CyclePlan
    start: Position  # position of the axes at its start, mm
    end: Position  # position of the axes at the end of the cycle, mm, before any motion beside the table
    taken_over: bool  # whether it takes over a reciprocating table
    dress: DressRun | None
    # depth of its deepest stroke over the part, with the words of the program, mm; 0 if none goes below the surface
    reached: float = 0.0
    # motions of the program beside the moving table, with dwells, in their order
    beside: list[Motion] = field(default_factory=list)
    # whether the table then continues to the secondary point, where the next cycle takes over
    to_secondary: bool = False
    at_secondary: bool = True  # whether the table came to rest there before the way to the next block
    # way to the next block from secondary and primary point at the begin of the crossover, then at its end
    rest_times: tuple[RestTimes, ...] = ()
    gauged: bool = False  # whether the operator gauges or takes off the part before the next block
    gauged_on_the_way: bool = False
    gauged_at_rest: bool = False
    stops: int = 0  # M01 met on the way with the part on the machine
    ends_part: bool = False  # whether the part is removed, or strokes move to another station
    # whether the first block on a part follows a loading, and not a change to another station
    loads: bool = True
    station: int | None = None  # station of its part, from 0; None without stations, or if its strokes meet none

    @property
    def strokes_alone(self) -> bool:
        return self.plan.plunges or self.plan.code == FEED

    @property
    def dress_plan(self) -> DressPlan | None:
        return None if self.dress is None else self.dress.plan

    @property
    def takes_dresses(self) -> bool:
        return self.plan.plunges and self.plan.program is not None

    @property
    def crosses(self) -> bool:
        return self.plan.cross_axis is not None and self.plan.cross_start != self.plan.cross_end


def script_error(programs: Programs, line: int, reason: str) -> ScriptError:
    """Return the error for a program that has no script."""
    place = f"{programs.name}:{line}" if line else programs.name
    return ScriptError(f"{place}: there is no script of this program: {reason}; the control runs it step by step")


def edge_of(position: Position, plan: CyclePlan) -> float:
    """Return the cross coordinate of the wheel's edge on the minus side at a position, mm."""
    return position[cross_axis(plan.axis)]


def jobs_of(job: Job, blocks: Sequence[ScriptBlock]) -> Iterator[Job]:
    """Yield the job of the part of each block; `job` lists the stations met."""
    number = 1
    for block in blocks:
        yield job.of_part(number)
        number += block.ends_part


def met_by(programs: Programs, job: Job, blocks: Sequence[ScriptBlock]) -> tuple[Station, ...]:
    """Return the stations of the parts in turn, and mark in the blocks where a part ends and the next begins."""
    if not job.stations:
        return ()
    found = list[Station]()
    for loading in _loadings(blocks):
        here = next((block.station for block in loading if block.station is not None), 0)
        seen, before = list[int](), None
        for block in loading:
            here = here if block.station is None else block.station
            lying = job.lying(block.plan.axis)[here]
            if before is None or here != seen[-1]:
                if here in seen:
                    raise script_error(programs, block.plan.line, f"its strokes come back to station {lying.name}")
                if before is not None:
                    before.ends_part, before.gauged, block.loads = True, True, False
                seen.append(here)
                found.append(lying)
            before = block
    return tuple(found)


def _loadings(blocks: Sequence[ScriptBlock]) -> list[list[ScriptBlock]]:
    found: list[list[ScriptBlock]] = [[]]
    for block in blocks:
        found[-1].append(block)
        if block.ends_part:
            found.append([])
    return [each for each in found if each]

"""A cycle block of a script, the motions up to the next block, and its part."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from grind_env.control import CyclePlan, Motion, Position, Programs
from grind_env.control.block_words import Block
from grind_env.errors import GrindError
from grind_env.machine.axis_roles import cross_axis
from grind_env.machine.dress.dress_run import DressPlan, DressRun
from grind_env.machine.job import Job
from grind_env.machine.part.feed_moves import FEED


class ScriptError(GrindError):
    """A program whose strokes depend on more than the program."""


class RestTimes(NamedTuple):
    """The time of the program with the table at rest, s, from a cycle block to the next one."""

    #: time until the operator takes off or gauges the part, or until the next block without such a stop, s
    before: float = 0.0
    after: float = 0.0  #: time after that stop, s


@dataclass(slots=True)
class ScriptBlock:
    """A cycle block, or a feed move that is a stroke, with the motions up to the next block."""

    block: Block
    inch: bool
    plan: CyclePlan
    start: Position  #: position of the axes at its start, mm
    end: Position  #: position of the axes at the end of the cycle, mm, before any motion beside the table
    taken_over: bool  #: whether it takes over a reciprocating table
    dress: DressRun | None
    # depth of its deepest stroke over the part, with the words of the program, mm; 0 if none goes below the surface
    reached: float = 0.0
    # motions of the program beside the moving table, with dwells, in their order
    side_motions: list[Motion] = field(default_factory=list)
    # whether the table then continues to the secondary point, where the next cycle takes over
    to_secondary: bool = False
    at_secondary: bool = True  #: whether the table came to rest there before the way to the next block
    # way to the next block from secondary and primary point at the begin of the crossover, then at its end
    rest_times: tuple[RestTimes, ...] = ()
    gauged: bool = False  #: whether the operator gauges or takes off the part before the next block
    gauged_on_the_way: bool = False
    gauged_at_rest: bool = False
    stops: int = 0  #: M01 met on the way with the part on the machine
    ends_part: bool = False  #: whether the part is removed, or strokes move to another station
    # whether the first block on a part follows a loading, and not a change to another station
    loads: bool = True
    station: int | None = None  #: station of its part, from 0; None without stations, or if its strokes meet none

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

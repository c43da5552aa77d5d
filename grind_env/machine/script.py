"""A part program as a script: what the control makes of it before a wheel has touched a part.

The control executes the program once, and what it does is written down cycle block by cycle block: the plan of the
cycle, the motions that the program makes beside the table, where the part is gauged and taken off, and how long the way
to the next block takes. `replay` runs a script for many machines at once, with other E, D, J, L and dress settings in
every block.

Where the strokes are not settled by the program alone, because they depend on the wheel, on the operator or on how far
a pick has come, there is no script, and a `ScriptError` says where and why.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

from grind_env.control import (
    Arc,
    CycleAhead,
    CycleEnd,
    CyclePlan,
    CycleStart,
    DressEnd,
    DressStart,
    Dwell,
    Event,
    Execution,
    Hold,
    Infeed,
    InterruptStart,
    Line,
    Motion,
    Position,
    ProgramEnd,
    Programs,
    ProgramStop,
    Rapid,
    Source,
    TableStop,
    execute,
)
from grind_env.control.profile import ramp_time
from grind_env.control.reciprocation import Reversal
from grind_env.control.rules import motion_time, pick_window
from grind_env.control.words import Block
from grind_env.errors import GrindError
from grind_env.machine.axes import AXES, cross_axis, plunge_axis
from grind_env.machine.dress_program import DressPlan, plan_dress
from grind_env.machine.job import Job
from grind_env.machine.settings import OWN_WORDS, Ranges

PROGRAMMED = (Source.PROGRAM, Source.COMPENSATION)


class ScriptError(GrindError):
    """A program whose strokes are not settled by it alone."""


class Way(NamedTuple):
    """The time of the program with the table at rest, s, from a cycle block to the next one."""

    before: float = 0.0
    """Until the part is taken off, or up to the next block if it stays on."""
    after: float = 0.0
    """From then on."""


@dataclass(slots=True)
class ScriptBlock:
    """A cycle block, and what the program does up to the next one.

    Attributes:
        block: as it was read.
        inch: whether it is read in inches.
        plan: of its cycle.
        start: where the axes stand when it begins, mm.
        end: where they stand when the cycle has come to its end, mm, before any motion beside the table.
        taken_over: whether it takes over a table that reciprocates.
        dress: one execution of its dress program; None if it knows none.
        beside: motions of the program beside the table, dwells among them, in their order.
        to_secondary: whether the table then goes on to the secondary point, where the next cycle takes over.
        at_secondary: whether the table came to rest there before the way to the next block.
        ways: that way, from the secondary and from the primary point where the crossover begins, then where it ends.
        gauged: whether the operator gauges or takes off the part before the next block.
        gauged_on_the_way: whether the operator gauges the part while the table reciprocates on.
        stops: M01 met on the way with the part on the machine.
        ends_part: whether the part is taken off.
    """

    block: Block
    inch: bool
    plan: CyclePlan
    start: Position
    end: Position
    taken_over: bool
    dress: DressPlan | None
    beside: list[Motion] = field(default_factory=list)
    to_secondary: bool = False
    at_secondary: bool = True
    ways: tuple[Way, ...] = ()
    gauged: bool = False
    gauged_on_the_way: bool = False
    stops: int = 0
    ends_part: bool = False

    @property
    def takes_dresses(self) -> bool:
        """Whether it may have a D word."""
        return self.plan.plunges and self.plan.program is not None

    @property
    def has_secondary_pick(self) -> bool:
        """Whether it has a Q word; if not, its Q is its J."""
        return any(word.letter == "Q" for word in self.block.words)

    @property
    def crosses(self) -> bool:
        """Whether its strokes lie between two ends of a crossover."""
        return self.plan.cross_axis is not None and self.plan.cross_start != self.plan.cross_end


@dataclass(frozen=True, slots=True)
class Script:
    """A part program as the machine runs it.

    Attributes:
        programs: the program.
        job: the job.
        blocks: its cycle blocks in the order in which they are run.
        approach: time of the program up to the first of them, s.
        ranges: with which its blocks may be run instead of their own words.
    """

    programs: Programs
    job: Job
    blocks: tuple[ScriptBlock, ...]
    approach: float
    ranges: Ranges


def script_of(programs: Programs, job: Job, ranges: Ranges = OWN_WORDS) -> Script:
    """The script of a part program.

    Args:
        programs: what `control.read` or `control.read_file` returned.
        job: part, set-up and wheel.
        ranges: with which its blocks may be run instead of their own words.

    Raises:
        ScriptError: its strokes depend on more than the program.
        ControlError: the program is faulty.
        DressProgramError: the dress program does not dress the wheel.
    """
    as_it_is = _Writer(programs, job)
    blocks = as_it_is.run()
    dressing = [block.takes_dresses for block in blocks] if any(ranges) else None
    corners = [blocks, _Writer(programs, job, dressing, elsewhere=True).run()]
    if (ranges.J or ranges.L) and any(block.crosses for block in blocks):
        corners += [_Writer(programs, job, dressing, elsewhere=turned, across=True).run() for turned in (False, True)]
    else:
        corners += corners
    for block, *others in zip(*corners, strict=True):
        _refuse_led_elsewhere(programs, block, *others)
        across = block.crosses and edge_of(block.end, block.plan) != block.plan.cross_start
        here, ways = (not block.at_secondary) + 2 * across, [each.ways[0] for each in (block, *others)]
        block.ways = ways[here], ways[here ^ 1], ways[here ^ 2], ways[here ^ 3]
        _refuse_slow_picks(programs, job, block, ranges)
        _refuse_turns_inside(programs, job, block)
    _refuse_judged_twice(programs, job, blocks)
    return Script(programs, job, tuple(blocks), as_it_is.approach, ranges)


class _Writer:
    """Executes a program and writes its blocks down.

    Args:
        programs: the program.
        job: the job.
        dressing: blocks in which a dress is asked for, as others may ask for it; None for those of the program alone.
        elsewhere: whether the table comes to rest at its other end at every stop.
        across: whether every crossover comes to its end where it would with a traverse more.
    """

    def __init__(
        self,
        programs: Programs,
        job: Job,
        dressing: Sequence[bool] | None = None,
        *,
        elsewhere: bool = False,
        across: bool = False,
    ) -> None:
        self.programs, self.job, self.dressing = programs, job, dressing
        self.elsewhere, self.across = elsewhere, across
        self.control = replace(job.control, announce_cycles=True, whole_cycles=True)
        self.execution: Execution = execute(programs, self.control)
        self.execution.set_wheel_radius(0.5 * (job.wheel.diameter or job.setup.wheel.diameter))
        self.blocks: list[ScriptBlock] = []
        self.ahead: Block | None = None
        self.plans: dict[int, DressPlan] = {}
        self.way, self.unloaded = [0.0, 0.0], False
        self.stopped = False  # by the operator, with the table running
        self.in_dress = False
        self.approach = 0.0

    def run(self) -> list[ScriptBlock]:
        for event in self.execution:
            self._take(event)
        return self.blocks

    def _take(self, event: Event) -> None:
        match event:
            case CycleAhead():
                self.ahead = event.block
                if self.dressing is not None and self.dressing[len(self.blocks)]:
                    self.execution.choose(D="1")
            case CycleStart():
                self._begin(event.plan)
            case CycleEnd() if event.plan.plunges:
                self._end(event.plan)
            case TableStop():
                self._stand(event.plan)
            case ProgramStop() if not self.in_dress:
                self._stop(event)
            case ProgramEnd():
                self._unload()
                self._close()
            case Infeed():
                raise self._error("a wheel or a tool cuts a groove", event.line)
            case InterruptStart() | Hold():
                raise self._error("the operator comes in between")
            case DressStart():
                self.in_dress = True  # a stop in it lets the operator look after the dresser
                if event.cause == "operator":
                    raise self._error("the operator asks for a dress")
            case DressEnd():
                self.in_dress = False
            case Rapid() | Line() | Arc() | Dwell() if event.source in PROGRAMMED:
                self._move(event)
            case _:
                pass

    def _begin(self, plan: CyclePlan) -> None:
        """A cycle begins."""
        execution, table = self.execution, self.execution.table
        assert table is not None and self.ahead is not None
        taken_over = table.at is not Reversal.START
        if self.blocks:
            self.blocks[-1].to_secondary = taken_over
            self._close()
        else:
            self.approach = sum(self.way)
            self.way, self.unloaded = [0.0, 0.0], False
        if plan.plunge_axis is not None and plan.depth_target > plan.plunge_start:
            raise self._error("its cycle plunges away from the part", plan.line)
        dress = None
        if plan.program is not None:
            if plan.program not in self.plans:
                self.plans[plan.program] = plan_dress(
                    self.programs, plan.program, self.job, self.control, execution.position, plan.axis
                )
            dress = self.plans[plan.program]
        inch = execution.modes.inch
        here = execution.position
        self.blocks.append(ScriptBlock(self.ahead, inch, plan, here, here, taken_over, dress))
        self.stopped = False

    def _end(self, plan: CyclePlan) -> None:
        """A cycle that plunges has come to its end."""
        if self.across and plan.cross_axis is not None:
            here = edge_of(self.execution.position, plan)
            self.execution.move_axis(plan.cross_axis, plan.cross_end if here == plan.cross_start else plan.cross_start)
        self.blocks[-1].end = self.execution.position

    def _move(self, event: Motion) -> None:
        """The program moves the axes, or waits."""
        table, modes = self.execution.table, self.execution.modes
        if modes.compensation != "G40" or (modes.surface_speed and modes.per_revolution):
            raise self._error("its motions depend on the radius of the wheel", event.line)
        if table is None:
            self.way[self.unloaded] += event.seconds
            return
        if isinstance(event, Arc):
            raise self._error("the wheel moves along an arc beside the table", event.line)
        if self.stopped:
            raise self._error("the table goes on after a stop of the operator", event.line)
        plan = self.blocks[-1].plan
        if (table.primary, table.secondary, table.feed) != (plan.primary, plan.secondary, plan.feed):
            raise self._error("the program redirects the table", event.line)
        self.blocks[-1].beside.append(event)

    def _stand(self, plan: CyclePlan) -> None:
        """The table has come to rest."""
        here = self.execution.position[plan.axis]
        if here not in (plan.primary, plan.secondary):
            raise self._error("the table comes to rest where the cycle before has left it", plan.line)
        self.blocks[-1].at_secondary = here == plan.secondary
        if self.elsewhere:
            there = plan.primary if here == plan.secondary else plan.secondary
            self.execution.move_axis(plan.axis, there)

    def _stop(self, event: ProgramStop) -> None:
        if self.ahead is None or not self.blocks:
            return
        table = self.execution.table
        self.stopped = table is not None
        if table is None or (table.at_secondary and not self.blocks[-1].beside):
            self.blocks[-1].gauged = True
        elif event.code == "M00" or self.job.part.stages or self.job.times.wheel_change is not None:
            raise self._error(
                "the operator judges the part or changes the wheel while the table is on its way", event.line
            )
        else:
            self.blocks[-1].gauged_on_the_way = True
        if event.code == "M00":
            self._unload()
        elif not self.blocks[-1].ends_part:
            self.blocks[-1].stops += 1

    def _unload(self) -> None:
        if self.blocks and not self.blocks[-1].ends_part:
            self.blocks[-1].ends_part = self.blocks[-1].gauged = self.unloaded = True

    def _close(self) -> None:
        """The way from the last block to the next one has been gone."""
        if self.blocks:
            self.blocks[-1].ways = (Way(*self.way),)
        self.way, self.unloaded = [0.0, 0.0], False

    def _error(self, reason: str, line: int = 0) -> ScriptError:
        return _error(self.programs, line or (self.blocks[-1].plan.line if self.blocks else 0), reason)


def _error(programs: Programs, line: int, reason: str) -> ScriptError:
    place = f"{programs.name}:{line}" if line else programs.name
    return ScriptError(f"{place}: there is no script of this program: {reason}; the control runs it step by step")


def _refuse_led_elsewhere(
    programs: Programs, block: ScriptBlock, turned: ScriptBlock, across: ScriptBlock, both: ScriptBlock
) -> None:
    """Refuse a block of which other words in those before, or in itself, change the place.

    Args:
        programs: the program.
        block: as it is.
        turned: where the table has come to rest at its other end.
        across: where the crossovers have come to their other end.
        both: with both.
    """
    line = block.plan.line
    if turned.start != block.start:
        raise _error(programs, line, "its first stroke depends on where the table came to rest before")
    if across.start != block.start or both.start != block.start:
        raise _error(programs, line, "its place depends on where the crossover before came to its end, so on J and L")
    beside, other = ([edge_of(motion.start, each.plan) for motion in each.beside] for each in (block, across))
    if other != beside or (block.gauged_on_the_way and across.end != block.end):
        raise _error(
            programs, line, "the table strokes on where its crossover came to its end, which depends on J and L"
        )


def _refuse_slow_picks(programs: Programs, job: Job, block: ScriptBlock, ranges: Ranges) -> None:
    """Refuse picks that are still under way in the middle of a stroke, or when a dress or the end of the cycle is due.

    The longer a pick, the longer it takes, so that the highest J settles it.
    """
    plan, control = block.plan, job.control
    if not plan.plunges:
        return
    length, rate = abs(plan.primary - plan.secondary), min(plan.pick_feed, control.maximum_feed) / 60.0
    plunge = max([plan.primary_pick, plan.secondary_pick, *ranges.J])
    most = max(plunge, plan.primary_cross_pick, plan.secondary_cross_pick)
    seconds, plunging = (motion_time(pick, rate, control.acceleration) for pick in (most, plunge))
    ends_at_pick = not control.coverage_pass and min([plan.spark_out, *ranges.L]) == 0
    for stroke in (length, abs(plan.primary - block.start[plan.axis])):
        for speed in _speeds_between(
            plan.feed / 60.0, [speed / 60.0 for speed in ranges.E], length, control.acceleration
        ):
            ramp, dwell = ramp_time(stroke, speed, control.acceleration), control.reversal_dwell
            at = f"at E{60.0 * speed:g} mm/min"
            if seconds > pick_window(ramp, dwell, motion_time(length, speed, control.acceleration)):
                reason = "a pick is still under way in the middle of the stroke after it"
                raise _error(programs, plan.line, f"{reason}, one of {most:g} mm {at}")
            if (block.takes_dresses or ends_at_pick) and plunging > ramp + dwell:
                waits = "a dress" if block.takes_dresses else "the end of the cycle"
                raise _error(programs, plan.line, f"{waits} waits for a pick to end, one of {plunge:g} mm {at}")


def _speeds_between(own: float, ends: Sequence[float], length: float, acceleration: float) -> Iterator[float]:
    """Table speeds, mm/s, among which that with the shortest time from a pick to the middle of a stroke is."""
    yield own
    yield from ends
    if ends:
        # the least of ramp + half a stroke, 1.5 v/a + 0.5 length/v
        yield min(max(math.sqrt(acceleration * length / 3.0), min(ends)), max(ends))


def _refuse_turns_inside(programs: Programs, job: Job, block: ScriptBlock) -> None:
    """Refuse strokes that pass over some of the length of the part only."""
    plan, part = block.plan, job.part
    first = block.start[plan.axis]
    for ends in ((plan.primary, plan.secondary), (first, plan.primary)):
        if not (min(ends) <= part.start and part.start + part.length <= max(ends)):
            place = f"{AXES[plan.axis]} turns over the part or beside it"
            raise _error(programs, plan.line, f"{place}, from {min(ends):g} to {max(ends):g} mm")


def _refuse_judged_twice(programs: Programs, job: Job, blocks: Sequence[ScriptBlock]) -> None:
    """Refuse stages that end without a cycle of their own."""
    left = len(job.part.stages)
    for block in blocks:
        ended = min(block.stops, left)
        if ended + block.ends_part > 1:
            raise _error(programs, block.plan.line, "after this cycle the part is judged more than once")
        left = len(job.part.stages) if block.ends_part else left - ended


def depth_of(position: Position, plan: CyclePlan, job: Job) -> float:
    """Depth of the wheel below the touched-off surface at a position, mm."""
    return job.part.surface - position[plunge_axis(plan.axis)]


def edge_of(position: Position, plan: CyclePlan) -> float:
    """Cross coordinate of the wheel's edge on the minus side at a position, mm."""
    return position[cross_axis(plan.axis)]

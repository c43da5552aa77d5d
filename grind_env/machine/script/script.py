"""A part program as a script: what the control makes of it before a wheel has touched a part.

The control executes the program once, and what it does is written down cycle block by cycle block: the plan of the
cycle, the motions that the program makes beside the table, where the part is gauged and taken off, and how long the way
to the next block takes. `replay` runs a script for many machines at once, with other E, D, J, L and dress settings in
every block.

Where the strokes are not settled by the program alone, because they depend on the wheel, on the operator or on how far
a pick has come, there is no script, and a `ScriptError` says where and why.
"""

import functools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from grind_env.control import (
    Arc,
    CycleAhead,
    CycleEnd,
    CyclePlan,
    CycleStart,
    CycleStrokes,
    DressEnd,
    DressStart,
    Dwell,
    Event,
    Execution,
    FeedAhead,
    Hold,
    Infeed,
    InterruptStart,
    Line,
    Motion,
    ProgramEnd,
    Programs,
    ProgramStop,
    Rapid,
    Source,
    Spindle,
    Stroke,
    Switch,
    TableStop,
    execute,
)
from grind_env.control.flow import TEXT_END
from grind_env.control.reciprocation import Reversal
from grind_env.control.words import Block
from grind_env.machine.axes import cross_axis, plunge_axis
from grind_env.machine.dress.dressing import DressRuns
from grind_env.machine.dress.mounting import first_diameter
from grind_env.machine.dress.program import missed_pass
from grind_env.machine.grind import refuse_unjudged
from grind_env.machine.job import Job
from grind_env.machine.loops.zones import strip_centres
from grind_env.machine.part.feeds import feed_stroke, keeps_across, table_axis
from grind_env.machine.part.running import Running
from grind_env.machine.part.stations import Swept, alone, met, sweep_of, sweep_of_plan, touched
from grind_env.machine.script.block import RestTimes, ScriptBlock, ScriptError, edge_of, script_error
from grind_env.machine.script.bounds import (
    refuse_judged_twice,
    refuse_led_elsewhere,
    refuse_slow_picks,
    refuse_turns_inside,
    refuse_unlike_parts,
)
from grind_env.machine.script.parts import jobs_of, met_by
from grind_env.machine.script.settings import OWN_WORDS, Ranges
from grind_env.presenter import html

PROGRAMMED = (Source.PROGRAM, Source.COMPENSATION)


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

    def _repr_html_(self) -> str:
        return html("scripts", self)


def script_of(
    programs: Programs, job: Job, ranges: Ranges = OWN_WORDS, variables: Mapping[int, float] | None = None
) -> Script:
    """The script of a part program.

    Args:
        programs: what `control.read` or `control.read_file` returned.
        job: part, set-up and wheel.
        ranges: with which its blocks may be run instead of their own words.
        variables: values that `#` variables have at the start (`Control.variables`); those of the job if None.

    Raises:
        UnjudgedError: it grinds what is not simulated.
        ScriptError: its strokes depend on more than the program.
        ControlError: the program is faulty.
        DressProgramError: the dress program does not dress the wheel.
    """
    job = job if variables is None else replace(job, variables=variables)
    refuse_unjudged(programs, job)
    refuse_unlike_parts(programs, job)
    writer = functools.partial(_Writer, programs, job)
    as_it_is = writer()
    blocks = as_it_is.run()
    job = replace(job, met=met_by(programs, job, blocks))
    dressing = [block.takes_dresses for block in blocks] if any(ranges) else None
    corners = [blocks, writer(dressing, elsewhere=True).run()]
    if (ranges.J or ranges.L) and any(block.crosses for block in blocks):
        corners += [writer(dressing, elsewhere=turned, across=True).run() for turned in (False, True)]
    else:
        corners += corners
    if len({len(corner) for corner in corners}) > 1:
        reason = "which of its feed moves are strokes depends on where a cycle has come to its end"
        raise script_error(programs, 0, reason)
    for block, *others in zip(*corners, strict=True):
        refuse_led_elsewhere(programs, block, *others)
        across = block.crosses and edge_of(block.end, block.plan) != block.plan.cross_start
        here, ways = (not block.at_secondary) + 2 * across, [each.ways[0] for each in (block, *others)]
        block.ways = ways[here], ways[here ^ 1], ways[here ^ 2], ways[here ^ 3]
        refuse_slow_picks(programs, job, block, ranges)
    for block, on_part in zip(blocks, jobs_of(job, blocks), strict=True):
        refuse_turns_inside(programs, on_part, block)
    refuse_judged_twice(programs, job, blocks)
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
        self.control = replace(job.control, announce_cycles=True, announce_feeds=True, whole_cycles=True)
        self.execution: Execution = execute(programs, self.control)
        self.execution.set_wheel_radius(0.5 * first_diameter(job))
        self.running = Running(job)
        self.blocks: list[ScriptBlock] = []
        self.ahead: Block | None = None
        self.dresses = DressRuns(programs, job, self.control)
        self.way, self.waited = [0.0, 0.0], False
        self.leaving = False  # the part, by an M00 beside which the table has gone on
        self.stopped = False  # by the operator, with the table running
        self.in_dress = False
        self.strokes_on = False  # the table of a G81, after the text
        self.approach = 0.0
        self.feed_ahead: Block | None = None
        self.found = False  # where the wheel stands, for an operator has left it somewhere
        self.fed_by_stroke = False  # whether the F in force is that of a feed move that is a stroke

    def run(self) -> list[ScriptBlock]:
        for event in self.execution:
            self._take(event)
            self._require_independent()
        return self.blocks

    def _require_independent(self) -> None:
        if self.execution.dependent is not None:
            depends = "depends on the wheel, on its dresses or on where a cycle has ended"
            raise self._error(f"it reads #{self.execution.dependent}, which {depends}")
        if (number := self.execution.changing_dress) is not None:
            changes = "leaves offsets, tables, wheel or coolant otherwise than it finds them"
            raise self._error(f"dress program O{number} {changes}, so that dresses move what follows")

    def _take(self, event: Event) -> None:
        table = self.execution.table
        if table is not None and self.blocks and not isinstance(event, CycleStart):
            plan = self.blocks[-1].plan
            if table.refed or (table.primary, table.secondary) != (plan.primary, plan.secondary):
                raise self._error("the program redirects the table", getattr(event, "line", 0))
        match event:
            case CycleAhead():
                self._require_independent()  # for it may lead to blocks that the program as it is does not run
                self.ahead = event.block
                if self.dressing is not None and self.dressing[len(self.blocks) :][:1] == [True]:
                    self.execution.choose(D="1")
            case FeedAhead():
                self.feed_ahead = event.block
            case CycleStart():
                self._begin(event)
            case CycleEnd() if event.plan.plunges:
                self._end(event.plan)
            case Stroke():
                self._require_own_setup(event.cycle.line)
                self._stroke(event)
            case CycleStrokes():
                self._require_own_setup(event.plan.line)
                for plunge, edge in zip(event.plunge, event.cross, strict=True):
                    self._reach(plunge, edge)
            case Spindle():
                self.running.set_speed(event)
            case Switch():
                self.running.switch(event)
            case TableStop():
                self._stand(event.plan)
            case ProgramStop() if not self.in_dress:
                self._stop(event)
            case ProgramEnd():
                if event.cause == TEXT_END and self.strokes_on:
                    raise self._error("the text ends without M30 while a G81 strokes on")
                self._unload()
                self.way[True] = 0.0  # the way from a trailing M00 is no time of a part
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
                self.found |= not isinstance(event, Dwell)
            case _:
                pass

    def _require_own_setup(self, line: int) -> None:
        """Refuse strokes that are ground otherwise than the job says, for a replay knows its set-up alone."""
        if self.running.fault is not None:
            raise self._error(self.running.fault, line)
        if self.running.setup is not self.job.setup:
            if self.running.is_dry:
                raise self._error("the coolant is off in its strokes", line)
            words = "the wheel turns with another speed than the job's in its strokes"
            raise self._error(f"{words}; say {self.running.said_by_job}", line)

    def _stroke(self, event: Stroke) -> None:
        table, axis = self.execution.table, event.axis
        if self.job.stations:
            stations = touched(self.job, sweep_of(alone(event)))
            if stations and self.blocks[-1].station not in stations:
                raise self._error("its strokes go over to another station", event.cycle.line)
        if self.execution.over and table is not None and table.count <= self.control.strokes:
            self.strokes_on |= not event.cycle.plunges
        self._reach(event.middle[plunge_axis(axis)], event.middle[cross_axis(axis)])

    def _reach(self, plunge: float, edge: float) -> None:
        part = self._job.part
        first, last = strip_centres(part.across, part.width).searchsorted((edge, edge + self.job.setup.wheel.width))
        if first < last:
            self.blocks[-1].reached = max(self.blocks[-1].reached, part.surface - plunge)

    @property
    def _station(self) -> int:
        return next((block.station for block in reversed(self.blocks) if block.station is not None), 0)

    @property
    def _job(self) -> Job:
        return self.job.at_station(self._station, self.blocks[-1].plan.axis) if self.job.stations else self.job

    def _begin(self, event: CycleStart) -> None:
        plan = event.plan
        execution, table = self.execution, self.execution.table
        assert table is not None and self.ahead is not None
        taken_over = table.at is not Reversal.START
        if plan.plunges:
            self._require_own_feed(self.ahead)
        self._let_part_go()
        if self.blocks:
            self.blocks[-1].to_secondary = taken_over
        else:
            self.approach = sum(self.way)
        self._close()
        if plan.plunge_axis is not None and plan.depth_target > plan.plunge_start:
            raise self._error("its cycle plunges away from the part", plan.line)
        dress = None
        if plan.program is not None:
            dress = self.dresses.run(plan.program, execution.position, event)
            wheel, diamond = self.job.setup.wheel, self.job.diamond
            missed = diamond and missed_pass(dress, diamond.tip, 0.5 * first_diameter(self.job), wheel.width)
            if missed is not None:
                raise self._error("its dress program misses the diamond", plan.line)
        inch = execution.modes.inch
        here = execution.position
        self.blocks.append(ScriptBlock(self.ahead, inch, plan, here, here, taken_over, dress))
        self._lie(sweep_of_plan(plan, here))
        self.stopped = False

    def _end(self, plan: CyclePlan) -> None:
        if self.across and plan.cross_axis is not None:
            here = edge_of(self.execution.position, plan)
            self.execution.move_axis(plan.cross_axis, plan.cross_end if here == plan.cross_start else plan.cross_start)
        self.blocks[-1].end = self.execution.position

    def _move(self, event: Motion) -> None:
        table, modes = self.execution.table, self.execution.modes
        if modes.compensation != "G40" or (modes.surface_speed and modes.per_revolution):
            raise self._error("its motions depend on the radius of the wheel", event.line)
        if table is None:
            stroke = self._feed_stroke(event) if isinstance(event, Line) else None
            if stroke is not None:
                self._begin_feed(stroke)
                return
            if isinstance(event, Line | Arc):
                self._require_own_feed(self.feed_ahead if isinstance(event, Line) else None)
            self.way[self.waited] += event.seconds
            return
        if isinstance(event, Line):
            self._require_own_feed(None)
        if isinstance(event, Arc):
            raise self._error("the wheel moves along an arc beside the table", event.line)
        if self.stopped:
            raise self._error("the table goes on after a stop of the operator", event.line)
        self.blocks[-1].beside.append(event)

    def _feed_stroke(self, move: Line) -> CycleStrokes | None:
        before = self.blocks[-1].plan if self.blocks else None
        axis = self._first_axis if before is None else before.axis
        if axis is None or not self.found:
            return None
        jobs = [self.job.at_station(k, axis) for k in range(len(self.job.stations))] or [self.job]
        strokes = (feed_stroke(move, axis, job, before) for job in jobs)
        return next((each for each in strokes if each is not None), None)

    def _lie(self, sweep: Swept) -> None:
        if self.job.stations:
            self.blocks[-1].station = next(iter(met(self.job, sweep)), None)

    @cached_property
    def _first_axis(self) -> int | None:
        return table_axis(self.programs, self.control, 0.5 * first_diameter(self.job))

    def _begin_feed(self, stroke: CycleStrokes) -> None:
        plan, block, self.feed_ahead = stroke.plan, self.feed_ahead, None
        if block is None or not keeps_across(stroke.start, stroke.end, plan.axis):
            raise self._error("a feed move that is a stroke goes across, or along what is compensated", plan.line)
        if self.job.process.before is not None:
            raise self._error("its process changes what a feed move that is a stroke finds", plan.line)
        self._require_own_setup(plan.line)
        self._let_part_go()
        if not self.blocks:
            self.approach = sum(self.way)
        self._close()
        self.ahead, self.fed_by_stroke, self.stopped = block, True, False
        dress = self.blocks[-1].dress if self.blocks else None
        made = ScriptBlock(block, stroke.inch, plan, stroke.start, stroke.end, False, dress, at_secondary=False)
        self.blocks.append(made)
        self._lie(sweep_of(stroke))
        self._reach(stroke.plunge[0], stroke.cross[0])

    def _require_own_feed(self, block: Block | None) -> None:
        if block is not None and any(word.letter == "F" for word in block.words):
            self.fed_by_stroke = False
        elif self.fed_by_stroke:
            line = 0 if block is None else block.place.line
            reason = "F of a feed move that is a stroke holds on behind it; give what comes after it an F of its own"
            raise self._error(reason, line)

    def _stand(self, plan: CyclePlan) -> None:
        self._let_part_go()
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
        if event.code == "M00":
            self.leaving = True
            if table is None:
                self._let_part_go()
            return
        if self.leaving:
            return
        self.stopped = table is not None
        if table is None or (table.at_secondary and not self.blocks[-1].beside):
            self.blocks[-1].gauged = True
        elif self._job.part.stages or self.job.times.wheel_change is not None:
            raise self._error(
                "the operator judges the part or changes the wheel while the table is on its way", event.line
            )
        else:
            self.blocks[-1].gauged_on_the_way = True
        if not self.blocks[-1].ends_part:
            self.blocks[-1].stops += 1
            if table is None:
                self.blocks[-1].gauged_at_rest = True
                self._wait()

    def _let_part_go(self) -> None:
        if self.leaving:
            self.leaving = self.found = False
            self._unload()

    def _unload(self) -> None:
        if self.blocks and not self.blocks[-1].ends_part:
            self.blocks[-1].ends_part = self.blocks[-1].gauged = True
            self._wait()

    def _wait(self) -> None:
        """The operator begins to load the next part or to gauge this one: the way up to here has been gone before."""
        self.way, self.waited = [sum(self.way), 0.0], True

    def _close(self) -> None:
        if self.blocks:
            self.blocks[-1].ways = (RestTimes(*self.way),)
        self.way, self.waited = [0.0, 0.0], False

    def _error(self, reason: str, line: int = 0) -> ScriptError:
        return script_error(self.programs, line or (self.blocks[-1].plan.line if self.blocks else 0), reason)

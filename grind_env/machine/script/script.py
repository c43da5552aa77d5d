"""A part program as a script: its blocks as the control plans them, before any grinding.

The control executes the program once. For each cycle block the script records the plan of the cycle, the motions of the
program beside the moving table, where the part is gauged and taken off, and the time to the next block. `replay` runs a
script for many machines at once, with other E, D, J, L and dress settings in every block.

A program has no script if its strokes depend on more than the program: on the wheel, the operator or an unfinished
pick. A `ScriptError` then says where and why.
"""

import functools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from grind_env.control import CyclePlan, CycleStrokes, Programs, events, execute
from grind_env.control.block_words import Block
from grind_env.control.control_flow import TEXT_END
from grind_env.control.reciprocation import Reversal
from grind_env.machine.dress.dress_run import DressRun
from grind_env.machine.dress.mounted_wheel import first_diameter
from grind_env.machine.event_consumer import EventConsumer
from grind_env.machine.grind import refuse_unjudged
from grind_env.machine.job import Job, Station
from grind_env.machine.loops.zone_layout import strip_centres
from grind_env.machine.part.feed_moves import FEED, SOURCES, keeps_across
from grind_env.machine.part.parts_under_stroke import sweep_of, touched_stations
from grind_env.machine.script import refusals
from grind_env.machine.script.block_settings import OWN_WORDS, Ranges
from grind_env.machine.script.script_block import RestTimes, ScriptBlock, ScriptError, edge_of, jobs_of, script_error
from grind_env.notebook_loader import html

FEED_ACROSS = "a feed move that is a stroke goes across, or along what is compensated"


@dataclass(frozen=True, slots=True)
class Script:
    """A part program as the machine runs it."""

    programs: Programs  #: the program
    job: Job  #: the job
    blocks: tuple[ScriptBlock, ...]  #: its cycle blocks in the order in which they are run
    approach: float  #: time of the program up to its first block, s
    ranges: Ranges  #: permitted ranges of words that differ from those of the program

    def _repr_html_(self) -> str:
        return html("scripts", self)


def script_of(
    programs: Programs, job: Job, ranges: Ranges = OWN_WORDS, variables: Mapping[int, float] | None = None
) -> Script:
    """Return the script of a part program.

    Args:
        programs: result of `control.read` or `control.read_file`.
        job: part, set-up and wheel.
        ranges: permitted ranges of its words.
        variables: values that `#` variables have at the start (`Control.variables`); those of the job if None.

    Raises:
        UnjudgedError: the program grinds what is not simulated.
        ScriptError: the strokes depend on more than the program.
        ControlError: the program is faulty.
        DressProgramError: the dress program does not dress the wheel.
    """
    job = job if variables is None else replace(job, variables=variables)
    refuse_unjudged(programs, job)
    refusals.refuse_unlike_parts(programs, job)
    writer = functools.partial(_Writer, programs, job)
    as_it_is = writer()
    blocks = as_it_is.run()
    job = replace(job, part_stations=stations_of_parts(programs, job, blocks))
    dressing = [block.takes_dresses for block in blocks] if any(ranges) else []
    corners = [blocks, writer(dressing, elsewhere=True).run()]
    if (ranges.J or ranges.L) and any(block.crosses for block in blocks):
        corners += [writer(dressing, elsewhere=turned, across=True).run() for turned in (False, True)]
    else:
        corners += corners
    if len({len(corner) for corner in corners}) > 1:
        reason = "which of its feed moves are strokes depends on where a cycle has come to its end"
        raise script_error(programs, 0, reason)
    for block, *others in zip(*corners, strict=True):
        refusals.refuse_led_elsewhere(programs, block, *others)
        across = block.crosses and edge_of(block.end, block.plan) != block.plan.cross_start
        here, rest_times = (not block.at_secondary) + 2 * across, [each.rest_times[0] for each in (block, *others)]
        block.rest_times = rest_times[here], rest_times[here ^ 1], rest_times[here ^ 2], rest_times[here ^ 3]
        refusals.refuse_slow_picks(programs, job, block, ranges)
    for block, on_part in zip(blocks, jobs_of(job, blocks), strict=True):
        refusals.refuse_turns_inside(programs, on_part, block)
    refusals.refuse_judged_twice(programs, job, blocks)
    return Script(programs, job, tuple(blocks), as_it_is.approach, ranges)


def stations_of_parts(programs: Programs, job: Job, blocks: Sequence[ScriptBlock]) -> tuple[Station, ...]:
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


class _Writer(EventConsumer):
    """Writer of the blocks of an executed program.

    `dresses_asked` says which blocks have a dress beyond the program's. With `elsewhere` the table comes to rest at
    its other end at every stop; with `across` every crossover ends where one more traverse would end it.
    """

    def __init__(
        self,
        programs: Programs,
        job: Job,
        dresses_asked: Sequence[bool] = (),
        *,
        elsewhere: bool = False,
        across: bool = False,
    ) -> None:
        control = replace(job.control, announce_cycles=True, announce_feeds=True, whole_cycles=True)
        super().__init__(programs, job, control)
        self.dresses_asked, self.elsewhere, self.across = dresses_asked, elsewhere, across
        self.execution = execute(programs, control)
        self.execution.set_wheel_radius(0.5 * first_diameter(job))
        self.blocks: list[ScriptBlock] = []
        self.ahead: Block | None = None
        self.feed_ahead: Block | None = None
        self.way, self.waited = [0.0, 0.0], False
        self.approach = 0.0
        self.stopped = False  # whether the operator has stopped the running table
        self.strokes_on = False  # whether the table of a G81 strokes on after the text
        self.fed_by_stroke = False  # whether the F in force is that of a feed move that is a stroke

    def run(self) -> list[ScriptBlock]:
        for event in self.execution:
            self.take(event)
            self._require_independent()
        return self.blocks

    def _require_independent(self) -> None:
        if self.execution.dependent is not None:
            depends = "depends on the wheel, on its dresses or on where a cycle has ended"
            raise self._error(f"it reads #{self.execution.dependent}, which {depends}")
        if (number := self.execution.changing_dress) is not None:
            changes = "leaves offsets, tables, wheel or coolant otherwise than it finds them"
            raise self._error(f"dress program O{number} {changes}, so that dresses move what follows")

    def take(self, event: events.Event) -> None:
        table = self.execution.table
        if table is not None and self.blocks and not isinstance(event, events.CycleStart):
            plan = self.blocks[-1].plan
            if table.feed_reprogrammed or (table.primary, table.secondary) != (plan.primary, plan.secondary):
                raise self._error("the program redirects the table", getattr(event, "line", 0))
        self.position, modes = self.execution.position, self.execution.modes
        by_radius = modes.compensation != "G40" or (modes.surface_speed and modes.per_revolution)
        if by_radius and isinstance(event, events.Motion) and event.source in SOURCES:
            raise self._error("its motions depend on the radius of the wheel", event.line)
        match event:
            case events.CycleAhead():
                self._require_independent()  # such a value may lead to blocks that the program alone does not run
                self.ahead = event.block
                if self.dresses_asked[len(self.blocks) :][:1] == [True]:
                    self.execution.choose(D="1")
            case events.FeedAhead():
                self.feed_ahead = event.block
            case events.CycleEnd() if event.plan.plunges:
                self._end_cycle(event.plan)
            case events.TableStop():
                self._stand(event.plan)
            case events.Infeed():
                raise self._error("a wheel or a tool cuts a groove", event.line)
            case events.InterruptStart() | events.Hold():
                raise self._error("the operator comes in between")
            case _:
                super().take(event)

    def _require_own_setup(self, line: int) -> None:
        """Refuse strokes with another set-up than that of the job, because a replay knows only this one."""
        if self.running.fault is not None:
            raise self._error(self.running.fault, line)
        if self.running.setup is not self.job.setup:
            if self.running.is_dry:
                raise self._error("the coolant is off in its strokes", line)
            words = "the wheel turns with another speed than the job's in its strokes"
            raise self._error(f"{words}; say {self.running.said_by_job}", line)

    def make_strokes(self, event: CycleStrokes, number: int) -> None:
        block, table, plan = self.blocks[-1], self.execution.table, event.plan
        self._require_own_setup(plan.line)
        stations = touched_stations(self.job, sweep_of(event)) if self.job.stations else ()
        if stations and block.station not in stations:
            raise self._error("its strokes go over to another station", plan.line)
        if plan.code == FEED:
            block.end = event.end
            if not keeps_across(event.start, event.end, plan.axis):
                raise self._error(FEED_ACROSS, plan.line)
        elif self.execution.over and table is not None and table.count <= self.control.strokes:
            self.strokes_on |= not plan.plunges
        part, width = self._job.part, self.job.setup.wheel.width
        for plunge, edge in zip(event.plunge, event.cross, strict=True):
            if part.surface - plunge > block.reached:
                first, last = strip_centres(part.across, part.width).searchsorted((edge, edge + width))
                block.reached = part.surface - plunge if first < last else block.reached

    @property
    def _job(self) -> Job:
        if not self.job.stations:
            return self.job
        station = next((block.station for block in reversed(self.blocks) if block.station is not None), 0)
        return self.job.at_station(station, self.axis)

    def begin_block(self, time: float, plan: CyclePlan, stations: Sequence[int], dress: DressRun | None) -> None:
        table, here, ahead = self.execution.table, self.position, self.ahead
        taken_over, by_feed = table is not None and table.at is not Reversal.START, plan.code == FEED
        if by_feed:
            ahead, self.feed_ahead, self.fed_by_stroke = self.feed_ahead, None, True
            dress = self.blocks[-1].dress if self.blocks else None
            if self.job.process.before is not None:
                raise self._error("its process changes what a feed move that is a stroke finds")
        elif plan.plunges:
            self._require_own_feed(ahead)
            if plan.depth_target > plan.plunge_start:
                raise self._error("its cycle plunges away from the part")
        if ahead is None:
            raise self._error(FEED_ACROSS)
        if plan.program is not None and self.dressing.missed[plan.program] is not None:
            raise self._error("its dress program misses the diamond")
        if self.blocks:
            self.blocks[-1].to_secondary = taken_over
        else:
            self.approach = sum(self.way)
        self._close()
        self.stopped, self.unloaded_at = False, None
        inch, station = self.execution.modes.inch, next(iter(stations), None)
        block = ScriptBlock(ahead, inch, plan, here, here, taken_over, dress, at_secondary=not by_feed, station=station)
        self.blocks.append(block)

    def _end_cycle(self, plan: CyclePlan) -> None:
        if self.across and plan.cross_axis is not None:
            here = edge_of(self.position, plan)
            self.execution.move_axis(plan.cross_axis, plan.cross_end if here == plan.cross_start else plan.cross_start)
        self.blocks[-1].end = self.execution.position

    def move(self, event: events.Motion) -> None:
        table = self.execution.table
        if event.source not in SOURCES:
            return
        if isinstance(event, events.Line | events.Arc):
            self._require_own_feed(self.feed_ahead if table is None and isinstance(event, events.Line) else None)
        if table is None:
            self.way[self.waited] += event.seconds
        elif isinstance(event, events.Arc):
            raise self._error("the wheel moves along an arc beside the table", event.line)
        elif self.stopped:
            raise self._error("the table goes on after a stop of the operator", event.line)
        else:
            self.blocks[-1].side_motions.append(event)

    def coming_jobs(self) -> Sequence[Job]:
        return (self.job,)

    def _require_own_feed(self, block: Block | None) -> None:
        if block is not None and any(word.letter == "F" for word in block.words):
            self.fed_by_stroke = False
        elif self.fed_by_stroke:
            line = 0 if block is None else block.place.line
            reason = "F of a feed move that is a stroke holds on behind it; give what comes after it an F of its own"
            raise self._error(reason, line)

    def _stand(self, plan: CyclePlan) -> None:
        self.take_pending_part_off()
        here = self.position[plan.axis]
        if here not in (plan.primary, plan.secondary):
            raise self._error("the table comes to rest where the cycle before has left it", plan.line)
        self.blocks[-1].at_secondary = here == plan.secondary
        if self.elsewhere:
            there = plan.primary if here == plan.secondary else plan.secondary
            self.execution.move_axis(plan.axis, there)

    def start_dress(self, event: events.DressStart) -> None:
        if event.cause == "operator":
            raise self._error("the operator asks for a dress")
        super().start_dress(event)

    def end_dress(self, event: events.DressEnd) -> None:
        self.dressing.under_way = None

    def gauge(self, event: events.ProgramStop) -> None:
        block, table = self.blocks[-1], self.execution.table
        self.stopped = table is not None
        if table is None or (table.at_secondary and not block.side_motions):
            block.gauged = True
        elif self._job.part.stages or self.job.times.wheel_change is not None:
            raise self._error(
                "the operator judges the part or changes the wheel while the table is on its way", event.line
            )
        else:
            block.gauged_on_the_way = True
        if self.unloaded_at is None:
            block.stops += 1
            if table is None:
                block.gauged_at_rest = True
                self._wait()

    def take_off(self, time: float, stop: events.ProgramStop | None) -> float:
        self.blocks[-1].ends_part = self.blocks[-1].gauged = True
        self._wait()
        return time

    def end(self, event: events.ProgramEnd) -> None:
        if event.cause == TEXT_END and self.strokes_on:
            raise self._error("the text ends without M30 while a G81 strokes on")
        if self.blocks:
            self.unload(event.time)
        self.way[True] = 0.0  # the time after a final M00 belongs to no part
        self._close()

    def _wait(self) -> None:
        """Begin the loading of the next part or the gauging of this one: all time up to here is before that stop."""
        self.way, self.waited = [sum(self.way), 0.0], True

    def _close(self) -> None:
        if self.blocks:
            self.blocks[-1].rest_times = (RestTimes(*self.way),)
        self.way, self.waited = [0.0, 0.0], False

    def _error(self, reason: str, line: int = 0) -> ScriptError:
        return script_error(self.programs, line or self.line, reason)

"""Run a part program on the machine, one control event at a time, with the clock of the job."""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import ClassVar

import numpy as np

from grind_env.array_types import Array
from grind_env.control import Control, CyclePlan, CycleStrokes, Execution, Programs, events
from grind_env.control.cycles import list_codes
from grind_env.errors import GrindError
from grind_env.machine.axis_roles import cross_axis
from grind_env.machine.dress.dress_run import NO_DRESS, DressPlan, DressProgramError, DressRun
from grind_env.machine.dress.dress_severity import NO_SHARPENING, sharpening_of
from grind_env.machine.dress.mounted_wheel import Mount
from grind_env.machine.event_consumer import EventConsumer
from grind_env.machine.job import Job, PartConditions, Station, require_conditions
from grind_env.machine.loops.cycle import dress_lead
from grind_env.machine.part.compiled_strokes import Dressed
from grind_env.machine.part.feed_moves import FEED, keeps_across, leads_over
from grind_env.machine.part.groove_cuts import infeed_depth
from grind_env.machine.part.part import ANYWHERE, PartRun, StageResult
from grind_env.machine.part.parts_under_stroke import Swept, cycle_stations, sweep_of, touched_stations
from grind_env.machine.part.stroke_record import NUMBERS_FROM, STROKE_ROW, WheelSeen, table_of
from grind_env.machine.part.unsimulated_cuts import Unjudged
from grind_env.machine.record import DRESS_ROW, PART_ROW, GrindingRecord, RowLog
from grind_env.machine.warnings import RunWatch
from grind_env.machine.warnings.texts import BEYOND_NUMBERS, missed_diamond
from grind_env.process.cost import STALL
from grind_env.process.process_interface import Drive, Moment
from grind_env.process.stroke_types import WheelState


class GrindingError(GrindError):
    """A program that grinds nothing, or a job outside the range of the process model."""


class GrindingRun(EventConsumer):
    """State of a run; pass every event of the execution to `take`."""

    def __init__(self, programs: Programs, job: Job, control: Control) -> None:
        super().__init__(programs, job, control)
        self.delay = 0.0  # job's clock less control's clock, s: loading, set-up of dresses
        self.mount, self.drive = Mount(job), Drive(1.0, control.reversal_dwell)  # true speed and dwell of the table
        self.watch = RunWatch(programs.name, job, control)
        self.strokes, self.dresses, self.parts = map(RowLog, (STROKE_ROW, DRESS_ROW, PART_ROW))  # rows so far
        self.plunged = bytearray()  # for each stroke, 1 if it went deeper at some place than all before
        self.stages: list[tuple[StageResult, ...]] = []
        self.unjudged: list[tuple[Unjudged, ...]] = []
        self.blocks: dict[int, int] = {}
        self.cycles: dict[int, CyclePlan] = {}
        self._left: dict[int, PartRun] = {}  # parts of this loading left for other stations, by station
        self._shared: dict[int, Unjudged] = {}  # stations of this loading whose strokes met others, too
        self._part_stations: list[Station] = []  # stations of the parts taken off, in machine coordinates
        self._unmet = {each.name for each in job.stations}
        self._first_dress_at_station = False  # whether the dress program is new at this station
        self.part = self._load(0.0)
        self.gauged_at: float | None = None

    @property
    def wheel(self) -> WheelState | None:
        return self.mount.wheel

    def record(self) -> GrindingRecord:
        return GrindingRecord(
            self.strokes.table(),
            self.dresses.table(),
            self.parts.table(),
            tuple(tuple(each.passed for each in ended[:-1]) for ended in self.stages),
            tuple(self.unjudged),
            tuple(self.watch.notices.sentences),
            self.blocks,
            self.cycles,
            self.programs,
            replace(self.job, part_stations=tuple(self._part_stations)),
        )

    @property
    def parts_before(self) -> int:
        return len(self.parts) if self.unloaded_at is not None else self.part.number - 1

    def tell(self, execution: Execution) -> None:
        """Give the control the current wheel radius, and the true speed and dwell of the table."""
        execution.set_wheel_radius(0.5 * self.mount.diameter)
        execution.set_table(*self.drive)
        if self._first_dress_at_station:
            execution.forget_dresses()
            self._first_dress_at_station = False

    def clock(self, time: float) -> float:
        """Return the time of the job at a time of the control, s, with times outside the program, such as loading."""
        return time + self.delay

    def _load(self, began: float, station: int = ANYWHERE, axis: int = 0) -> PartRun:
        number = len(self.parts) + len(self._left) + 1
        require_conditions(self.job.parts, number, self.programs.name)
        conditions = self.job.parts[number - 1] if self.job.parts else PartConditions()
        self.mount.gauge()
        job, changed = self._job_at(station, axis), self.mount.changes > 0
        return PartRun(number, job, conditions, began, new_wheel=changed, station=station)

    def _untouched(self, station: int, axis: int) -> PartRun:
        return PartRun(0, self._job_at(station, axis), PartConditions(), 0.0, station=station)

    def _job_at(self, station: int, axis: int) -> Job:
        return self.job if station == ANYWHERE else self.job.at_station(station, axis)

    def _begin_cutting(self, time: float, axis: int = 0, stations: Sequence[int] = ()) -> bool:
        """End the loading or gauging of the part; return whether the part was loaded after the last cycle.

        A part that is not cut after an M00 does not count.
        """
        if self.unloaded_at is not None:
            self.part, self.unloaded_at = self._load(self.unloaded_at), None
        if self.job.stations:
            self._go_to(time, axis, stations)
        loads = not self.part.cutting
        if loads:
            self.part.cutting = True
            self.part.find_wheel(self.mount.diameter)
            if not self._left:  # all stations are loaded together
                self.delay += max(self.part.began + self.job.times.load - self.clock(time), 0.0)
        if self.gauged_at is not None:
            self.delay += max(self.gauged_at + self.job.times.gauge - self.clock(time), 0.0)
            self.gauged_at = None
        return loads

    def _go_to(self, time: float, axis: int, stations: Sequence[int]) -> None:
        """Change to the part at the first of the stations met, unless this part is current.

        Strokes in the air, before any part is met, count for the part that is met first.
        """
        part = self.part
        if self._leaves_for(stations):
            self._change_worn_wheel(time)
            part.spent += self.clock(time) - part.began
            self.watch.leave(part)
            self._left[part.station] = part
            self.mount.leave(part.station)
            back = self._left.pop(stations[0], None)
            self.part = self._load(self.clock(time), stations[0], axis) if back is None else back
            if back is not None:
                back.began = self.clock(time)
                self.mount.come_back(back.station, back.p)
                self.mount.gauge()
                if self.mount.changes > 0:
                    back.change_wheel()
        elif not part.is_met and (stations or part.station == ANYWHERE):
            self.part = self._load(part.began, stations[0] if stations else 0, axis)
            self.part.cutting, self.part.tally = part.cutting, part.tally
        self.part.is_met |= bool(stations)
        beside = [k for k in self.station_numbers if k != self.part.station]
        self.watch.obstacles.other_parts = [self._left.get(k) or self._untouched(k, axis) for k in beside]

    def _leaves_for(self, stations: Sequence[int]) -> bool:
        return bool(stations) and self.part.is_met and self.part.station not in stations

    def expect(self, time: float, sweep: Swept) -> None:
        """Prepare for a block over this range with the table at rest: change a worn wheel between stations.

        A caller that chooses the words of each block calls this before; otherwise the block itself does it.
        """
        if self.unloaded_at is None and self._leaves_for(cycle_stations(self.job, sweep)):
            self._change_worn_wheel(time)

    def _meet(self, line: int, stations: Sequence[int]) -> None:
        """Note the stations that a block meets; parts met together are not judged, because this is not simulated."""
        names = [self.job.stations[k].name for k in stations]
        self._unmet.difference_update(names)
        if len(stations) > 1:
            text = (
                f"its strokes meet the parts of stations {', '.join(names[:-1])} and {names[-1]} at once, which is not "
                "simulated, so that these are not judged; grind one station after the other, and turn before the next "
                "one"
            )
            self.watch.notices.tell(line, "stations", text)
            for k in stations:
                lines = {line, *(self._shared[k].lines if k in self._shared else ())}
                self._shared[k] = Unjudged(tuple(sorted(lines)), self._shared[k].why if k in self._shared else text)

    def take_off(self, time: float, stop: events.ProgramStop | None) -> float:
        if stop is not None and time > stop.time:
            self.watch.stops.stroked_on(stop)
        self._change_worn_wheel(time)
        unloaded_at, self.gauged_at = self.clock(time), None
        self.part.spent += unloaded_at - self.part.began
        self.watch.unload(self.part, stop)
        self._left[self.part.station] = self.part
        for station in self._shared.keys() - self._left.keys():
            self._left[station] = self._load(unloaded_at, station, self.axis)
        for part in sorted(self._left.values(), key=lambda part: part.number):
            self._book(part)
        self._left.clear()
        self._shared.clear()
        return unloaded_at

    def _book(self, part: PartRun) -> None:
        if part is not self.part:
            self.watch.take_off(part)
        if part.station in self._shared:
            part.unjudged += (self._shared[part.station],)
        self.parts.add(part.row())
        self.stages.append((*part.ended, part.last_stage))
        self.unjudged.append(part.unjudged)
        if part.station != ANYWHERE:
            self._part_stations.append(Station(name=self.job.stations[part.station].name, part=part.job.part))

    def _change_worn_wheel(self, time: float) -> None:
        p = self.part.p
        if self.mount.change_if_worn(p):
            self.mount.pass_time(self.clock(time), p)
            self.part.change_wheel()
            self.delay += self.job.times.wheel_change or 0.0
            self.mount.pass_time(self.clock(time), p)

    def gauge(self, event: events.ProgramStop) -> None:
        self.part.end_stage()
        self._change_worn_wheel(event.time)
        self.mount.gauge()
        if not event.reciprocating and self.unloaded_at is None:
            self.gauged_at = self.clock(event.time)

    def end(self, event: events.ProgramEnd) -> None:
        if not self.strokes:
            raise GrindingError(
                f"{self.programs.name} makes no stroke and no groove; {list_codes('or')} sets the table going, "
                "G76 or G77 cuts grooves, and without these feed moves grind that go straight along the axis across "
                "G17, G18 or G19, over the part and below its surface"
            )
        self.take_pending_part_off()
        for k in self.station_numbers or [ANYWHERE]:
            if self.unloaded_at is not None and self.watch.obstacles.grinds(self._untouched(k, self.axis)):
                self._begin_cutting(event.time, self.axis, () if k == ANYWHERE else (k,))
        self.unload(event.time)
        self.watch.stops.end()
        for each in self.job.stations:
            if each.name in self._unmet:
                text = f"station {each.name}: no stroke of {self.programs.name} meets its part; "
                self.watch.notices.sentences.append(f"{text}mend its place in [[stations]], or leave it out")
        for line, number in self.dressing.called(self.position, self.axis):
            text = (
                f"M98 P{number} runs the motions of the dress program and dresses nothing; a dress is made by D, by "
                "the .1 form of a cycle, or when the operator asks for one"
            )
            self.watch.notices.tell(line, "call", text)

    def begin_block(self, time: float, plan: CyclePlan, stations: Sequence[int], dress: DressRun | None) -> None:
        if dress is not None and dress.advances and self.job.setup.dresser_infeed is None:
            text = (
                f"dress program O{plan.program} has no infeed; its dresser is taken to advance {dress.plan.depth:g} mm "
                "by itself before each pass; say dresser_infeed in [setup] of the job, or move the wheel towards "
                "the diamond in a block of its own"
            )
            self.watch.notices.tell(0, f"O{plan.program}", text)
        loads, part = self._take_part(time, plan, stations), self.part
        if self.job.process.before is not None:
            part.p = part.nominal
        misses = plan.program is not None and self._misses(plan.program)
        self.mount.take_up(None if dress is None or misses else dress.plan, part.p)
        self.mount.pass_time(self.clock(time), part.p, loads=loads)
        self._take_drive(time, plan)
        self.blocks[plan.line] = plan.block
        if plan.code != FEED:
            self.cycles[plan.line] = plan
        if plan.plunge_axis is not None:
            part.deepest = max(part.deepest, part.job.part.surface - plan.depth_target)
        if plan.program is not None and plan.dresses > 0:
            self._first_dress_at_station = self.dressing.is_first_at_station(plan.program, part.station)

    def _take_part(self, time: float, plan: CyclePlan, stations: Sequence[int]) -> bool:
        self._meet(plan.line, stations)
        loads = self._begin_cutting(time, plan.axis, stations)
        self.part.take_up(self.running.setup)
        self.part.find_wheel(self.mount.diameter)
        self.watch.start_cycle(self.part, plan)
        return loads

    def move(self, event: events.Motion) -> None:
        self.watch.obstacles.move(event, found=self.found)

    def is_feed_block(self, ahead: events.FeedAhead) -> bool:
        axis, jobs = self.along
        place = ahead.start, ahead.end
        return any(leads_over(*place, axis, job) for job in jobs) and keeps_across(*place, axis)

    def coming_jobs(self) -> Sequence[Job]:
        leaves = self.pending_stop is not None
        if self.unloaded_at is None and not leaves:
            return () if self.part.infeeds and not self.part.strokes else (self.part.job,)
        number = len(self.parts) + leaves
        return (self.job.of_part(number + 1),)

    def _take_drive(self, time: float, plan: CyclePlan) -> None:
        """Let the process change wheel and table at the start of a block; `tell` tells the control about the table."""
        if self.job.process.before is not None:
            part = self.part.job.part
            numbers = self.begun - 1, self.clock(time), part.start + 0.5 * part.length, plan.feed
            moment = Moment(*map(float, numbers))
            self.part.p, self.drive = self.mount.begin(moment, self.control.reversal_dwell, self.part.p)

    def end_dress(self, event: events.DressEnd) -> None:
        number = event.program
        place = f"{self.programs.name}:{self.line}: dress program O{number}"
        if not self.running.is_turning:
            raise DressProgramError(f"{place}: the wheel does not turn in it; program M03 before it, and no M05 in it")
        if self.running.speed != self.dressing_speed:
            raise DressProgramError(
                f"{place}: dressing with another wheel speed than that of grinding is not simulated; leave S, G96 and "
                "G97 out of it"
            )
        plan, began, way = self.dressing.end(event, self.axis, self.part.station)
        self.watch.obstacles.dress(self.part, self.dressing.file(number), way, self.axis)
        misses, before, p, time = self._misses(number), self.mount.present(self.part.p), self.part.p, self.clock(began)
        done = Dressed(0.0, before.ds, 0.0, 0.0, 0.0)
        if not misses:
            self.watch.cuts.dress(self.line, plan)
            self.mount.pass_time(time, p)
            before = self.mount.present(p)
            removed = self.mount.dress(plan, p)
            done = Dressed(0.0, self.mount.diameter, removed, dress_lead(before, plan.feed, p), before.wd)
        self.delay += plan.seconds - (event.time - began)
        if not misses:  # a missed dress is a wait up to the next stroke
            self.mount.pass_time(self.clock(event.time), p)
        self.part.dress(plan.seconds, done.removed)
        self._add_dress(len(self.strokes), time, event.cause, number, plan, done)
        self.watch.cuts.diameter(done.ds)

    def _add_dress(self, after: int, time: float, cause: str, number: int, plan: DressPlan, done: Dressed) -> None:
        sharpening = NO_SHARPENING
        if done.lead > 0.0:
            sharpening = sharpening_of(plan.depth, done.lead, done.wd, self.job.setup.dresser, self.part.p)
        row = self.part.number, after, time, cause, number, plan.seconds, done.ds, done.removed
        self.dresses.add((*row, *sharpening))

    def _misses(self, program: int) -> bool:
        missed, diamond = self.dressing.missed[program], self.job.diamond
        if missed is None or diamond is None:
            return False
        width = self.job.setup.wheel.width
        text = missed_diamond(program, diamond.tip, missed.start, missed.end, cross_axis(self.axis), width)
        self.watch.notices.tell(missed.line, "diamond", text, self.dressing.file(program))
        return True

    def make_strokes(self, event: CycleStrokes, number: int) -> None:
        if self.job.stations and (stations := touched_stations(self.job, sweep_of(event))):
            self._meet(event.plan.line, stations)
            if self.part.station not in stations:  # the table goes on; a cycle begins at its station
                loads = self._take_part(event.begins[0], event.plan, stations)
                self.mount.pass_time(self.mount.memory_time, self.part.p, loads=loads)
        if self._take_up_running(event.plan.line):
            self._take_drive(event.begins[0], event.plan)
        part, plan, count = self.part, event.plan, len(event.begins)
        dress = NO_DRESS if plan.program is None else self.dressing.plans[plan.program]
        misses = bool(event.dresses) and plan.program is not None and self._misses(plan.program)
        due, began, delays = [after for after, _ in event.dresses], [], np.full(count, self.delay)
        for after, time in event.dresses:
            began.append(self.clock(time))
            self.delay += dress.seconds
            delays[after:] = self.delay
        rows = np.empty(count, STROKE_ROW)
        rows["part"], rows["line"], rows["groove"] = part.number, plan.line, 0
        rows["number"] = np.arange(number, number + count)
        rows["time"], rows["seconds"], rows["E"] = delays + event.begins, event.seconds, event.feed
        rows["Z"] = part.job.part.surface - np.array(event.plunge)
        before, had_stalled = self.mount.present(part.p), part.stalled
        self.watch.obstacles.judge(part, plan.axis, event.begins[0])
        effective = [] if misses else due
        edges = np.array(event.cross)
        table = (plan.primary, plan.secondary), self.control.acceleration
        dressed, plunged = part.grind(rows, event.ends(0), event.turns, edges, *table, self.mount, effective, dress)
        if misses:
            dressed = np.array([Dressed(0.0, rows["ds"][after - 1], 0.0, 0.0, 0.0) for after in due])
            for _ in due:
                part.dress(dress.seconds, 0.0)
        stalls, stalled = part.stalled and not had_stalled, count
        if stalls:  # bit by bit as a clock that counts stroke by stroke
            stalled = int(np.argmax(rows["torque"] >= STALL))
            rows["time"][stalled + 1 :] = (delays + part.p.stall_time + event.begins)[stalled + 1 :]
        for after, time, each in zip(due, began, map(Dressed._make, dressed.tolist()), strict=True):
            begin = time + (part.p.stall_time if after > stalled else 0.0)
            self._add_dress(len(self.strokes) + after, begin, "auto", plan.program or 0, dress, each)
        self._add(rows, plunged.tobytes(), stalls)
        self.watch.strokes(part, event, rows, before.A, dress, dressed[: len(effective)])

    def _take_up_running(self, line: int) -> bool:
        """Apply wheel speed and coolant before a line grinds; return whether the set-up has changed."""
        fault = self.running.fault
        if fault is not None:
            raise GrindingError(f"{self.programs.name}:{line}: {fault}")
        self.watch.runs(line, self.running, self.mount.diameter)
        return self.part.take_up(self.running.setup)

    def _add(self, rows: Array, plunged: bytes, stalls: bool) -> None:
        """Add rows of strokes or of an infeed, each with a byte of `plunged`; a stall delays all that follows."""
        if not (math.isfinite(sum(self.wheel or ())) and np.isfinite(table_of(rows)[:, NUMBERS_FROM:]).all()):
            raise GrindingError(f"{self.programs.name}:{rows['line'][0]}: {BEYOND_NUMBERS}")
        self.watch.overload.add(rows, self.part.p)
        if stalls:
            self.delay += self.part.p.stall_time
            self.mount.memory_time += self.part.p.stall_time
        self.strokes.extend(rows)
        self.plunged += plunged

    def _infeed(self, event: events.Infeed) -> None:
        if self.job.stations:
            place = f"{self.programs.name}:{event.line}"
            raise GrindingError(f"{place}: a groove is cut, and grooves lie at no station; leave [[stations]] out")
        self.take_pending_part_off()
        self.has_ground = True
        loads = self._begin_cutting(event.begin)
        self.blocks[event.line] = event.block
        if self.job.setup.grooving_wheel:
            self._take_up_running(event.line)
            self.mount.take_up(None, self.part.p)
        self.mount.pass_time(self.clock(event.begin), self.part.p, loads=loads)
        before, had_stalled = self.mount.present(self.part.p), self.part.stalled
        done = self.part.infeed(self.mount, event)
        wheel = self.mount.present(self.part.p)
        Z = infeed_depth(event, self.part.job.part.surface)
        lies = self.clock(event.begin), event.seconds, event.feed, Z, done.b, done.Lw, done.grown
        seen = (getattr(wheel, name) for name in WheelSeen._fields)
        row = self.part.number, event.line, 0, event.groove, *lies, *done.stroke, *seen
        stalls = self.part.stalled and not had_stalled
        self._add(np.array([row], STROKE_ROW), bytes([done.plunged]), stalls)
        if self.job.setup.grooving_wheel:
            self.watch.cuts.infeed(self.part, event, done.stroke, before, wheel)

    HAPPENINGS: ClassVar = {
        **EventConsumer.HAPPENINGS,
        events.Infeed: _infeed,
        events.Pick: lambda self, event: self.watch.picks.pick(event),
        events.Message: lambda self, event: self.watch.message(event),
    }

"""Warnings of a run: one watcher for each matter; all add to the same `Notices`."""

from grind_env.array_types import Array
from grind_env.control import Control, CyclePlan, CycleStrokes, Message, ProgramStop
from grind_env.control.cycle_execution import plunges
from grind_env.machine.dress.dress_run import DressPlan
from grind_env.machine.job import Job
from grind_env.machine.part.feed_moves import speed_word
from grind_env.machine.part.part import PartRun
from grind_env.machine.part.spindle_coolant import Running, RunningWarnings
from grind_env.machine.warnings.cuts import Cuts, Overload, Picks
from grind_env.machine.warnings.idle_cycles import Cycle, Cycles
from grind_env.machine.warnings.moves import ObstacleWatch
from grind_env.machine.warnings.program_stops import Stops
from grind_env.machine.warnings.texts import Notices, over_pick_limits, over_table_limits


class RunWatch:
    """The watchers of a run; an event for a single watcher goes directly to this watcher."""

    def __init__(self, program: str, job: Job, control: Control) -> None:
        self.program, self.job, self.control = program, job, control
        self.notices = notices = Notices(program)
        self.cycles, self.cuts, self.overload = Cycles(notices), Cuts(job, notices), Overload(notices)
        self.picks, self.stops, self.obstacles = Picks(control, notices), Stops(notices), ObstacleWatch(job, notices)
        self._told = RunningWarnings()
        self._last: dict[int, Cycle | None] = {}  # cycle of each part left for another one, by part number

    def message(self, event: Message) -> None:
        self.notices.sentences.append(f"{self.program}: the control says: {event.text}")

    def start_cycle(self, part: PartRun, plan: CyclePlan) -> None:
        if not self.cycles.continues(part, plan):
            self._end_cycle(part)
            self.stops.resume(part, plan)
        self.overload.word = speed_word(plan)
        self.obstacles.judge(part, plan.axis)
        self.cycles.begin(part, plan)
        self.notices.tell(plan.line, "feed", over_pick_limits(plan, self.job.setup.machine))
        if plan.dresses and plan.dresses > (infeeds := plunges(plan)):
            text = (
                f"D{plan.dresses} asks for more dresses than the cycle has plunges, {infeeds}, so that some follow one "
                f"another; give D{infeeds} or less"
            )
            self.notices.tell(plan.line, "dresses", text)

    def runs(self, line: int, running: Running, diameter: float) -> None:
        for subject, text in self._told.of(running, diameter):
            self.notices.tell(line, subject, text)

    def strokes(
        self, part: PartRun, event: CycleStrokes, rows: Array, A: float, dress: DressPlan, dressed: Array
    ) -> None:
        """Watch strokes that were made, with wear flats `A` before the first one.

        `dressed` holds the results of the dresses between them, shape (dresses, fields of `Dressed`), without dresses
        that miss the diamond.
        """
        self.picks.strokes(event)
        longest, machine = self.cycles.count(event, rows), self.job.setup.machine
        word = speed_word(event.plan)
        beyond = over_table_limits(event.feed, longest, self.control.acceleration, machine, event.inch, word)
        self.notices.tell(event.plan.line, "speed", beyond)
        self.cuts.strokes(part, event, rows, A, dress, dressed)
        self.obstacles.stroked_until = event.time

    def leave(self, part: PartRun) -> None:
        self._last[part.number] = self.cycles.cycle
        self._end_cycle(part)
        part.unjudged += tuple(self.cycles.unload())

    def take_off(self, part: PartRun) -> None:
        part.unjudged += tuple(self.obstacles.unjudged(part.station))
        self.stops.unload(part, self._last.pop(part.number, None), None)

    def unload(self, part: PartRun, stop: ProgramStop | None = None) -> None:
        cycle = self.cycles.cycle
        self._end_cycle(part)
        if self.obstacles.axis is not None and (cycle is not None or not part.infeeds):
            self.obstacles.judge(part, self.obstacles.axis)
        others = self.cycles.unload()
        if part.missed:
            text = f"no infeed reaches the part, whose surface is at {part.job.part.surface:g}"
            self.notices.tell(0, "missed", f"{text}; set part.surface to where the wheel touches")
        self.obstacles.unload()
        part.unjudged += (*self.obstacles.unjudged(part.station), *others)
        self.stops.unload(part, cycle, stop)

    def _end_cycle(self, part: PartRun) -> None:
        self.overload.end()
        self.cycles.end(part)

"""The time pattern of a program's strokes, and the machine under repeated runs of the program."""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grind_env.array_types import Floats, Numbers
from grind_env.control import CycleStrokes, DressEnd, DressStart, Event, Line, Programs, ProgramStop, Stroke, execute
from grind_env.control.cycle_formulas import motion_time
from grind_env.envs.job.repeated_program import repeated
from grind_env.machine.job import Job
from grind_env.machine.program_run import GrindingRun
from grind_env.machine.record import GrindingRecord
from grind_env.shop.calibrate.exceptions import CalibrationError

PAUSE = 0.5  #: greatest time between two strokes of one run, s

#: share of strokes that run beside motions of the program, below which their places under a feed override are known
FEW = 0.2


class RepeatedProgram:
    """Program that is run several times with one wheel.

    The control executes it once, because its events depend on no fitted constant. `overrides` has a feed override for
    each part; it is empty for the programmed feed.
    """

    def __init__(self, programs: Programs, job: Job, executions: int = 1, overrides: Sequence[float] = ()) -> None:
        self.programs = repeated(programs, executions)
        self.control = replace(job.control, whole_cycles=True)
        self.events = list(execute(self.programs, self.control))
        record = self._ground(job, ())
        self.placed_parts = [record.job.of_part(k).part for k in range(1, len(record.parts) // executions + 1)]
        parts = record.strokes["part"][record.strokes["groove"] == 0].astype(np.int64)
        self.part = parts[: parts.size // executions] - 1  # part of each stroke of one execution, from 0
        self.overrides = overrides

    def run(self, job: Job) -> GrindingRecord:
        return self._ground(job, self.overrides)

    def _ground(self, job: Job, overrides: Sequence[float]) -> GrindingRecord:
        run, dressing = GrindingRun(self.programs, replace(job, parts=()), self.control), False
        for event in self.events:
            part = run.parts_before
            dressing = isinstance(event, DressStart) or (dressing and not isinstance(event, DressEnd))
            # the effect of a dress follows from its program, whose words the machine has read before
            run.take(scaled(event, overrides[part]) if part < len(overrides) and not dressing else event)
        return run.record()


def scaled(event: Event, override: float) -> Event:
    """Return an event with its feed multiplied by an override."""
    if override != 1.0 and isinstance(event, (Stroke, CycleStrokes, Line)):
        return replace(event, feed=event.feed * override)
    return event


def powers(record: GrindingRecord) -> Floats:
    """Return the power of the strokes above idle, W."""
    return np.asarray(record.strokes["power"][record.strokes["groove"] == 0])


class Pattern(NamedTuple):
    """Strokes of one execution of a program; arrays have a value per stroke.

    A run is a sequence of strokes without an interruption. The time of a dress, a stop or a load is not in the program.
    """

    run: Numbers  #: run of the stroke, from 0
    line: Numbers  #: line of its cycle block
    part: Numbers  #: part that it grinds, from 0
    # whether its cycle crosses: a log does not show which share of the width one stroke cuts, but it shows the power of
    # a whole block
    crosses: NDArray[np.bool_]
    way: Floats  #: length of its path along the table, mm
    near: Floats  #: path before the part begins, mm
    far: Floats  #: path up to the end of the part, mm; as `near` if the stroke passes beside the part
    feed: Floats  #: table speed, mm/s
    # time between its motion and the next stroke of its run, s: the reversal, and picks that the table waits for
    rest: Floats
    pause: Floats  #: shortest pause before each run, s, shape (runs,)
    acceleration: float  #: acceleration of the table, mm/s2
    # whether strokes keep their places under a feed override; they do not if the program moves other axes and dwells
    # beside the table
    overridable: bool

    @property
    def runs(self) -> int:
        return self.pause.size

    @property
    def parts(self) -> int:
        return int(self.part[-1]) + 1

    @property
    def firsts(self) -> Numbers:
        return np.flatnonzero(np.diff(self.run, prepend=-1))

    def times(self, run: int, override: float = 1.0) -> tuple[Floats, Floats, float]:
        """Return when each stroke of a run enters and leaves the part, and when the run ends, s from its start."""
        chosen, a = np.flatnonzero(self.run == run), self.acceleration
        way, speed = self.way[chosen], self.feed[chosen] * override
        ramp = np.minimum(0.5 * speed * speed / a, 0.5 * way)  # path on which the table speeds up, and slows down
        whole = 2.0 * np.sqrt(2.0 * ramp / a) + (way - 2.0 * ramp) / speed
        begin = np.concatenate([[0.0], np.cumsum(whole + self.rest[chosen])])

        def passed(s: Floats) -> Floats:
            """Return when the table has passed the first `s` mm of each stroke, s."""
            early, late = np.sqrt(2.0 * np.maximum(s, 0.0) / a), np.sqrt(2.0 * np.maximum(way - s, 0.0) / a)
            between = np.sqrt(2.0 * ramp / a) + (s - ramp) / speed
            return np.where(s <= ramp, early, np.where(s >= way - ramp, whole - late, between))

        return begin[:-1] + passed(self.near[chosen]), begin[:-1] + passed(self.far[chosen]), float(begin[-1])


def pattern_of(programs: Programs, job: Job) -> Pattern:
    """Return the pattern of a program."""
    strokes: list[Stroke] = []
    breaks, stops = [-math.inf], [-math.inf]
    for event in execute(programs, replace(job.control, whole_cycles=False)):
        if isinstance(event, Stroke):
            strokes.append(event)
        elif isinstance(event, (DressStart, ProgramStop)):
            breaks.append(event.time)
            if isinstance(event, ProgramStop):
                stops.append(event.time)
    ground = [job.part] * len(strokes)
    if job.stations and strokes:
        program = RepeatedProgram(programs, job)
        ground = [program.placed_parts[part] for part in program.part.tolist()]
    ways = np.array([(stroke.start[stroke.axis], stroke.end[stroke.axis]) for stroke in strokes]).reshape(-1, 2)
    way, direction = np.abs(np.diff(ways)), np.where(np.diff(ways) >= 0.0, 1.0, -1.0)
    edges = np.array([(part.start, part.start + part.length) for part in ground]).reshape(-1, 2)
    near, far = np.sort(np.clip((edges - ways[:, :1]) * direction, 0.0, way), axis=1).T
    if not strokes or not np.any(far > near):
        raise CalibrationError(
            f"{programs.name} makes no stroke over the part, so that no power can be compared with a log"
        )
    begin, seconds = (np.array([getattr(stroke, name) for stroke in strokes]) for name in ("begin", "seconds"))
    since, stopped = (np.searchsorted(times, begin + 1e-6) for times in (breaks, stops))
    line = np.array([stroke.cycle.line for stroke in strokes])
    apart = begin[1:] > begin[:-1] + seconds[:-1] + PAUSE
    begins_run = np.append(True, apart | (since[1:] > since[:-1]))
    for k in np.flatnonzero((stopped[1:] > stopped[:-1]) & (line[1:] == line[:-1])).tolist():
        # the table goes on at a stop: only a log shows on which side of the pause the last stroke of a block lies
        begins_run[k + 1 + int(np.argmax(line[k + 1 :] != line[k]))] = True
    run = np.cumsum(begins_run) - 1
    lengths = zip(way[:, 0].tolist(), strokes, strict=True)
    motion = np.array([motion_time(mm, stroke.feed / 60.0, job.control.acceleration) for mm, stroke in lengths])
    same_run = np.append(run[1:] == run[:-1], False)
    rest = np.where(same_run, np.append(np.diff(begin), 0.0), seconds) - motion
    firsts = np.flatnonzero(begins_run)
    pause = np.array([0.0, *(begin[k] - begin[k - 1] - seconds[k - 1] for k in firsts[1:].tolist())])
    return Pattern(
        run=run.astype(np.int64),
        line=line,
        part=RepeatedProgram(programs, job).part,
        crosses=np.array([stroke.cycle.cross_axis is not None for stroke in strokes]),
        way=way[:, 0],
        near=near,
        far=far,
        feed=np.array([stroke.feed / 60.0 for stroke in strokes]),
        rest=np.maximum(rest, 0.0),
        pause=np.maximum(pause, 0.0),
        acceleration=job.control.acceleration,
        overridable=sum(stroke.number is None for stroke in strokes) < FEW * len(strokes),
    )

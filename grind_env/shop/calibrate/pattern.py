"""The time pattern of a program's strokes, and the machine under repeated runs of the program."""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grind_env.arrays import Numbers
from grind_env.control import CycleStrokes, DressEnd, DressStart, Event, Line, Programs, ProgramStop, Stroke, execute
from grind_env.control.rules import motion_time
from grind_env.envs.job.text import repeated
from grind_env.machine.job import Job
from grind_env.machine.record import GrindingRecord
from grind_env.machine.run import GrindingRun
from grind_env.shop.calibrate.errors import CalibrationError
from grind_env.shop.measurements.sheet import Floats

PAUSE = 0.5
"""s; strokes further apart than that are not of one run."""

FEW = 0.2
"""Share of the strokes that may lie beside motions of the program for the rest to be told under an override."""


class Forward:
    """A program that is run several times, the wheel being carried over.

    What the control makes of it depends on no constant that is fitted, so that it executes it once.

    Overrides of the feed are one for every part; none for the feed as programmed.
    """

    def __init__(self, programs: Programs, job: Job, executions: int = 1, overrides: Sequence[float] = ()) -> None:
        self.programs = repeated(programs, executions)
        self.control = replace(job.control, whole_cycles=True)
        self.events = list(execute(self.programs, self.control))
        record = self._ground(job, ())
        self.parts_each = len(record.parts) // executions  # that one execution grinds
        self.lying = [record.job.of_part(number).part for number in range(1, self.parts_each + 1)]
        parts = record.strokes["part"][record.strokes["groove"] == 0].astype(np.int64)
        self.part = parts[: parts.size // executions] - 1  # of each stroke of one execution, from 0
        self.overrides = overrides

    def run(self, job: Job) -> GrindingRecord:
        return self._ground(job, self.overrides)

    def _ground(self, job: Job, overrides: Sequence[float]) -> GrindingRecord:
        run, dressing = GrindingRun(self.programs, replace(job, parts=()), self.control), False
        for event in self.events:
            part = run.parts_before
            dressing = isinstance(event, DressStart) or (dressing and not isinstance(event, DressEnd))
            # what a dress does follows from its program, whose words the machine has read before
            run.take(scaled(event, overrides[part]) if part < len(overrides) and not dressing else event)
        return run.record()


def scaled(event: Event, override: float) -> Event:
    """Return an event as it is under a feed override, with which strokes are slower or faster."""
    if override != 1.0 and isinstance(event, (Stroke, CycleStrokes, Line)):
        return replace(event, feed=event.feed * override)
    return event


def powers(record: GrindingRecord) -> Floats:
    """Return the power of the strokes above idle, W."""
    strokes: Floats = record.strokes["power"][record.strokes["groove"] == 0]
    return strokes


class Pattern(NamedTuple):
    """The strokes of one execution of a program; times in s from its first stroke on, each array a value per stroke.

    A run is a sequence of strokes between which nothing happens: how long a dress, a stop or a load takes is not for
    the program to say.
    """

    run: Numbers  # to which it belongs, from 0
    line: Numbers  # of its cycle block
    part: Numbers  # which of those that one execution grinds, from 0
    # whether it is of a cycle that crosses. Which part of the width one of its strokes cuts depends on more than a log
    # tells; what a whole block of them takes does not
    crosses: NDArray[np.bool_]
    way: Floats  # along the table, mm
    near: Floats  # of that way before the part begins, mm
    far: Floats  # up to where the part ends, mm; as `near` if it passes beside the part
    feed: Floats  # mm/s
    # between its motion and the next stroke of its run, s: the reversal, and picks that the table waits for
    rest: Floats
    pause: Floats  # before each run, the shortest, s, shape (runs,)
    acceleration: float  # of the table, mm/s2
    # whether a feed override leaves its strokes where they are; where the program moves the axes beside the table and
    # dwells, it does not
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
        ramp = np.minimum(0.5 * speed * speed / a, 0.5 * way)  # in which the table speeds up, and as evenly slows down
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
    lying = [job.part] * len(strokes)
    if job.stations and strokes:
        forward = Forward(programs, job)
        lying = [forward.lying[part] for part in forward.part.tolist()]
    ways = [(stroke.start[stroke.axis], stroke.end[stroke.axis]) for stroke in strokes]
    on_part = [
        sorted((_along(part.start, way), _along(part.start + part.length, way)))
        for part, way in zip(lying, ways, strict=True)
    ]
    near, far = (np.array([each[number] for each in on_part]) for number in (0, 1))
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
        # the table goes on at a stop: only a log tells on which side of the pause the last stroke of a block lies
        begins_run[k + 1 + int(np.argmax(line[k + 1 :] != line[k]))] = True
    run = np.cumsum(begins_run) - 1
    motion = np.array(
        [
            motion_time(abs(b - a), stroke.feed / 60.0, job.control.acceleration)
            for (a, b), stroke in zip(ways, strokes, strict=True)
        ]
    )
    same_run = np.append(run[1:] == run[:-1], False)
    rest = np.where(same_run, np.append(np.diff(begin), 0.0), seconds) - motion
    firsts = np.flatnonzero(begins_run)
    pause = np.array([0.0, *(begin[k] - begin[k - 1] - seconds[k - 1] for k in firsts[1:].tolist())])
    return Pattern(
        run=run.astype(np.int64),
        line=line,
        part=Forward(programs, job).part,
        crosses=np.array([stroke.cycle.cross_axis is not None for stroke in strokes]),
        way=np.array([abs(b - a) for a, b in ways]),
        near=near,
        far=far,
        feed=np.array([stroke.feed / 60.0 for stroke in strokes]),
        rest=np.maximum(rest, 0.0),
        pause=np.maximum(pause, 0.0),
        acceleration=job.control.acceleration,
        overridable=sum(stroke.number is None for stroke in strokes) < FEW * len(strokes),
    )


def _along(coordinate: float, way: tuple[float, float]) -> float:
    """Return how far along a path, mm, a coordinate is passed."""
    begin, end = way
    direction = 1.0 if end >= begin else -1.0
    return min(max((coordinate - begin) * direction, 0.0), abs(end - begin))

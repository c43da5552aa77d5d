"""The machine under a program that is run again and again with other constants; `machine.grind`, but read once."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from grind_env.control import CycleStrokes, DressEnd, DressStart, Event, Line, Programs, Stroke, execute
from grind_env.envs.job.text import repeated
from grind_env.machine.job import Job
from grind_env.machine.record import GrindingRecord
from grind_env.machine.run import GrindingRun
from grind_env.shop.measurements.sheet import Floats


class Forward:
    """A program that is run several times, the wheel being carried over.

    What the control makes of it depends on no constant that is fitted, so that it executes it once.

    Args:
        programs: the program.
        job: with which the control executes it.
        executions: how often it is run.
        overrides: of the feed, one for every part; none for the feed as programmed.

    Attributes:
        part: of each stroke of one execution, from 0.
        parts_each: that one execution grinds.
        lying: what these are, and where they lie.
    """

    def __init__(self, programs: Programs, job: Job, executions: int = 1, overrides: Sequence[float] = ()) -> None:
        self.programs = repeated(programs, executions)
        self.control = replace(job.control, whole_cycles=True)
        self.events = list(execute(self.programs, self.control))
        record = self._ground(job, ())
        self.parts_each = len(record.parts) // executions
        self.lying = [record.job.of_part(number).part for number in range(1, self.parts_each + 1)]
        parts = record.strokes["part"][record.strokes["groove"] == 0].astype(np.int64)
        self.part = parts[: parts.size // executions] - 1
        self.overrides = overrides

    def run(self, job: Job) -> GrindingRecord:
        return self._ground(job, self.overrides)

    def _ground(self, job: Job, overrides: Sequence[float]) -> GrindingRecord:
        run, dressing = GrindingRun(self.programs, job, self.control, ()), False
        for event in self.events:
            part = run.parts_before
            dressing = isinstance(event, DressStart) or (dressing and not isinstance(event, DressEnd))
            # what a dress does follows from its program, whose words the machine has read before
            run.take(scaled(event, overrides[part]) if part < len(overrides) and not dressing else event)
        return run.record()


def scaled(event: Event, override: float) -> Event:
    """An event as it is under a feed override, with which strokes are slower or faster."""
    if override != 1.0 and isinstance(event, (Stroke, CycleStrokes, Line)):
        return replace(event, feed=event.feed * override)
    return event


def powers(record: GrindingRecord) -> Floats:
    """Of the strokes of the table, above idle, W."""
    strokes: Floats = record.strokes["power"][record.strokes["groove"] == 0]
    return strokes

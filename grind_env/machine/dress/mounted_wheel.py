"""The wheel on the spindle: its state at the start of a job, dressed, gauged, and changed when it is worn out."""

import functools
from collections.abc import Callable
from typing import Any

import numpy as np

from grind_env.array_types import Array
from grind_env.kernel import entry
from grind_env.kernel.row_accessors import column_reader, column_writer
from grind_env.machine.dress.dress_run import DressPlan
from grind_env.machine.job import Job
from grind_env.machine.loops.block_change import entries_of
from grind_env.machine.loops.cycle import dress_lead
from grind_env.machine.loops.row_io import OWN_FROM
from grind_env.process.process_interface import Drive, Moment, Process
from grind_env.process.stroke_and_dress import dressed_wheel
from grind_env.process.stroke_types import StrokeParameters, WheelState

USUAL_LEAD, USUAL_DEPTH = 0.10, 0.020  #: lead and depth of the dress before a program without dresses, mm


class Mount:
    """The wheel of a run, with the memory of its process."""

    def __init__(self, job: Job) -> None:
        self.job = job
        self.wheel: WheelState | None = None  # None before the first cycle, which mounts it
        self.changes = 0
        self._plan: DressPlan | None = None  # dress of the cycle in force or before
        self._row = np.array([[*[0.0] * OWN_FROM, *job.own_at_start]])
        # memory of the process, shape (1, fields of its `own`), and the time of the job that it stands for, s
        self.own, self.memory_time = self._row[:, OWN_FROM:], 0.0
        self._known = True  # whether the wear is known: until the wheel grinds on
        self._left = dict[int, tuple[Array, float]]()  # row of the wheel, and time, when a station was left

    @property
    def diameter(self) -> float:
        """Return the current wheel diameter; before the first cycle the job's, mm."""
        return first_diameter(self.job) if self.wheel is None else self.wheel.ds

    def present(self, p: StrokeParameters) -> WheelState:
        return first_wheel(self.job, self._plan, p) if self.wheel is None else self.wheel

    def take_up(self, plan: DressPlan | None, p: StrokeParameters) -> None:
        self._plan = self._plan if plan is None else plan
        self.wheel = self.present(p)

    def pass_time(self, time: float, p: StrokeParameters, *, loads: bool = False) -> None:
        """Let the time up to `time` of the job, s, pass without a stroke; `loads` if the part is changed."""
        if self.job.process.idle is not None:
            self._row[0, :OWN_FROM] = self.present(p)
            entries_of(self.job.process).pass_time(self._row, np.array([p]), 0, time - self.memory_time, loads)
            self.wheel = self.wheel and WheelState(*self._row[0, :OWN_FROM].tolist())
            if self._known:
                self.gauge()
        self.memory_time = time

    def leave(self, station: int) -> None:
        self._left[station] = self._row.copy(), self.memory_time

    def come_back(self, station: int, p: StrokeParameters) -> None:
        """Return to a part at a station that lay there while other parts were ground."""
        row, memory_time = self._left.pop(station)
        entries_of(self.job.process).pass_time(row, np.array([p]), 0, self.memory_time - memory_time, False)
        fields = self.job.process.own._fields
        for name in self.job.process.of_part:
            self.own[0, fields.index(name)] = row[0, OWN_FROM + fields.index(name)]

    def set_wheel(self, wheel: WheelState, memory_time: float) -> None:
        self.wheel, self.memory_time, self._known = wheel, memory_time, False

    def begin(self, moment: Moment, dwell: float, p: StrokeParameters) -> tuple[StrokeParameters, Drive]:
        """Begin a cycle block with the control's reversal dwell, s; return the parameters and drive of the block."""
        self._row[0, :OWN_FROM], parameters = self.present(p), np.array([p])
        drive = entries_of(self.job.process).before(self._row, parameters, 0, dwell, moment)
        self.wheel, self._known = WheelState(*self._row[0, :OWN_FROM].tolist()), False
        return StrokeParameters(*parameters[0].tolist()), drive

    def gauge(self) -> None:
        """Gauge the part: the wheel wear becomes known and is compensated."""
        self._known = True
        if self.wheel is not None:
            self.wheel = self.wheel._replace(W=0.0)

    def dress(self, plan: DressPlan, p: StrokeParameters) -> float:
        """Execute a dress program; return the wheel volume dressed off, mm3."""
        dress, self._known = dress_of(self.job.process), False
        self.wheel, removed = dress(self.present(p), self.own, float(plan.passes), plan.feed, plan.depth, p)
        return removed

    def change_if_worn(self, p: StrokeParameters) -> bool:
        if self.wheel is None or self.job.times.wheel_change is None:
            return False
        if self.wheel.ds >= self.job.setup.wheel.minimum_diameter:
            return False
        self.wheel = new_wheel(self.job, self.wheel, self._plan, p)
        self.changes += 1
        return True


@functools.cache
def dress_of(process: Process) -> Callable[..., tuple[WheelState, float]]:
    """Return the compiled `dress(wheel, own, passes, feed, depth, p)`: a dress with a traverse of `feed` mm/s.

    It returns the wheel after the dress and the volume removed, mm3, and updates `own`, shape (1, fields of `own`).
    """
    dress_wheel, read_own, write_own = process.dress, column_reader(process.own), column_writer(process.own)

    @entry
    def dress(
        wheel: WheelState, own: Any, passes: float, feed: float, depth: float, p: StrokeParameters
    ) -> tuple[WheelState, float]:
        lead = dress_lead(wheel, feed, p)
        wheel, left, removed = dress_wheel(wheel, read_own(own, 0), passes, lead, depth, p)
        write_own(own, 0, left)
        return wheel, removed

    return dress


def first_diameter(job: Job) -> float:
    """Return the wheel diameter at the start of the job, mm."""
    return job.setup.wheel.diameter if job.wheel.diameter is None else job.wheel.diameter


def first_wheel(job: Job, plan: DressPlan | None, p: StrokeParameters) -> WheelState:
    """Return the wheel as the job finds it: dressed by the program's dress `plan` unless the job says otherwise."""
    start = job.wheel
    wheel = _dressed(first_diameter(job), start.diamond_flat, plan, p)
    if start.wear_flat_area is not None:
        wheel = wheel._replace(A=start.wear_flat_area)
    if start.volume_since_dress is not None:
        wheel = wheel._replace(V=start.volume_since_dress)
    return wheel


def new_wheel(job: Job, worn: WheelState, plan: DressPlan | None, p: StrokeParameters) -> WheelState:
    """Return the wheel that comes in place of a worn one, dressed by `plan` with the same diamond."""
    return _dressed(job.setup.wheel.diameter, worn.wd, plan, p)


def _dressed(ds: float, diamond_flat: float, plan: DressPlan | None, p: StrokeParameters) -> WheelState:
    wheel = dressed_wheel(ds, diamond_flat, USUAL_LEAD, USUAL_DEPTH, p)
    if plan is None:
        return wheel
    return dressed_wheel(ds, diamond_flat, dress_lead(wheel, plan.feed, p), plan.depth, p)

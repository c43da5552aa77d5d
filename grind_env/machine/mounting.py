"""The wheel as it comes onto the spindle: at the start of a job, and in place of one that is worn out."""

from grind_env.machine.compiled import dress_lead, dressed_wheel
from grind_env.machine.dress_program import DressPlan
from grind_env.machine.job import Job
from grind_env.process.state import StrokeParameters, WheelState

USUAL_LEAD, USUAL_DEPTH = 0.10, 0.020
"""mm; the dress that the wheel has had if the program names none."""


def first_wheel(job: Job, plan: DressPlan | None, p: StrokeParameters) -> WheelState:
    """The wheel as the job finds it: dressed by the program's dress `plan` unless the job says otherwise."""
    start = job.wheel
    ds = job.setup.wheel.diameter if start.diameter is None else start.diameter
    wheel = _dressed(ds, start.diamond_flat, plan, p)
    if start.wear_flat_area is not None:
        wheel = wheel._replace(A=start.wear_flat_area)
    if start.volume_since_dress is not None:
        wheel = wheel._replace(V=start.volume_since_dress)
    return wheel


def is_worn_out(job: Job, wheel: WheelState) -> bool:
    """Whether the operator puts a new wheel in its place at the next stop."""
    return job.times.wheel_change is not None and wheel.ds < job.setup.wheel.minimum_diameter


def new_wheel(job: Job, worn: WheelState, plan: DressPlan | None, p: StrokeParameters) -> WheelState:
    """The wheel that comes in place of a worn one, dressed by `plan` with the same diamond."""
    return _dressed(job.setup.wheel.diameter, worn.wd, plan, p)


def _dressed(ds: float, diamond_flat: float, plan: DressPlan | None, p: StrokeParameters) -> WheelState:
    """A wheel of diameter `ds` (mm) dressed with a diamond of that wear flat (mm)."""
    wheel = dressed_wheel(ds, diamond_flat, USUAL_LEAD, USUAL_DEPTH, p)
    if plan is None:
        return wheel
    return dressed_wheel(ds, diamond_flat, dress_lead(wheel, plan.feed, p), plan.depth, p)

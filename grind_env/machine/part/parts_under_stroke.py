"""The stations that a stroke meets: the parts below its path.

A stroke sweeps the way of the wheel along the table and its width across. It meets a part where the body of the wheel
reaches below the surface of the part somewhere on that way.
"""

from typing import NamedTuple

from grind_env.control import CyclePlan, CycleStrokes, Position, Stroke
from grind_env.control.cycle_formulas import DEPTH_TOLERANCE
from grind_env.machine.axis_roles import cross_axis, plunge_axis
from grind_env.machine.dress.mounted_wheel import first_diameter
from grind_env.machine.dress.wheel_geometry import half_chord
from grind_env.machine.job import Job, Part


class Swept(NamedTuple):
    """Space swept by the wheel in strokes, mm, in machine coordinates."""

    axis: int  #: index of the axis along which the table goes: 0 for X, 1 for Y, 2 for Z
    along: tuple[float, float]  #: range of the centre of the wheel along the table
    edges: tuple[float, float]  #: range of the edge of the wheel on the minus side, across the table
    lowest: float  #: coordinate of the face of the wheel at full depth


def sweep_of_plan(plan: CyclePlan, position: Position) -> Swept:
    """Return the space swept by a cycle that begins at a position, mm."""
    axis, here = plan.axis, position[plunge_axis(plan.axis)]
    ends = position[axis], plan.primary, plan.secondary
    edge = position[cross_axis(axis)]
    edges = (edge,) if plan.cross_axis is None else (edge, plan.cross_start, plan.cross_end)
    lowest = here if plan.plunge_axis is None else min(here, plan.depth_target)
    return Swept(axis, (min(ends), max(ends)), (min(edges), max(edges)), lowest)


def sweep_of(event: CycleStrokes) -> Swept:
    """Return the space swept by finished strokes."""
    ends = *event.ends(0), *event.ends(len(event.begins) - 1)
    edges, axis = event.cross, event.plan.axis
    return Swept(axis, (min(ends), max(ends)), (min(edges), max(edges)), min(event.plunge))


def sweep_between(start: Position, end: Position, axis: int) -> Swept:
    """Return the space swept by a feed move along the table."""
    low, high = sorted((start[axis], end[axis]))
    edge = end[cross_axis(axis)]
    return Swept(axis, (low, high), (edge, edge), end[plunge_axis(axis)])


def touched_stations(job: Job, sweep: Swept) -> tuple[int, ...]:
    """Return the numbers, from 0, of the stations whose parts the strokes touch."""
    found, radius = [], 0.5 * first_diameter(job)
    for number, station in enumerate(job.lying(sweep.axis)):
        depth = station.part.surface - sweep.lowest
        if depth > DEPTH_TOLERANCE and _lies_under(station.part, sweep, half_chord(radius, depth), job):
            found.append(number)
    return tuple(found)


def cycle_stations(job: Job, sweep: Swept) -> tuple[int, ...]:
    """Return the numbers of the stations of a cycle: all that it touches, or the only one below it in the air."""
    found = touched_stations(job, sweep)
    if found:
        return found
    below = [k for k, each in enumerate(job.lying(sweep.axis)) if _lies_under(each.part, sweep, 0.0, job)]
    return tuple(below) if len(below) == 1 else ()


def _lies_under(part: Part, sweep: Swept, reach: float, job: Job) -> bool:
    """Return whether a part lies under a sweep with a wheel that reaches `reach` mm to both sides."""
    (low, high), (near, far) = sweep.along, sweep.edges
    along = low - reach < part.start + part.length - DEPTH_TOLERANCE and part.start + DEPTH_TOLERANCE < high + reach
    width = job.setup.wheel.width
    return along and near < part.across + part.width - DEPTH_TOLERANCE and part.across + DEPTH_TOLERANCE < far + width


def as_cycle_strokes(event: Stroke) -> CycleStrokes:
    """Return a single stroke as a `CycleStrokes` event."""
    axis = event.axis
    return CycleStrokes(
        time=event.finish,
        plan=event.cycle,
        start=event.start,
        feed=event.feed,
        begins=(event.begin,),
        seconds=(event.seconds,),
        plunge=(event.middle[plunge_axis(axis)],),
        cross=(event.middle[cross_axis(axis)],),
        end=event.end,
        dresses=(),
        inch=event.inch,
    )

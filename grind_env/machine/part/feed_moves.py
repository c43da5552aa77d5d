"""Feed moves along the table over the part, which grind like strokes of a cycle.

Such a move goes straight, with the wheel at or below the surface at one depth. If it goes across as well, the wheel has
to cover the width of the part all the way. What is ground by other feed moves is not simulated.
"""

from contextlib import suppress
from dataclasses import replace

from grind_env.control import Control, ControlError, CyclePlan, CycleStrokes, Line, Position, Programs, events, execute
from grind_env.control.cycle_formulas import DEPTH_TOLERANCE
from grind_env.control.modes import PLANES
from grind_env.control.path_geometry import Straight
from grind_env.machine.axis_roles import cross_axis, plunge_axis
from grind_env.machine.dress.mounted_wheel import first_diameter
from grind_env.machine.dress.wheel_geometry import half_chord
from grind_env.machine.job import Job

FEED = "G01"  #: code of the cycle plan of a feed move that is a stroke
FEED_WORD = "F"

#: J of a feed move that is a stroke, mm: any gain in depth counts as a plunge; its L is 1
LEAST_PICK = 2.0 * DEPTH_TOLERANCE

#: sources of moves that may be strokes; moves that an operator asks for in between are no strokes
SOURCES = (events.Source.PROGRAM, events.Source.COMPENSATION)


def speed_word(plan: CyclePlan) -> str:
    """Return the word for the speed of the strokes of a cycle (E) or of a feed move (F)."""
    return FEED_WORD if plan.code == FEED else "E"


def table_axis(programs: Programs, control: Control, radius: float) -> int | None:
    """Return the table axis of a program before its first cycle: the axis of that cycle.

    Without a cycle it is the axis across the plane of the first feed move; None without one, or if grooves are cut,
    because a job does not place them on the part.
    """
    axis, grooves, execution = None, False, execute(programs, replace(control))
    execution.set_wheel_radius(radius)
    with suppress(ControlError):  # a run of the program reports the fault
        for event in execution:
            if isinstance(event, events.CycleStart):
                return event.plan.axis
            if isinstance(event, Line) and axis is None:
                axis = 3 - sum(PLANES[execution.modes.plane])
            grooves |= isinstance(event, events.Infeed)
    return None if grooves else axis


def leads_over(start: Position, end: Position, axis: int, job: Job) -> bool:
    """Return whether a straight move along the table stays at one depth at or below the part's surface."""
    plunge, part = plunge_axis(axis), job.part
    low, high = min(start[axis], end[axis]), max(start[axis], end[axis])
    near, far = part.start + DEPTH_TOLERANCE, part.start + part.length - DEPTH_TOLERANCE
    below = end[plunge] <= part.surface + DEPTH_TOLERANCE
    if not below or abs(end[plunge] - start[plunge]) > DEPTH_TOLERANCE or high < near or low > far or high == low:
        return False
    return _lies_over(start, end, axis, job)


def keeps_across(start: Position, end: Position, axis: int) -> bool:
    """Return whether a move does not go across, so that its F is the table speed."""
    return start[cross_axis(axis)] == end[cross_axis(axis)]


def feed_stroke(move: Line, axis: int, job: Job, before: CyclePlan | None) -> CycleStrokes | None:
    """Return a feed move as a stroke of the table, of a cycle without dresses; None if it is no stroke over the part.

    Its E is the feed along the table, mm/min. The dress program of the strokes `before` stays known.
    """
    start, end, cross = move.start, move.end, cross_axis(axis)
    if move.reciprocating or move.source not in SOURCES or not leads_over(start, end, axis, job):
        return None
    feed = move.feed * (abs(end[axis] - start[axis]) / Straight(start, end).length)
    plan = CyclePlan(
        code=FEED,
        pre_dress=False,
        axis=axis,
        primary=end[axis],
        secondary=start[axis],
        plunge_start=end[plunge_axis(axis)],
        primary_pick=LEAST_PICK,
        spark_out=1,
        feed=feed,
        program=None if before is None else before.program,
        block=move.block,
        line=move.line,
        text="",
    )
    return CycleStrokes(
        time=move.finish,
        plan=plan,
        start=start,
        feed=feed,
        begins=(move.begin,),
        seconds=(move.seconds,),
        plunge=(end[plunge_axis(axis)],),
        cross=(0.5 * (start[cross] + end[cross]),),
        end=end,
        dresses=(),
        inch=move.inch,
    )


def _lies_over(start: Position, end: Position, axis: int, job: Job) -> bool:
    cross, part, width = cross_axis(axis), job.part, job.setup.wheel.width
    way = end[axis] - start[axis]
    if abs(end[cross] - start[cross]) <= DEPTH_TOLERANCE:
        return part.across - width + DEPTH_TOLERANCE < end[cross] < part.across + part.width - DEPTH_TOLERANCE
    # as far as the body of the wheel reaches
    reach = half_chord(0.5 * first_diameter(job), part.surface - end[plunge_axis(axis)])
    sides = part.start - reach, part.start + part.length + reach
    places = (Straight(start, end).point(min(max((side - start[axis]) / way, 0.0), 1.0)) for side in sides)
    least, most = part.across + part.width - width - DEPTH_TOLERANCE, part.across + DEPTH_TOLERANCE
    return all(least <= place[cross] <= most for place in places)

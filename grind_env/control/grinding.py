"""Runs a cycle by its rules: strokes, and what follows the reversals that end them; one by one or all at once."""

import math
from collections.abc import Iterator

from grind_env.control.cycles import RULES
from grind_env.control.interruptions import Interruptions
from grind_env.control.motions import CyclePlan, CycleStrokes, Event
from grind_env.control.profile import ramp_time
from grind_env.control.rules import PICK_TOLERANCE, motion_time
from grind_env.control.timeline import Timeline

Target = tuple[str, int, float]
"""Where a pick leads: "plunge" or "cross", its axis, and the coordinate without what dresses have added to it, mm."""


def turns(plan: CyclePlan, coverage: bool) -> Iterator[tuple[list[Target], int]]:
    """The picks that follow each stroke of a cycle, and the auto-dresses that then fall due.

    Args:
        plan: of the cycle.
        coverage: whether there is a coverage pass (PD-13).
    """
    rules = RULES[plan.code]
    cycle = rules.cycle_of(plan, coverage)
    progress = rules.begin(cycle)
    depth = plan.depth
    while not rules.finished(cycle, progress):
        before, progress = progress, rules.after_reversal(cycle, progress)
        picks: list[Target] = []
        if progress.depth > before.depth:
            assert plan.plunge_axis is not None
            target = _coordinate(plan.plunge_start, plan.depth_target, progress.depth, depth)
            picks.append(("plunge", plan.plunge_axis, target))
        if progress.crossed > before.crossed:
            assert plan.cross_axis is not None
            ends = plan.cross_start, plan.cross_end
            near, far = ends if progress.forward else reversed(ends)
            picks.append(("cross", plan.cross_axis, _coordinate(near, far, progress.crossed, abs(far - near))))
        yield picks, int(progress.dresses)


def grind(plan: CyclePlan, interruptions: Interruptions) -> Iterator[Event]:
    """Work off a cycle stroke by stroke."""
    timeline = interruptions.timeline
    for picks, due in turns(plan, timeline.control.coverage_pass):
        stroke = yield from timeline.finish_stroke()
        for kind, axis, coordinate in picks:
            target = coordinate + timeline.infeed_shift if kind == "plunge" else coordinate
            yield from timeline.pick(stroke, kind, axis, target, plan.pick_feed)
        yield from interruptions.serve(due)


def grind_whole(plan: CyclePlan, timeline: Timeline) -> CycleStrokes | None:
    """Work off at once a cycle that nothing comes between; its auto-dresses are counted and take no time.

    Times are added up as the timeline does, so that they have the same bits.

    Returns:
        None if a pick is slow, still under way when the table passes the middle of the stroke after it, or if there is
        no stroke; then nothing has been done.
    """
    table, control, budget = timeline.reciprocation, timeline.control, timeline.budget
    assert table is not None  # called by cycles only
    acceleration, feed = control.acceleration, timeline.rate(table.feed)
    pick_speed = timeline.rate(plan.pick_feed) / 60.0

    def timed(length: float) -> tuple[float, float]:
        """Seconds of a stroke, and of the deceleration at its end."""
        return motion_time(length, feed / 60.0, acceleration), ramp_time(length, feed / 60.0, acceleration)

    travel, ramp = timed(abs(table.primary - table.coordinate))
    later = timed(abs(table.secondary - table.primary))
    position = list(timeline.position)
    begin = end = table.free_at
    picked = -math.inf
    strokes = dresses = 0
    for strokes, (picks, due) in enumerate(turns(plan, control.coverage_pass), 1):
        if picked > begin + 0.5 * travel:
            return None
        budget.foresee(strokes, table.place)
        for _, axis, coordinate in picks:
            seconds = motion_time(abs(coordinate - position[axis]), pick_speed, acceleration)
            picked = max(begin + travel - ramp, picked) + seconds
            position[axis] = coordinate
        begin = end = begin + travel + control.reversal_dwell
        if due:
            begin = max(begin, picked)
            dresses += due
        travel, ramp = later
    if not strokes:
        return None
    made = CycleStrokes(
        time=end,
        begin=table.free_at,
        plan=plan,
        start=timeline.position,
        feed=feed,
        strokes=strokes,
        dresses=dresses,
        inch=timeline.inch,
    )
    budget.spend(table.place, strokes)
    table.make(strokes, dresses, max(begin, picked))
    position[table.axis] = table.coordinate
    timeline.time, timeline.position = table.free_at, (position[0], position[1], position[2])
    return made


def least_strokes(plan: CyclePlan, coverage: bool) -> int:
    """Strokes that a cycle makes at least: it never infeeds or crosses further at once than its larger pick."""
    if plan.plunge_axis is None:
        return 0
    traverses = _least_picks(plan.depth, plan.primary_pick, plan.secondary_pick) + coverage + plan.spark_out
    width = abs(plan.cross_end - plan.cross_start)
    crossing = _least_picks(width, plan.primary_cross_pick, plan.secondary_cross_pick)
    return traverses + max(traverses - 1, 0) * crossing


def _least_picks(way: float, *picks: float) -> int:
    return math.ceil(way / max(picks) - PICK_TOLERANCE) if way > 0.0 else 0


def _coordinate(start: float, end: float, done: float, total: float) -> float:
    """The coordinate after part of the way, exactly `end` after the whole."""
    if done >= total:
        return end
    return start + done if end > start else start - done

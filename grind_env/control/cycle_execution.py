"""Execution of a cycle by its rules, stroke by stroke or all at once: strokes, picks and dresses."""

import functools
import itertools
import math
from collections.abc import Iterator
from typing import NamedTuple

from grind_env.control.axis_timeline import Timeline
from grind_env.control.cycle_formulas import motion_time, pick_begin
from grind_env.control.cycles import RULES
from grind_env.control.events import CyclePlan, CycleStrokes, Event, Position, placed
from grind_env.control.interruptions import Interruptions
from grind_env.control.motion_profile import ramp_time

#: target of a pick: "plunge" or "cross", the axis, and its coordinate without the shift by dresses, mm
Target = tuple[str, int, float]


def reversals(plan: CyclePlan, coverage: bool) -> Iterator[tuple[list[Target], int]]:
    """Yield, for each stroke of a cycle, the picks after it and the number of auto-dresses that then fall due."""
    rules = RULES[plan.code]
    cycle = rules.cycle_of(plan, coverage)
    progress = rules.begin(cycle)
    while not rules.finished(cycle, progress):
        before, progress = progress, rules.after_reversal(cycle, progress)
        picks: list[Target] = []
        if progress.depth > before.depth:
            assert plan.plunge_axis is not None
            picks.append(("plunge", plan.plunge_axis, _depth_coordinate(plan, progress.depth)))
        if rules.cross is not None:
            assert plan.cross_axis is not None
            here, there = (rules.cross(each, plan.cross_start, plan.cross_end) for each in (before, progress))
            if there != here:
                picks.append(("cross", plan.cross_axis, there))
        yield picks, int(progress.dresses)


@functools.lru_cache(maxsize=64)
def plunges(plan: CyclePlan) -> int:
    """Return the number of plunge picks of a cycle."""
    return sum(kind == "plunge" for picks, _ in reversals(plan, coverage=False) for kind, _, _ in picks)


def least_strokes(plan: CyclePlan, coverage: bool) -> float:
    """Return the least number of strokes of a cycle, with or without a coverage pass."""
    rules = RULES[plan.code]
    return rules.least_strokes(rules.cycle_of(plan, coverage))


def grind(plan: CyclePlan, interruptions: Interruptions) -> Iterator[Event]:
    """Execute a cycle stroke by stroke."""
    timeline = interruptions.timeline
    for picks, due in reversals(plan, timeline.control.coverage_pass):
        stroke = yield from timeline.finish_stroke()
        for kind, axis, coordinate in picks:
            target = coordinate + timeline.infeed_shift if kind == "plunge" else coordinate
            yield from timeline.pick(stroke, kind, axis, target, plan.pick_feed)
        yield from interruptions.serve(due)


class UntimedStrokes(NamedTuple):
    """The strokes of a cycle without their times."""

    plunge: tuple[float, ...]  #: coordinate of the plunge axis in the middle of each stroke, mm
    cross: tuple[float, ...]  #: coordinate of the third axis in the middle of each stroke, mm
    picks: tuple[tuple[float, ...], ...]  #: times of the picks that follow each stroke, s
    dresses: tuple[int, ...]  #: number of auto-dresses due after each stroke
    end: Position  #: position after the last pick, mm; the coordinate of the table is that at the start


@functools.lru_cache(maxsize=64)
def untimed_strokes(
    plan: CyclePlan, start: Position, coverage: bool, pick_speed: float, acceleration: float, most: int
) -> UntimedStrokes:
    """Return at most `most` strokes of a cycle (mm, mm/s, mm/s^2); cached, as programs repeat it for every part."""
    assert plan.plunge_axis is not None
    third = 3 - plan.axis - plan.plunge_axis
    position, plunge, cross, seconds, dresses = list(start), [], [], [], []
    for picks, due in itertools.islice(reversals(plan, coverage), most):
        plunge.append(position[plan.plunge_axis])
        cross.append(position[third])
        ways = []
        for _, axis, coordinate in picks:
            ways.append(abs(coordinate - position[axis]))
            position[axis] = coordinate
        seconds.append(tuple(motion_time(way, pick_speed, acceleration) for way in ways))
        dresses.append(due)
    end = position[0], position[1], position[2]
    return UntimedStrokes(tuple(plunge), tuple(cross), tuple(seconds), tuple(dresses), end)


def grind_whole_cycle(plan: CyclePlan, timeline: Timeline) -> CycleStrokes | None:
    """Execute an undisturbed cycle at once; its auto-dresses are noted and take no time.

    Times are added in the order of the timeline, so the floats are identical. Returns None, and does nothing, without
    a stroke or if a pick is still under way in the middle of the next stroke.
    """
    table, control, start = timeline.reciprocation, timeline.control, timeline.position
    assert table is not None  # called by cycles only
    acceleration, dwell, feed = control.acceleration, timeline.dwell, timeline.table_rate(table)
    pick_speed, most = timeline.rate(plan.pick_feed) / 60.0, control.block_budget + 1  # the budget refuses one more
    cycle = untimed_strokes(plan, start, control.coverage_pass, pick_speed, acceleration, most)

    def timed(length: float) -> tuple[float, float]:
        """Return the time of a stroke, and of the deceleration at its end, s."""
        return motion_time(length, feed / 60.0, acceleration), ramp_time(length, feed / 60.0, acceleration)

    first, ramp = timed(abs(table.primary - table.coordinate))
    later = timed(abs(table.secondary - table.primary))
    begins: list[float] = []
    dresses: list[tuple[int, float]] = []
    free = end = table.free_at
    travel, picked = first, -math.inf
    for picks, due in zip(cycle.picks, cycle.dresses, strict=True):
        if picked > free + 0.5 * travel:
            return None
        begins.append(free)
        for seconds in picks:
            picked = pick_begin(free, travel, ramp, picked) + seconds
        free = end = free + travel + dwell
        if due:
            free = max(free, picked)
            dresses += [(len(begins), free)] * due
        travel, ramp = later
    if not begins:
        return None
    timeline.budget.spend(table.place, len(begins))
    table.make(len(begins), len(dresses), max(free, picked))
    timeline.time, timeline.position = table.free_at, placed(cycle.end, {table.axis: table.coordinate})
    return CycleStrokes(
        time=end,
        plan=plan,
        start=start,
        feed=feed,
        begins=tuple(begins),
        seconds=(first + dwell, *itertools.repeat(later[0] + dwell, len(begins) - 1)),
        plunge=cycle.plunge,
        cross=cycle.cross,
        end=timeline.position,
        dresses=tuple(dresses),
        inch=timeline.inch,
    )


def _depth_coordinate(plan: CyclePlan, depth: float) -> float:
    if depth >= plan.depth:
        return plan.depth_target
    return plan.plunge_start + depth if plan.depth_target > plan.plunge_start else plan.plunge_start - depth

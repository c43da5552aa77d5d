"""The order of strokes, picks and dresses within G82 and G83 (16-16, PD-10, PD-12 to PD-14)."""

import math
from collections.abc import Callable, Iterator

from grind_env.control.motions import CyclePlan, Event
from grind_env.control.reciprocation import Underway
from grind_env.control.rules import PICK_TOLERANCE, depth_after_pick, dresses_due
from grind_env.control.timeline import Timeline

Service = Callable[[int], Iterator[Event]]
"""Runs the dresses at a reversal point: the given number of auto-dresses, then the operator's."""


def plunge_grind(plan: CyclePlan, timeline: Timeline, service: Service) -> Iterator[Event]:
    """G82: a plunge pick at every reversal down to depth, one coverage stroke, L spark-out strokes."""
    reversal, depth = 0, 0.0
    while depth < plan.depth:
        stroke = yield from timeline.finish_stroke()
        reversal += 1
        deeper = _depth(plan, reversal, depth)
        yield from _plunge(plan, timeline, stroke, depth, deeper)
        yield from service(_dresses_between(plan, depth, deeper))
        depth = deeper
    for _ in range(timeline.control.coverage_pass + plan.spark_out):
        yield from timeline.finish_stroke()
        yield from service(0)


def cross_grind(plan: CyclePlan, timeline: Timeline, service: Service) -> Iterator[Event]:
    """G83: a plunge pick at each end of the crossover, cross picks between, then traverses at depth.

    The stroke before a plunge grinds the last strip without a pick.
    """
    reversal, plunges, depth = 0, 0, 0.0
    near, far = plan.cross_start, plan.cross_end
    traverses = timeline.control.coverage_pass + plan.spark_out
    while True:
        stroke = yield from timeline.finish_stroke()
        reversal += 1
        due = 0
        if depth < plan.depth:
            plunges += 1
            deeper = _depth(plan, plunges, depth)
            yield from _plunge(plan, timeline, stroke, depth, deeper)
            due = _dresses_between(plan, depth, deeper)
            depth = deeper
        yield from service(due)
        if depth >= plan.depth:
            if traverses == 0:
                return
            traverses -= 1
        width, crossed = abs(far - near), 0.0
        while crossed < width:
            stroke = yield from timeline.finish_stroke()
            reversal += 1
            further = depth_after_pick(
                float(reversal), crossed, width, plan.primary_cross_pick, plan.secondary_cross_pick
            )
            if further > crossed:
                assert plan.cross_axis is not None
                target = _coordinate(near, far, further, width)
                yield from timeline.pick(stroke, "cross", plan.cross_axis, target, plan.pick_feed)
            crossed = further
            yield from service(0)
        near, far = far, near


def least_strokes(plan: CyclePlan, coverage: bool) -> int:
    """Strokes that a G82 or G83 makes at least: it never infeeds or crosses further at once than its larger pick."""
    traverses = _least_picks(plan.depth, plan.primary_pick, plan.secondary_pick) + coverage + plan.spark_out
    width = abs(plan.cross_end - plan.cross_start)
    crossing = _least_picks(width, plan.primary_cross_pick, plan.secondary_cross_pick)
    return traverses + max(traverses - 1, 0) * crossing


def _least_picks(way: float, *picks: float) -> int:
    return math.ceil(way / max(picks) - PICK_TOLERANCE) if way > 0.0 else 0


def _depth(plan: CyclePlan, reversal: int, depth: float) -> float:
    return depth_after_pick(float(reversal), depth, plan.depth, plan.primary_pick, plan.secondary_pick)


def _dresses_between(plan: CyclePlan, before: float, after: float) -> int:
    executions = float(plan.dresses)
    return int(dresses_due(after, plan.depth, executions) - dresses_due(before, plan.depth, executions))


def _plunge(plan: CyclePlan, timeline: Timeline, stroke: Underway, depth: float, deeper: float) -> Iterator[Event]:
    if deeper > depth:
        assert plan.plunge_axis is not None
        target = _coordinate(plan.plunge_start, plan.depth_target, deeper, plan.depth) + timeline.infeed_shift
        yield from timeline.pick(stroke, "plunge", plan.plunge_axis, target, plan.pick_feed)


def _coordinate(start: float, end: float, done: float, total: float) -> float:
    """The coordinate after part of the way, exactly `end` after the whole."""
    if done >= total:
        return end
    return start + done if end > start else start - done

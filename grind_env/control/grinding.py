"""Runs a G82 or G83: strokes, and what its rules say of the reversals that end them."""

from collections.abc import Callable, Iterator

from grind_env.control.cycles import RULES
from grind_env.control.motions import CyclePlan, Event
from grind_env.control.rules import picks_to
from grind_env.control.timeline import Timeline

Service = Callable[[int], Iterator[Event]]
"""Runs the dresses at a reversal point: the given number of auto-dresses, then the operator's."""


def grind(plan: CyclePlan, timeline: Timeline, service: Service) -> Iterator[Event]:
    """Work off a cycle, from its first stroke to its last."""
    rules = RULES[plan.code]
    cycle = rules.cycle_of(plan, timeline.control.coverage_pass)
    progress = rules.begin(cycle)
    while not rules.finished(cycle, progress):
        stroke = yield from timeline.finish_stroke()
        before, progress = progress, rules.after_reversal(cycle, progress)
        if progress.depth > before.depth:
            assert plan.plunge_axis is not None
            target = _coordinate(plan.plunge_start, plan.depth_target, progress.depth, plan.depth)
            yield from timeline.pick(stroke, "plunge", plan.plunge_axis, target + timeline.infeed_shift, plan.pick_feed)
        if progress.crossed > before.crossed:
            assert plan.cross_axis is not None
            ends = plan.cross_start, plan.cross_end
            near, far = ends if progress.forward else reversed(ends)
            target = _coordinate(near, far, progress.crossed, abs(far - near))
            yield from timeline.pick(stroke, "cross", plan.cross_axis, target, plan.pick_feed)
        yield from service(int(progress.dresses))


def least_strokes(plan: CyclePlan, coverage: bool) -> int:
    """Strokes that a G82 or G83 makes at least: it never infeeds or crosses further at once than its larger pick."""
    traverses = _least_picks(plan.depth, plan.primary_pick, plan.secondary_pick) + coverage + plan.spark_out
    width = abs(plan.cross_end - plan.cross_start)
    crossing = _least_picks(width, plan.primary_cross_pick, plan.secondary_cross_pick)
    return traverses + max(traverses - 1, 0) * crossing


def _least_picks(way: float, *picks: float) -> int:
    return picks_to(way, max(picks)) if way > 0.0 else 0


def _coordinate(start: float, end: float, done: float, total: float) -> float:
    """The coordinate after part of the way, exactly `end` after the whole."""
    if done >= total:
        return end
    return start + done if end > start else start - done

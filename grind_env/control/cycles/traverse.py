"""G83: a plunge pick at each end of the crossover, cross picks between, then traverses at depth.

The stroke before a plunge grinds the last strip without a pick (16-16, PD-10, PD-12 to PD-14). Lengths are mm. Depths
count from the start of the plunge, positive towards the part; distances across count from the last end left.
"""

from typing import NamedTuple

from grind_env.control.cycle_formulas import depth_after_pick, dresses_due, least_picks
from grind_env.control.events import CyclePlan


class TraverseCycle(NamedTuple):
    """Parameters of a G83 block."""

    depth: float  #: total plunge depth, mm
    primary_pick: float  #: J, mm
    secondary_pick: float  #: Q, mm
    width: float  #: distance between the ends of the crossover, mm
    primary_cross_pick: float  #: K in G17, mm
    secondary_cross_pick: float  #: R, mm
    at_depth: float  #: number of traverses at full depth: the coverage traverse and L
    executions: float  #: D, the number of auto-dresses
    pre_dress: float  #: 1 for G83.1, else 0


class TraverseProgress(NamedTuple):
    """Progress of a G83 cycle."""

    reversal: float  #: number of strokes made; also the number of the reversal point reached
    plunges: float  #: number of plunge picks made
    depth: float  #: depth reached, mm
    crossed: float  #: distance crossed since the last end of the crossover, mm
    forward: float  #: 1 if the crossing leads away from the cross start, else 0
    left: float  #: number of traverses to begin at full depth; -1 once the last one has ended
    dressed: float  #: number of auto-dresses that were due so far
    dresses: float  #: number of dresses at this reversal, before the next stroke


def cycle_of(plan: CyclePlan, coverage: bool) -> TraverseCycle:
    """Return the numbers of a block, with or without a coverage traverse (PD-13)."""
    return TraverseCycle(
        depth=plan.depth,
        primary_pick=plan.primary_pick,
        secondary_pick=plan.secondary_pick,
        width=abs(plan.cross_end - plan.cross_start),
        primary_cross_pick=plan.primary_cross_pick,
        secondary_cross_pick=plan.secondary_cross_pick,
        at_depth=float(coverage + plan.spark_out),
        executions=float(plan.dresses),
        pre_dress=float(plan.pre_dress),
    )


def begin(cycle: TraverseCycle) -> TraverseProgress:
    """Return the progress before the first stroke, which ends at a plunge."""
    return TraverseProgress(
        reversal=0.0,
        plunges=0.0,
        depth=0.0,
        crossed=cycle.width,
        forward=0.0,
        left=cycle.at_depth,
        dressed=0.0,
        dresses=cycle.pre_dress,
    )


def after_reversal(cycle: TraverseCycle, progress: TraverseProgress) -> TraverseProgress:
    """Return the progress after the next stroke and the pick at the reversal that ends it."""
    reversal = progress.reversal + 1.0
    at_end = progress.crossed >= cycle.width
    plunge = at_end & (progress.depth < cycle.depth)
    plunges = progress.plunges + (1.0 if plunge else 0.0)
    picked = depth_after_pick(plunges, progress.depth, cycle.depth, cycle.primary_pick, cycle.secondary_pick)
    depth = picked if plunge else progress.depth
    due = dresses_due(depth, cycle.depth, cycle.executions)
    further = depth_after_pick(
        reversal, progress.crossed, cycle.width, cycle.primary_cross_pick, cycle.secondary_cross_pick
    )
    return TraverseProgress(
        reversal=reversal,
        plunges=plunges,
        depth=depth,
        crossed=0.0 if at_end else further,
        forward=1.0 - progress.forward if at_end else progress.forward,
        left=progress.left - (1.0 if at_end & (depth >= cycle.depth) else 0.0),
        dressed=due,
        dresses=due - progress.dressed,
    )


def cross(progress: TraverseProgress, start: float, end: float) -> float:
    """Return the cross coordinate of the next stroke, mm; exactly `start` or `end` once it is reached.

    Args:
        progress: progress before the stroke.
        start: begin of the crossover, mm.
        end: end of the crossover, mm.
    """
    near = start if progress.forward > 0.0 else end
    far = end if progress.forward > 0.0 else start
    way = progress.crossed if far > near else -progress.crossed
    return far if progress.crossed >= abs(far - near) else near + way


def finished(cycle: TraverseCycle, progress: TraverseProgress) -> bool:
    """Return whether no stroke is left to make."""
    return progress.left < 0.0


def least_strokes(cycle: TraverseCycle) -> float:
    """Return the least number of strokes: one at the begin of each traverse, and one after each cross pick."""
    traverses = least_picks(cycle.depth, cycle.primary_pick, cycle.secondary_pick) + cycle.at_depth
    crossing = least_picks(cycle.width, cycle.primary_cross_pick, cycle.secondary_cross_pick)
    return traverses + max(traverses - 1.0, 0.0) * crossing

"""G82: a plunge pick at every reversal down to depth, then strokes at depth (16-16, PD-10, PD-12 to PD-14).

Lengths are mm. Depths count from the start of the plunge, positive towards the part.
"""

from typing import NamedTuple

from grind_env.control.cycle_formulas import depth_after_pick, dresses_due, least_picks
from grind_env.control.events import CyclePlan


class PlungeCycle(NamedTuple):
    """Parameters of a G82 block."""

    depth: float  #: total plunge depth, mm
    primary_pick: float  #: J, mm
    secondary_pick: float  #: Q, mm
    at_depth: float  #: number of strokes at full depth: the coverage stroke and L
    executions: float  #: D, the number of auto-dresses
    pre_dress: float  #: 1 for G82.1, else 0


class PlungeProgress(NamedTuple):
    """Progress of a G82 cycle."""

    reversal: float  #: number of strokes made; also the number of the reversal point reached
    depth: float  #: depth reached, mm
    left: float  #: number of strokes to make at full depth
    dressed: float  #: number of auto-dresses that were due so far
    dresses: float  #: number of dresses at this reversal, before the next stroke


def cycle_of(plan: CyclePlan, coverage: bool) -> PlungeCycle:
    """Return the numbers of a block, with or without a coverage stroke (PD-13)."""
    return PlungeCycle(
        depth=plan.depth,
        primary_pick=plan.primary_pick,
        secondary_pick=plan.secondary_pick,
        at_depth=float(coverage + plan.spark_out),
        executions=float(plan.dresses),
        pre_dress=float(plan.pre_dress),
    )


def begin(cycle: PlungeCycle) -> PlungeProgress:
    """Return the progress before the first stroke."""
    return PlungeProgress(reversal=0.0, depth=0.0, left=cycle.at_depth, dressed=0.0, dresses=cycle.pre_dress)


def after_reversal(cycle: PlungeCycle, progress: PlungeProgress) -> PlungeProgress:
    """Return the progress after the next stroke and the pick at the reversal that ends it."""
    at_depth = progress.depth >= cycle.depth
    reversal = progress.reversal + 1.0
    picked = depth_after_pick(reversal, progress.depth, cycle.depth, cycle.primary_pick, cycle.secondary_pick)
    depth = progress.depth if at_depth else picked
    due = dresses_due(depth, cycle.depth, cycle.executions)
    return PlungeProgress(
        reversal=reversal,
        depth=depth,
        left=progress.left - (1.0 if at_depth else 0.0),
        dressed=due,
        dresses=due - progress.dressed,
    )


def finished(cycle: PlungeCycle, progress: PlungeProgress) -> bool:
    """Return whether no stroke is left to make."""
    return (progress.depth >= cycle.depth) & (progress.left <= 0.0)


def least_strokes(cycle: PlungeCycle) -> float:
    """Return the least number of strokes."""
    return least_picks(cycle.depth, cycle.primary_pick, cycle.secondary_pick) + cycle.at_depth

"""Where the strokes of each cycle lie, for the compiled loops: the rules of `control.cycles`, and depth and place."""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from grind_env.control.cycles import plunge, traverse
from grind_env.control.cycles.plunge import PlungeCycle, PlungeProgress
from grind_env.control.cycles.traverse import TraverseCycle, TraverseProgress
from grind_env.kernel import inlined, inlined_rule
from grind_env.machine.cycle import Cycle


class Course(NamedTuple):
    """A cycle as the loops run it: two named tuples of floats, and compiled functions of them."""

    cycle: type[Any]
    """Its numbers: `Cycle`, or what has the fields of it that `cycle.advance` and `cycle.dress` read."""
    progress: type[Any]
    """How far it has come. `reversal` counts strokes, `dresses` are the executions to run before the next one."""
    plan: Callable[[Any], Any]
    """The cycle as its rules have it."""
    begin: Callable[[Any], Any]
    """From the plan: before the first stroke."""
    after_reversal: Callable[[Any, Any], Any]
    """From plan and progress: after the next stroke."""
    finished: Callable[[Any, Any], bool]
    """From plan and progress: whether there is no stroke to make any more."""
    depth: Callable[[Any, Any], float]
    """From cycle and progress: of the coming stroke in the middle of the part, mm."""
    edge: Callable[[Any, Any], float]
    """From cycle and progress: cross coordinate of the wheel's edge on the minus side in that stroke, mm."""
    lost: Callable[[Any], bool]
    """From the progress: whether the coming stroke has first to be found."""
    find: Callable[[Any, Any, Any], Any]
    """From cycle, progress and the table of motions: the progress with it found, and the s that the table waits."""
    gauged: Callable[[Any], bool]
    """From the progress: whether the operator gauges the part before the coming stroke ends."""


cross = inlined_rule(traverse.cross)


@inlined
def _plunge_plan(cycle: Cycle) -> PlungeCycle:
    return PlungeCycle(
        depth=cycle.target - cycle.start,
        primary_pick=cycle.primary_pick,
        secondary_pick=cycle.secondary_pick,
        at_depth=cycle.at_depth,
        executions=cycle.executions,
        pre_dress=cycle.pre_dress,
    )


@inlined
def _traverse_plan(cycle: Cycle) -> TraverseCycle:
    return TraverseCycle(
        depth=cycle.target - cycle.start,
        primary_pick=cycle.primary_pick,
        secondary_pick=cycle.secondary_pick,
        width=abs(cycle.cross_end - cycle.cross_start),
        primary_cross_pick=cycle.primary_cross_pick,
        secondary_cross_pick=cycle.secondary_cross_pick,
        at_depth=cycle.at_depth,
        executions=cycle.executions,
        pre_dress=cycle.pre_dress,
    )


@inlined
def _picked_depth(cycle: Cycle, progress: PlungeProgress | TraverseProgress) -> float:
    # sums as those of coordinates by the control, to the bit
    picked = (cycle.start + progress.depth) + cycle.surface
    return cycle.bottom if progress.depth >= cycle.target - cycle.start else picked


@inlined
def _fixed_edge(cycle: Cycle, progress: Any) -> float:
    return cycle.cross_start


@inlined
def _crossed_edge(cycle: Cycle, progress: TraverseProgress) -> float:
    return cross(progress, cycle.cross_start, cycle.cross_end)


@inlined
def _never(progress: Any) -> bool:
    return False


@inlined
def _as_it_is(cycle: Any, progress: Any, motions: Any) -> tuple[Any, float]:
    return progress, 0.0


PLUNGE = Course(
    cycle=Cycle,
    progress=PlungeProgress,
    plan=_plunge_plan,
    begin=inlined_rule(plunge.begin),
    after_reversal=inlined_rule(plunge.after_reversal),
    finished=inlined_rule(plunge.finished),
    depth=_picked_depth,
    edge=_fixed_edge,
    lost=_never,
    find=_as_it_is,
    gauged=_never,
)

TRAVERSE = Course(
    cycle=Cycle,
    progress=TraverseProgress,
    plan=_traverse_plan,
    begin=inlined_rule(traverse.begin),
    after_reversal=inlined_rule(traverse.after_reversal),
    finished=inlined_rule(traverse.finished),
    depth=_picked_depth,
    edge=_crossed_edge,
    lost=_never,
    find=_as_it_is,
    gauged=_never,
)

COURSES: Mapping[str, Course] = {"G82": PLUNGE, "G83": TRAVERSE}
"""Of every cycle that plunges, by its code."""

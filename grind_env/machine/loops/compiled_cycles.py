"""Cycles for the compiled loops: functions, from the rules of `control.cycles`, that place each stroke."""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from grind_env.control.cycles import RULES, Rules
from grind_env.control.cycles.plunge import PlungeCycle, PlungeProgress
from grind_env.control.cycles.traverse import TraverseCycle, TraverseProgress
from grind_env.kernel import inlined, inlined_rule
from grind_env.machine.loops.cycle import Stroking


class CycleKernel(NamedTuple):
    """A cycle as the loops run it: two named tuples of floats, and compiled functions of them."""

    cycle: type[Any]  #: type of the numbers of its rules; in a row of a table they follow those of `Stroking`
    #: type of its progress: `reversal` counts strokes, `dresses` the dress executions due before the next stroke
    progress: type[Any]
    begin: Callable[[Any], Any]  #: `begin(cycle)`: the progress before the first stroke
    after_reversal: Callable[[Any, Any], Any]  #: `after_reversal(cycle, progress)`: the progress after the next stroke
    finished: Callable[[Any, Any], bool]  #: `finished(cycle, progress)`: whether all strokes are made
    #: `depth(stroking, cycle, progress)`: depth of the coming stroke in the middle of the part, mm
    depth: Callable[[Stroking, Any, Any], float]
    #: `edge(stroking, progress)`: cross coordinate of the wheel's edge on the minus side in that stroke, mm
    edge: Callable[[Stroking, Any], float]
    lost: Callable[[Any], bool]  #: `lost(progress)`: whether `find` has to find the coming stroke
    #: `find(cycle, progress, motions)`: the progress with the coming stroke, and the wait of the table, s
    find: Callable[[Any, Any, Any], Any]
    #: `gauged(progress)`: whether the operator gauges the part before the coming stroke ends
    gauged: Callable[[Any], bool]


def course_of(rules: Rules, cycle: type[Any], progress: type[Any]) -> CycleKernel:
    """Return the kernel of a cycle that plunges to a depth of its own, from its rules and their two named tuples."""
    return CycleKernel(
        cycle=cycle,
        progress=progress,
        begin=inlined_rule(rules.begin),
        after_reversal=inlined_rule(rules.after_reversal),
        finished=inlined_rule(rules.finished),
        depth=_picked_depth,
        edge=_fixed_edge if rules.cross is None else _crossed_edge(rules.cross),
        lost=never,
        find=_as_it_is,
        gauged=never,
    )


@inlined
def _picked_depth(stroking: Stroking, cycle: Any, progress: Any) -> float:
    # the same sums as the control makes, so that the bits are equal
    picked = (stroking.start + progress.depth) + stroking.surface
    return stroking.bottom if progress.depth >= cycle.depth else picked


@inlined
def _fixed_edge(stroking: Stroking, progress: Any) -> float:
    return stroking.cross_start


def _crossed_edge(rule: Callable[[Any, float, float], float]) -> Callable[[Stroking, Any], float]:
    cross = inlined_rule(rule)

    @inlined
    def edge(stroking: Stroking, progress: Any) -> float:
        return cross(progress, stroking.cross_start, stroking.cross_end)

    return edge


@inlined
def never(numbers: Any) -> bool:
    """Return False, for cycles in which something never happens."""
    return False


@inlined
def _as_it_is(cycle: Any, progress: Any, motions: Any) -> tuple[Any, float]:
    return progress, 0.0


#: kernels of the cycles that plunge, by code
CYCLE_KERNELS: Mapping[str, CycleKernel] = {
    "G82": course_of(RULES["G82"], PlungeCycle, PlungeProgress),
    "G83": course_of(RULES["G83"], TraverseCycle, TraverseProgress),
}

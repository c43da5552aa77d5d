"""A cycle block for the compiled loops: its strokes and dresses, from control and process."""

import functools
import math
from collections.abc import Callable
from typing import Any, NamedTuple

from grind_env.control.cycle_formulas import DEPTH_TOLERANCE
from grind_env.kernel import inlined
from grind_env.kernel.row_accessors import replacer
from grind_env.machine.loops.stroke_totals import FINISHING_DEPTH, Tally, count_dress, count_stroke, wheel_depth
from grind_env.machine.loops.table_speed import paced_of
from grind_env.process.equations import wheel_speed
from grind_env.process.process_interface import Process, whole_ms
from grind_env.process.stroke_types import StrokeParameters, StrokeResult, WheelState


class Stroking(NamedTuple):
    """Numbers of the strokes of a cycle block, for every kind of cycle.

    Depths are mm into the part; `start` counts from the zero of the program. In the row of a machine the numbers of the
    rules follow, as in `control.cycles`.
    """

    speed: float  #: highest table speed over the part, mm/s (see `Pace`)
    slow: float  #: table speed at the slow node, mm/s (see `Pace`)
    slow_share: float  #: share of the ground length at the slow node (see `Pace`)
    slow_time: float  #: share of the time over the part at the slow node (see `Pace`)
    first_seconds: float  #: time of the first stroke, from the start point to the primary point, s
    stroke_seconds: float  #: time of every other stroke, s
    set_out: float  #: time of the first stroke without a wait before it, s
    start: float  #: depth at which the wheel stands when the cycle begins, mm
    #: height of the touched-off surface above the zero of `start`, mm; a depth below that zero plus this height is a
    #: depth below the surface
    surface: float
    bottom: float  #: depth of a stroke at the full depth of the cycle, below the touched-off surface, mm
    full_plunge: float  #: least gain in depth of a stroke that counts as a full plunge when power is averaged, mm
    finish: float  #: depth of the finished surface, mm: `bottom` unless a later block goes deeper
    width: float  #: width of the part, mm; for a part narrower than the wheel this is the engaged width b
    length: float  #: ground length Lw, mm
    dress_passes: float  #: number of diamond passes of one execution
    dress_feed: float  #: traverse feed of the diamond, mm/s
    dress_depth: float  #: depth of each pass, mm
    dress_seconds: float  #: time of one execution with set-up, approach and retrace, s
    cross_start: float  #: cross coordinate of the wheel's edge on the minus side where the cycle begins, mm
    cross_end: float  #: cross coordinate of that edge where the crossover ends, mm; `cross_start` without a crossover


class PartState(NamedTuple):
    """The surface under the wheel."""

    Z: float  #: depth of the deepest stroke, mm
    S: float  #: stock removed, mean over the length, mm
    Rs: float  #: roughness Ra, mean over the length, um
    S_step: float = 0.0  #: stock removed at the fast node less that at the slow one (see `pace`), mm
    Rs_step: float = 0.0  #: roughness at the fast node less that at the slow one, um


class Zone(NamedTuple):
    """Neighbouring strips that are under the wheel only together, so that all have the same state."""

    S: float  #: stock removed, mm
    Rs: float  #: roughness Ra, um
    reached: float  #: depth of the deepest stroke so far, mm
    centre: float  #: cross coordinate of the middle of its first strip, mm
    strips: float  #: number of strips; 0 for an empty zone, which is never under the wheel
    S_step: float = 0.0  #: stock removed at the fast node less that at the slow one, mm
    Rs_step: float = 0.0  #: roughness at the fast node less that at the slow one, um


with_wear = replacer(WheelState, "W")


class CycleFunctions(NamedTuple):
    """Compiled functions of a process in a cycle."""

    #: `advance(stroking, Z, seconds, b, reached, wheel, own, part, tally, slow_k, k)`: make a stroke at depth `Z`, mm;
    #: return wheel, own, part and tally after it, and the stroke at the slow and at the fast node. `seconds` holds the
    #: time of the stroke with and without a wait before it; `b` is the engaged width, mm; `reached` is the least depth
    #: ground under the wheel, mm; `part` is the surface in the cut. `slow_k` and `k` are the constants of the strokes
    #: at the slow and at the fast node
    advance: Callable[..., Any]
    #: `dress(stroking, wheel, own, tally, p, waited)`: make one dress execution after the table has waited `waited` s;
    #: return wheel, own and tally after it
    dress: Callable[..., Any]


@functools.cache
def cycle_functions_of(process: Process) -> CycleFunctions:
    """Return the compiled functions of a process in a cycle."""
    grind, dress_wheel, idle, grown = paced_of(process), process.dress, idle_of(process), grown_of(process)

    @inlined
    def advance(
        stroking: Stroking,
        Z: float,
        seconds: tuple[float, float],
        b: float,
        reached: float,
        wheel: WheelState,
        own: Any,
        part: PartState,
        tally: Tally,
        slow_k: Any,
        k: Any,
    ) -> tuple[WheelState, Any, PartState, Tally, StrokeResult, StrokeResult]:
        depth = wheel_depth(Z, tally) + grown(own, k)
        wheel, own, stroke, slow, fast = grind(wheel, own, part, depth, b, stroking, slow_k, k, whole_ms(seconds[1]))
        deeper = Z - part.Z
        finishing = stroking.finish - Z <= FINISHING_DEPTH + DEPTH_TOLERANCE
        plunge, full = reached + DEPTH_TOLERANCE < Z, stroking.full_plunge <= deeper
        tally = count_stroke(tally, stroke, seconds[0], deeper, plunge, full, finishing, k.stall_time)
        part = PartState(
            Z=max(part.Z, Z),
            S=part.S + stroke.ae,
            Rs=stroke.Ra,
            S_step=part.S_step + (fast.ae - slow.ae),
            Rs_step=fast.Ra - slow.Ra,
        )
        return wheel, own, part, tally, slow, fast

    @inlined
    def dress(
        stroking: Stroking, wheel: WheelState, own: Any, tally: Tally, p: StrokeParameters, waited: float
    ) -> tuple[WheelState, Any, Tally]:
        wheel, own = idle(wheel, own, p, waited, False)
        lead = dress_lead(wheel, stroking.dress_feed, p)
        wheel, own, removed = dress_wheel(wheel, own, stroking.dress_passes, lead, stroking.dress_depth, p)
        wheel, own = idle(wheel, own, p, stroking.dress_seconds, False)
        return wheel, own, count_dress(tally, stroking.dress_seconds + waited, removed)

    return CycleFunctions(advance, dress)


@functools.cache
def idle_of(process: Process) -> Callable[..., Any]:
    """Return the compiled `idle` of a process for unrounded times; without `idle`, or in no time, nothing changes."""
    if process.idle is None:
        return _unchanged
    pass_time = process.idle

    @inlined
    def idle(wheel: WheelState, own: Any, p: StrokeParameters, seconds: float, loads: bool) -> tuple[WheelState, Any]:
        passed = whole_ms(seconds)
        if passed > 0.0 or loads:
            wheel, own = pass_time(wheel, own, p, passed, loads)
        return wheel, own

    return idle


@inlined
def _unchanged(wheel: WheelState, own: Any, p: StrokeParameters, seconds: float, loads: bool) -> tuple[WheelState, Any]:
    return wheel, own


def grown_of(process: Process) -> Callable[..., Any]:
    """Return the compiled `grown` of a process; without `grown` a function that returns 0."""
    return _nothing if process.grown is None else process.grown


@inlined
def _nothing(own: Any, k: Any) -> float:
    return 0.0


@inlined
def dress_lead(wheel: WheelState, feed: float, p: StrokeParameters) -> float:
    """Return the dress lead, mm per wheel revolution, of a diamond that traverses with `feed` mm/s."""
    return feed * math.pi * wheel.ds / (1000.0 * wheel_speed(wheel.ds, p.n, p.vs_set))


@inlined
def measured(wheel: WheelState) -> WheelState:
    """Return the wheel after its wear is measured and compensated."""
    return with_wear(wheel, (0.0,))


@inlined
def stroke_seconds(stroking: Stroking, reversal: float) -> tuple[float, float]:
    """Return the time of the stroke after `reversal` reversals, with and without a wait before it, s."""
    later, again = stroking.stroke_seconds, reversal > 0.0
    return later if again else stroking.first_seconds, later if again else stroking.set_out

"""A cycle block for the compiled loops: its strokes and dresses, from control and process."""

import functools
import math
from collections.abc import Callable
from typing import Any, NamedTuple

from grind_env.control.rules import DEPTH_TOLERANCE
from grind_env.kernel import inlined
from grind_env.kernel.columns import replacer
from grind_env.machine.loops.pace import paced_of
from grind_env.machine.loops.tally import FINISHING_DEPTH, Tally, count_dress, count_stroke, wheel_depth
from grind_env.process.equations import wheel_speed
from grind_env.process.process import Process, whole_ms
from grind_env.process.state import StrokeParameters, StrokeResult, WheelState


class Stroking(NamedTuple):
    """The strokes of a cycle block, whatever its rules are.

    Depths are mm into the part, `start` from wherever the program counts. In the row of a machine the numbers of the
    rules follow, as `control.cycles` has them.
    """

    speed: float
    """As in `Pace`, mm/s."""
    slow: float
    """As in `Pace`, mm/s."""
    slow_share: float
    """As in `Pace`, a ratio."""
    slow_time: float
    """As in `Pace`, a ratio."""
    first_seconds: float
    """Time of the first stroke, from the start point to the primary point, s."""
    stroke_seconds: float
    """Time of every other stroke, s."""
    set_out: float
    """Time of the first stroke without what it is counted to have waited before, s."""
    start: float
    """Depth at which the wheel stands when the cycle begins, mm."""
    surface: float
    """Height of the touched-off surface above the zero of `start`, mm; depths below it have it added."""
    bottom: float
    """Depth of a stroke at the full depth of the cycle, below the touched-off surface, mm."""
    full_plunge: float
    """By how much a stroke goes deeper at least that counts as a full plunge when power is averaged, mm."""
    finish: float
    """Depth of the finished surface, mm: `bottom` unless a later block goes deeper."""
    width: float
    """Width of the part, mm; of one narrower than the wheel the engaged width b."""
    length: float
    """Ground length Lw, mm."""
    dress_passes: float
    """Number of diamond passes of one execution."""
    dress_feed: float
    """Traverse feed of the diamond, mm/s."""
    dress_depth: float
    """Depth of each pass, mm."""
    dress_seconds: float
    """Time of one execution with set-up, approach and retrace, s."""
    cross_start: float
    """Cross coordinate of the wheel's edge on the minus side where the cycle begins, mm."""
    cross_end: float
    """Where its crossover ends, mm; the same without one."""


class PartState(NamedTuple):
    """The surface under the wheel."""

    Z: float
    """Depth of the deepest stroke, mm."""
    S: float
    """Stock removed, mean over the length, mm."""
    Rs: float
    """Roughness Ra, mean over the length, um."""
    S_step: float = 0.0
    """Stock removed at the fast node less that at the slow one (see `pace`), mm."""
    Rs_step: float = 0.0
    """The same of the roughness, um."""


class Zone(NamedTuple):
    """Strips side by side that only ever lie under the wheel together: what one of them is, all are."""

    S: float
    """Stock removed, mm."""
    Rs: float
    """Roughness Ra, um."""
    reached: float
    """Depth of the deepest stroke so far, mm."""
    centre: float
    """Cross coordinate of the middle of the first of them, mm."""
    strips: float
    """How many they are; 0 where there is no zone, which is then never under the wheel."""
    S_step: float = 0.0
    """As in `PartState`, mm."""
    Rs_step: float = 0.0
    """As in `PartState`, um."""


with_wear = replacer(WheelState, "W")


class Acts(NamedTuple):
    """Compiled functions of a process in a cycle."""

    advance: Callable[..., Any]
    """`advance(stroking, Z, seconds, b, reached, wheel, own, part, tally, slow_k, k)`: one stroke at depth `Z`, mm;
    gives wheel, own, part and tally after it, and the stroke at the slow node and at the other one. `seconds` are its
    time and what of it is its own; `b` is the engaged width, mm; `reached` the depth to which the surface under the
    wheel has been ground at least, mm; `part` the surface in the cut; `slow_k` and `k` what the strokes of the cycle
    have in common at the speed of either node."""
    dress: Callable[..., Any]
    """`dress(stroking, wheel, own, tally, p, waited)`: one dress execution, for which the table has waited so many s;
    gives wheel, own and tally after it."""


@functools.cache
def acts_of(process: Process) -> Acts:
    """What a process does in a cycle."""
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

    return Acts(advance, dress)


@functools.cache
def idle_of(process: Process) -> Callable[..., Any]:
    """Compiled `idle` of a process, with times as they are; it changes nothing where there is none, and in no time."""
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
    """Compiled `grown` of a process; nothing where there is none."""
    return _nothing if process.grown is None else process.grown


@inlined
def _nothing(own: Any, k: Any) -> float:
    return 0.0


@inlined
def dress_lead(wheel: WheelState, feed: float, p: StrokeParameters) -> float:
    """Dress lead, mm per wheel revolution, of a diamond that traverses with `feed` mm/s."""
    return feed * math.pi * wheel.ds / (1000.0 * wheel_speed(wheel.ds, p.n, p.vs_set))


@inlined
def measured(wheel: WheelState) -> WheelState:
    """The wheel once its wear is known, which is then compensated."""
    return with_wear(wheel, (0.0,))


@inlined
def stroke_seconds(stroking: Stroking, reversal: float) -> tuple[float, float]:
    """Time of the stroke after so many reversals of the cycle, and what of it is its own, s."""
    later, again = stroking.stroke_seconds, reversal > 0.0
    return later if again else stroking.first_seconds, later if again else stroking.set_out

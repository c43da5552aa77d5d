"""What engineers compare dresses by: lead, overlap ratio and severity."""

from collections.abc import Iterable, Iterator
from typing import NamedTuple

from grind_env.kernel import plain
from grind_env.machine.dress.program import DressPlan
from grind_env.machine.loops.compiled import dress_lead
from grind_env.process import equations as eq
from grind_env.process.entries import Dresser
from grind_env.process.state import StrokeParameters, WheelState


class Sharpening(NamedTuple):
    """How coarse a dress is; all 0 of one that misses the diamond."""

    lead: float
    """Of the diamond, mm per wheel revolution."""
    overlap: float
    """Overlap ratio Ud: active width of the diamond over the lead."""
    severity: float
    """Severity, over that of a medium dress of 0.02 mm depth and 0.1 mm lead by a new diamond."""


NO_SHARPENING = Sharpening(0.0, 0.0, 0.0)


def sharpening_of(plan: DressPlan, wheel: WheelState, dresser: Dresser, p: StrokeParameters) -> Sharpening:
    """How coarse a dress of a wheel is, which is given as it was before."""
    lead, tip = dress_lead(wheel, plan.feed, p), dresser.tip_radius
    width = plain(eq.dress_width)(min(plan.depth, tip), tip, wheel.wd)  # not wider than the tip, however deep
    severity = plain(eq.severity)(plan.depth, lead, plain(eq.blunting)(wheel.wd, p.b0), p.qs)
    return Sharpening(lead, plain(eq.overlap_ratio)(width, lead), severity)


def sharpenings_of(
    plan: DressPlan, wheel: WheelState, dressed: Iterable[tuple[float, float]], dresser: Dresser, p: StrokeParameters
) -> Iterator[Sharpening]:
    """The same of dresses one after the other, strokes between them.

    Args:
        plan: what each of them does.
        wheel: before the first.
        dressed: of each the wheel diameter after it, mm, and the wheel volume that it took off, mm3.
        dresser: the diamond.
        p: parameters.
    """
    for ds, removed in dressed:
        yield sharpening_of(plan, wheel._replace(ds=ds + 2.0 * plan.passes * plan.depth), dresser, p)
        wheel = wheel._replace(wd=wheel.wd + p.kd * removed)

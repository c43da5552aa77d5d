"""Numbers that compare dresses: lead, overlap ratio and severity."""

from typing import NamedTuple

from grind_env.process import equations as eq
from grind_env.process.entries import Dresser
from grind_env.process.stroke_types import StrokeParameters


class Sharpening(NamedTuple):
    """Coarseness of a dress; all 0 if it misses the diamond."""

    lead: float  #: lead of the diamond, mm per wheel revolution
    overlap: float  #: overlap ratio Ud: active width of the diamond over the lead
    severity: float  #: severity, over that of a medium dress of 0.02 mm depth and 0.1 mm lead by a new diamond


NO_SHARPENING = Sharpening(0.0, 0.0, 0.0)


def sharpening_of(depth: float, lead: float, wd: float, dresser: Dresser, p: StrokeParameters) -> Sharpening:
    """Return the coarseness of a dress.

    Args:
        depth: infeed of a pass, mm.
        lead: lead of the diamond, mm per wheel revolution.
        wd: wear flat of the diamond before the dress, mm.
        dresser: the diamond.
        p: parameters.
    """
    tip = dresser.tip_radius
    width = eq.dress_width(min(depth, tip), tip, wd)  # not wider than the tip, however deep
    severity = eq.severity(depth, lead, eq.blunting(wd, p.b0), p.qs)
    return Sharpening(lead, eq.overlap_ratio(width, lead), severity)

"""Results of gauging a part: size, roughness, and the temperature rise that counts."""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from grind_env.array_types import Array
from grind_env.control.cycle_formulas import DEPTH_TOLERANCE
from grind_env.kernel import inlined
from grind_env.machine.loops.row_io import read_zone
from grind_env.machine.loops.strip_stroke import Strips
from grind_env.machine.loops.stroke_totals import FINISHING_DEPTH


class Surface(NamedTuple):
    """Gauged surface of a part."""

    S: float  #: mean depth ground off, mm
    Ra: float  #: mean roughness, um
    size_error: float  #: mean of the stock left, um
    taper: float  #: range of the depth, um
    worst_error: float  #: stock left where the part is farthest from its size, um


def gauge(depths: Strips, roughness: Strips, stock: float, least: Strips | None = None) -> Surface:
    """Return the surface of a part by the depth ground off each strip or groove, mm, and its roughness, um.

    `least` is the least depth that strokes have reached in each strip, mm; infinite for a strip with one depth
    everywhere.
    """
    S = float(depths.mean())
    error, taper = 1000.0 * (stock - S), 1000.0 * float(depths.max() - depths.min())
    # equal depths: the mean, rounded as for a part without strips
    worst = _farthest(1000.0 * (stock - depths)) if taper > 0.0 else error
    if least is not None and (short := least < depths - DEPTH_TOLERANCE).any():
        worst = _farthest(np.append(1000.0 * (stock - least[short]), worst))
    return Surface(S, float(roughness.mean()), error, taper, worst)


@inlined
def gauge_zones(zones: Array, stock: float) -> Surface:
    """Return the gauged surface of a part; all its strokes have passed over the whole length.

    Args:
        zones: shape (zones, fields of `Zone`).
        stock: stock to grind off, mm.
    """
    first = read_zone(zones, 0)
    least, most, worst = first.S, first.S, 1000.0 * (stock - first.S)
    strips, S, Ra = 0.0, 0.0, 0.0
    for number in range(len(zones)):
        zone = read_zone(zones, number)
        left = 1000.0 * (stock - zone.S)
        least, most = min(least, zone.S), max(most, zone.S)
        worst = left if abs(left) > abs(worst) else worst
        strips += zone.strips
        S += zone.strips * zone.S
        Ra += zone.strips * zone.Rs
    S, Ra = S / strips, Ra / strips
    return Surface(S=S, Ra=Ra, size_error=1000.0 * (stock - S), taper=1000.0 * (most - least), worst_error=worst)


def _farthest(errors: Strips) -> float:
    """Return the size error, um, of the strip or groove that is farthest from its size, which a part is judged by."""
    return float(errors[np.argmax(np.abs(errors))])


def counted_rise(plunges: Iterable[tuple[float, float]], deepest: float, every: bool) -> float:
    """Return the highest temperature rise, K, of plunges (depth mm, rise K) near the deepest, or of every plunge."""
    counts_from = deepest - FINISHING_DEPTH - DEPTH_TOLERANCE
    return max((T for Z, T in plunges if every or counts_from <= Z), default=0.0)

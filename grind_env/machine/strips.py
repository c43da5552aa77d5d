"""One stroke over a part whose surface is kept in strips across its width."""

import numpy as np
from numpy.typing import NDArray

from grind_env.kernel import entry, inlined
from grind_env.process.equations import surface_roughness
from grind_env.process.state import Stroke, StrokeParameters, WheelState
from grind_env.process.stroke import grind_stroke

Strips = NDArray[np.float64]
"""One value per strip of the part."""


@inlined
def in_cut(u: float, deepest: float) -> bool:
    """Whether a strip with interference `u` takes part in a cut whose deepest interference is given."""
    return (u > 0.5 * deepest) | (deepest <= 0.0)


@entry
def grind_strips(
    wheel: WheelState,
    S: Strips,
    Rs: Strips,
    reached: Strips,
    first: int,
    last: int,
    Z: float,
    vw: float,
    width: float,
    Lw: float,
    p: StrokeParameters,
) -> tuple[WheelState, Stroke, float, bool]:
    """One stroke over the strips `first` to `last - 1` of a part, which the wheel covers.

    The strips with more than half of the deepest interference are cut; the others, ground at this depth
    before, only spark. The cut is that of the mean interference over the joint width, and takes the same
    depth off each.

    Args:
        wheel: state before the stroke.
        S: stock removed, mm; updated.
        Rs: roughness, um; updated.
        reached: deepest Z of a stroke so far, mm; updated.
        first: first strip under the wheel.
        last: the strip after the last one, greater than `first`.
        Z: downfeed position, mm.
        vw: table speed, mm/s.
        width: of the part, all strips together, mm.
        Lw: ground length, mm.
        p: parameters.

    Returns:
        The wheel after the stroke, the stroke, the engaged width in mm, and whether the wheel went deeper
        into a strip than before.
    """
    S_least, Rs_first = np.min(S[first:last]), Rs[first]
    deepest = Z - wheel.W - S_least
    # means as offsets from one strip: exact where all are equal, so that a plunge cut is that of one strip
    engaged, S_offset, Rs_offset = 0, 0.0, 0.0
    for i in range(first, last):
        if in_cut(Z - wheel.W - S[i], deepest):
            engaged += 1
            S_offset += S[i] - S_least
            Rs_offset += Rs[i] - Rs_first
    b = width * (engaged / S.size)
    S_mean, Rs_mean = S_least + S_offset / engaged, Rs_first + Rs_offset / engaged
    after, cut = grind_stroke(wheel, S_mean, Rs_mean, Z, vw, b, Lw, p)
    plunged = False
    for i in range(first, last):
        plunged = plunged or reached[i] < Z
        if in_cut(Z - wheel.W - S[i], deepest):
            S[i] += cut.ae
            Rs[i] = surface_roughness(Rs[i], cut.Rg, cut.ae)
        reached[i] = max(reached[i], Z)
    return after, cut, b, plunged

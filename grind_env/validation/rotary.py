"""Group 2: rotary dressers, whose exponents are not those of a stationary diamond."""

from typing import Any

from grind_env.validation.check import Band, Basis, Check, Evidence, around, at_least, at_most
from grind_env.validation.dressing import DEPTHS, LEADS
from grind_env.validation.rig import USUAL, Grinder, Rig
from grind_env.validation.slopes import exponent, smallest_step

L8 = Basis(Evidence.MEASURED, "eight runs with a rotary dresser (Furtwangen University; flat_grinding_L8_dressing.csv)")
RATIOS = (0.3, 0.5, 0.7, 0.9)
"""Speed ratios qd; 1 is crushing."""
AT = f"{USUAL}; dresser rotary"


def rotary(rig: Rig, ratio: float | None = None, **setup: Any) -> Grinder:
    """A wheel freshly dressed by a rotary dresser, with its own speed ratio or another."""
    changes = {} if ratio is None else {"changes": {"dresser": {"speed_ratio": ratio}}}
    return rig.fresh(dresser="rotary", **changes, **setup)


def on_overlap(rig: Rig) -> float:
    """Exponent of Ra on the overlap ratio: at equal depth that is minus the one on the lead."""
    return -exponent(LEADS, [rotary(rig, lead=lead).grind().Rg for lead in LEADS])


def on_speed_ratio(rig: Rig) -> float:
    """Exponent of Ra on qd."""
    return exponent(RATIOS, [rotary(rig, ratio).grind().Rg for ratio in RATIOS])


CHECKS = (
    Check(
        name="rotary roughness on overlap",
        group=2,
        what="exponent of Ra on the overlap ratio Ud, by the lead at equal depth",
        at=f"{AT}; lead .04 to .2 mm, depth .02; stroke 1 after the dress",
        band=around(-1.1, 0.15),
        reference=-1.10,
        measure=on_overlap,
        basis=L8,
    ),
    Check(
        name="rotary roughness on speed ratio",
        group=2,
        what="exponent of Ra on the speed ratio qd",
        at=f"{AT}; qd .3 to .9; stroke 1 after the dress",
        band=around(0.38, 0.18),
        reference=0.38,
        measure=on_speed_ratio,
        basis=L8,
    ),
    Check(
        name="rotary flats towards crushing",
        group=2,
        what="wear-flat area at qd .9 over that at qd .3",
        at=AT,
        band=Band(0.3, 0.97),
        measure=lambda rig: rotary(rig, 0.9).wheel.A / rotary(rig, 0.3).wheel.A,
    ),
    Check(
        name="rotary energy towards crushing",
        group=2,
        what="specific energy at qd .9 over that at qd .3",
        at=f"{AT}; stroke 5",
        band=at_most(0.99),
        measure=lambda rig: rotary(rig, 0.9).grind(5).u_s / rotary(rig, 0.3).grind(5).u_s,
    ),
    Check(
        name="rotary roughness on depth",
        group=2,
        what="Ra after a deeper dress, smallest step",
        at=f"{AT}; depth .005 to .03 mm, lead .1; stroke 1",
        band=at_least(1.0),
        measure=lambda rig: smallest_step([rotary(rig, depth=depth).grind().Rg for depth in DEPTHS]),
    ),
)

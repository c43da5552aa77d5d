"""Group 5: below a threshold force nothing is cut, so that spark-out dies."""

from collections.abc import Callable

from grind_env.process.state import StrokeResult
from grind_env.validation.check import Band, Check, around, at_most
from grind_env.validation.rig import NO_GROWTH, USUAL, Grinder, Rig

PASSES = 10
"""Spark-out passes after which force and power are to be near those of the threshold."""
RESIDUE = 1e-4
"""mm; a pass that cuts so little has all but died."""


def threshold_force(rig: Rig, flats: float | None = None) -> float:
    """Threshold normal force of a sharp wheel, or of one of some wear-flat area, N/mm."""
    return (rig.sharp() if flats is None else rig.dulled(flats)).threshold().Fn


def removed_below(rig: Rig) -> float:
    """What a sharp wheel cuts with half the interference of the threshold, um."""
    grinder = rig.sharp()
    force = grinder.threshold().Fn
    half = 0.5 * force * grinder.setup.width / grinder.p.ke
    return 1000.0 * grinder.trial(half).ae


def after_passes(grinder: Grinder, shown: Callable[[StrokeResult], float]) -> float:
    """What the last of ten spark-out passes shows over what the threshold of the same wheel shows."""
    grinder.grind(10)
    last = grinder.grind(PASSES, 0.0)
    return shown(last) / shown(grinder.threshold())


def residual_power(grinder: Grinder) -> float:
    """Power of a pass that cuts 0.1 um over that of the plunge."""
    return grinder.cut(RESIDUE).power / grinder.grind(5).power


SHARP = f"{USUAL}; sharp"

CHECKS = (
    Check(
        name="threshold force",
        group=5,
        what="threshold normal force",
        at=f"{SHARP}; the stroke that cuts 1 nm",
        unit="N/mm",
        band=Band(0.5, 1.0),
        measure=threshold_force,
    ),
    Check(
        name="threshold of a dull wheel",
        group=5,
        what="threshold force at A 4 % over that of the sharp wheel",
        at=USUAL,
        band=Band(1.2, 5.0),
        measure=lambda rig: threshold_force(rig, 0.04) / threshold_force(rig),
    ),
    Check(
        name="cut below the threshold",
        group=5,
        what="depth cut at half the threshold force",
        at=SHARP,
        unit="um",
        band=Band(0.0, 0.001),
        measure=removed_below,
    ),
    Check(
        name="force after spark-out",
        group=5,
        what="normal force after ten passes over the threshold's",
        at=f"{SHARP}; 10 strokes before; a part that does not grow",
        band=around(1.0, 0.1),
        measure=lambda rig: after_passes(rig.sharp(changes=NO_GROWTH), lambda done: done.Fn),
    ),
    Check(
        name="power after spark-out",
        group=5,
        what="power after ten passes over the threshold's",
        at=f"{SHARP}; 10 strokes before; a part that does not grow",
        band=around(1.0, 0.1),
        measure=lambda rig: after_passes(rig.sharp(changes=NO_GROWTH), lambda done: done.power),
    ),
    Check(
        name="power of the last cut",
        group=5,
        what="power of a pass that cuts 0.1 um over the plunge's",
        at=SHARP,
        band=at_most(0.15),
        measure=lambda rig: residual_power(rig.sharp()),
    ),
    Check(
        name="power of the last cut, half dull",
        group=5,
        what="power of a pass that cuts 0.1 um over the plunge's",
        at=f"{USUAL}; A 2 %",
        band=at_most(0.15),
        measure=lambda rig: residual_power(rig.dulled(0.02)),
    ),
)

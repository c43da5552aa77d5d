"""Group 5: below a threshold force nothing is cut, so that spark-out dies."""

from functools import partial

from grind_env.validation.check import Band, Question, around, at_most
from grind_env.validation.measures import Quantity, dull, value
from grind_env.validation.rig import NO_GROWTH, Grinder, Rig

PASSES = 10
"""Spark-out passes after which force and power are to be near those of the threshold."""
RESIDUE = 1e-4
"""mm; a pass that cuts so little has all but died."""

ask = partial(Question, 5)


def threshold_force(grinder: Grinder) -> float:
    """Return the threshold normal force, N/mm."""
    return grinder.threshold().Fn


def threshold_when_dull(rig: Rig) -> float:
    """Return the threshold force of a dull wheel over that of a sharp one."""
    return threshold_force(rig.dulled(0.04)) / threshold_force(rig.sharp())


def removed_below(grinder: Grinder) -> float:
    """Return what half the interference of the threshold cuts, um."""
    half = 0.5 * threshold_force(grinder) * grinder.setup.width / grinder.p.ke
    return 1000.0 * grinder.trial(half).ae


def after_passes(name: str) -> Quantity:
    """Return the quantity `name` of the last of ten spark-out passes over that of the threshold of the same wheel."""

    def over_threshold(grinder: Grinder) -> float:
        grinder.grind(10)
        last = grinder.grind(PASSES, 0.0)
        return float(getattr(last, name) / getattr(grinder.threshold(), name))

    return over_threshold


def residual_power(grinder: Grinder) -> float:
    """Return the power of a pass that cuts 0.1 um over that of the plunge."""
    return grinder.cut(RESIDUE).power / grinder.grind(5).power


AFTER = "usual; sharp; 10 strokes before; a part that does not grow"
LAST = "power of a pass that cuts 0.1 um over the plunge's"

CHECKS = (
    ask("threshold force", "threshold normal force", "usual; sharp; the stroke that cuts 1 nm").within(
        Band(0.5, 1.0), value(threshold_force), unit="N/mm"
    ),
    ask("threshold of a dull wheel", "threshold force at A 4 % over that of the sharp wheel").within(
        Band(1.2, 5.0), threshold_when_dull
    ),
    ask("cut below the threshold", "depth cut at half the threshold force", "usual; sharp").within(
        Band(0.0, 0.001), value(removed_below), unit="um"
    ),
    ask("force after spark-out", "normal force after ten passes over the threshold's", AFTER).within(
        around(1.0, 0.1), value(after_passes("Fn"), changes=NO_GROWTH)
    ),
    ask("power after spark-out", "power after ten passes over the threshold's", AFTER).within(
        around(1.0, 0.1), value(after_passes("power"), changes=NO_GROWTH)
    ),
    ask("power of the last cut", LAST, "usual; sharp").within(at_most(0.15), value(residual_power)),
    ask("power of the last cut, half dull", LAST, "usual; A 2 %").within(
        at_most(0.15), value(residual_power, dull(0.02))
    ),
)

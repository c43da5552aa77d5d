"""Group 5: below a threshold force nothing is cut, so that spark-out dies."""

from functools import partial

from grind_env.validation.check import Band, Question, around, at_most
from grind_env.validation.measures import Quantity, dull, value
from grind_env.validation.rig import NO_GROWTH, Grinder

PASSES = 10
"""Spark-out passes after which force and power are to be near those of the threshold."""

ask = partial(Question, 5)


def cut_at_half_the_threshold(grinder: Grinder) -> float:
    """Return the depth of cut at half the interference of the threshold, um."""
    return 1000.0 * grinder.trial(0.5 * grinder.threshold().Fn * grinder.setup.width / grinder.p.ke).ae


def after_passes(name: str) -> Quantity:
    """Return the quantity `name` of the last of ten spark-out passes over that of the threshold of the same wheel."""

    def over_threshold(grinder: Grinder) -> float:
        grinder.grind(10)
        last = grinder.grind(PASSES, 0.0)
        return float(getattr(last, name) / getattr(grinder.threshold(), name))

    return over_threshold


def residual_power(grinder: Grinder) -> float:
    """Return the power of a pass that cuts 0.1 um, and so has all but died, over that of the plunge."""
    return grinder.cut(1e-4).power / grinder.grind(5).power


AFTER = "usual; sharp; 10 strokes before; a part that does not grow"
LAST = "power of a pass that cuts 0.1 um over the plunge's"

CHECKS = (
    ask("threshold force", "threshold normal force", "usual; sharp; the stroke that cuts 1 nm").within(
        Band(0.5, 1.0), value(lambda grinder: grinder.threshold().Fn), unit="N/mm"
    ),
    ask("threshold of a dull wheel", "threshold force at A 4 % over that of the sharp wheel").within(
        Band(1.2, 5.0), lambda rig: rig.dulled(0.04).threshold().Fn / rig.sharp().threshold().Fn
    ),
    ask("cut below the threshold", "depth cut at half the threshold force", "usual; sharp").within(
        Band(0.0, 0.001), value(cut_at_half_the_threshold), unit="um"
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

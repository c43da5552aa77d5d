"""A wheel whose grade changes with its diameter, and a diamond that chips."""

from typing import Any, NamedTuple

import numpy as np

from grind_env.kernel import exp, inlined
from grind_env.kernel.random import uniform
from grind_env.kernel.row_accessors import replacer
from grind_env.plants.event_random import words_of
from grind_env.plants.family import Family, ranges_of
from grind_env.process.equations import RENEWAL_EXPONENT
from grind_env.process.process_interface import Drive, Hook, Moment
from grind_env.process.stroke_types import StrokeParameters, WheelState


class GradedOwn(NamedTuple):
    """Memory of the hook; `ranges.toml` describes the drawn fields."""

    graded_seed: float = 0.0
    graded_swing: float = 0.0
    graded_pitch: float = 1.0
    graded_phase: float = 0.0
    graded_chips: float = 0.0
    graded_flat: float = 0.0


chipped, graded = replacer(WheelState, "wd"), replacer(StrokeParameters, "fc", "Gref", "dr")


@inlined
def ring(at: float) -> float:
    """Return a triangle wave of period 1 between -1 and 1."""
    wave: float = 1.0 - 4.0 * abs(at - np.floor(at) - 0.5)
    return wave


@inlined
def _before(
    wheel: WheelState, own: Any, p: StrokeParameters, drive: Drive, moment: Moment
) -> tuple[WheelState, Any, StrokeParameters, Drive]:
    """Denser rings are harder; the grade changes fc, Gref and dr as in the catalogue (`wheel_composition`)."""
    harder = own.graded_swing * ring(wheel.ds / own.graded_pitch + own.graded_phase)
    p = graded(p, (p.fc * exp(harder), p.Gref * exp(0.5 * harder), p.dr * exp(RENEWAL_EXPONENT * harder)))
    chips = uniform(words_of(own.graded_seed, moment)[0]) < own.graded_chips
    return chipped(wheel, (own.graded_flat if chips else wheel.wd,)), own, p, drive


GRADED = Family(
    name="graded",
    what="the wheel has harder and softer rings, and now and then the dressing diamond chips to another flat",
    ranges=ranges_of("graded"),
    chances=True,
    hook=Hook(_before, GradedOwn),
)

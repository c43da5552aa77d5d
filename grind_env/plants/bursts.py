"""Bursts of grain pull-out: the wheel face does not renew smoothly by wear, but at once when a threshold is passed."""

import functools
from typing import Any, NamedTuple

from grind_env.kernel import exp, inlined
from grind_env.kernel.row_accessors import replacer
from grind_env.plants.event_random import deviate, words_of
from grind_env.plants.family import Family, ranges_of
from grind_env.process.equations import early_loss, early_wear
from grind_env.process.process_interface import Drive, Hook, Moment, Process
from grind_env.process.stroke_types import StrokeConstants, StrokeParameters, StrokeResult, WheelState


class BurstsOwn(NamedTuple):
    """Memory of the process and its hook; `ranges.toml` describes the drawn fields."""

    bursts_seed: float = 0.0
    bursts_share: float = 0.0
    bursts_at: float = 1.0
    bursts_takes: float = 1.0
    bursts_spread: float = 0.0
    bursts_threshold: float = 1.0  #: owed renewal at which grains pull out in this block
    #: owed renewal of the face: minus the logarithm of the share of the old face that it would leave
    bursts_owed: float = 0.0


renewing, pull_out = replacer(StrokeConstants, "per_dr"), replacer(WheelState, "A", "lam")
owing, hold = replacer(None, "bursts_owed"), replacer(None, "bursts_threshold")


@functools.cache
def _bursting(inner: Process) -> Process:
    """Return a process with a share of the renewal in bursts; a burst renews as much as smooth wear or more."""
    grind, sharpen = inner.stroke, inner.dress

    @inlined
    def stroke(
        wheel: WheelState, own: Any, S: float, Rs: float, Z: float, b: float, k: StrokeConstants, seconds: float
    ) -> tuple[WheelState, Any, StrokeResult]:
        smooth = renewing(k, ((1.0 - own.bursts_share) * k.per_dr,))
        after, own, done = grind(wheel, own, S, Rs, Z, b, smooth, seconds)
        early = early_wear(early_loss(wheel.Cd, k.Cref, k.wi), wheel.V, after.V - wheel.V, k.per_Vi)
        owed = own.bursts_owed + own.bursts_share * k.per_dr * max(done.dw - early, 0.0)
        bursts = owed > own.bursts_threshold
        left = exp(-own.bursts_takes * owed)
        A = k.Af + (after.A - k.Af) * left if bursts else after.A
        lam = after.lam * left if bursts else after.lam
        return pull_out(after, (A, lam)), owing(own, (0.0 if bursts else owed,)), done

    @inlined
    def dress(
        wheel: WheelState, own: Any, passes: float, lead: float, depth: float, p: StrokeParameters
    ) -> tuple[WheelState, Any, float]:
        """Dress as the inner process does; afterwards no renewal is owed."""
        wheel, own, removed = sharpen(wheel, own, passes, lead, depth, p)
        return wheel, owing(own, (0.0,)), removed

    return inner._replace(stroke=stroke, dress=dress)


@inlined
def _before(
    wheel: WheelState, own: Any, p: StrokeParameters, drive: Drive, moment: Moment
) -> tuple[WheelState, Any, StrokeParameters, Drive]:
    """Draw the threshold of the block; no two bursts are alike."""
    word = words_of(own.bursts_seed, moment)[0]
    return wheel, hold(own, (own.bursts_at * exp(own.bursts_spread * deviate(word)),)), p, drive


BURSTS = Family(
    name="bursts",
    what="grains pull out in bursts instead of renewing the wheel face smoothly",
    ranges=ranges_of("bursts"),
    chances=True,
    wraps=_bursting,
    hook=Hook(_before, BurstsOwn),
    anew=("bursts_owed",),
)

"""Group 1: what lead, depth and passes of a stationary diamond do to the wheel."""

from collections.abc import Callable

from grind_env.process.state import StrokeResult
from grind_env.validation.check import FALLS, RISES, Band, Basis, Check, Evidence, around
from grind_env.validation.rig import USUAL, Grinder, Rig
from grind_env.validation.slopes import exponent, largest_step, smallest_step

DEPTHS = (0.005, 0.010, 0.020, 0.030)
"""mm; at the lead of the set-up, 0.1 mm."""
ALL_DEPTHS = (0.002, *DEPTHS, 0.050)
LEADS = (0.04, 0.07, 0.10, 0.14, 0.20)
"""mm per revolution; at the depth of the set-up, 0.02 mm."""

MALKIN = Basis(Evidence.REMEMBERED, "Ra ~ lead^(1/2) depth^(1/4): Malkin, Grinding Technology")
SEVERITY = Basis(Evidence.OWN, "which way, by the severity 2 ad (fd/dg)^(1/2): Malkin & Murray 1978 (from memory)")


def over(name: str, values: tuple[float, ...], shown: Callable[[Grinder], float]) -> Callable[[Rig], list[float]]:
    """What freshly dressed wheels show for several values of an argument of `SetUp`."""
    return lambda rig: [shown(rig.fresh(**{name: value})) for value in values]


def flats(grinder: Grinder) -> float:
    """Wear-flat area."""
    return grinder.wheel.A


def first(grinder: Grinder) -> StrokeResult:
    """The first stroke."""
    return grinder.grind()


def fifth(grinder: Grinder) -> StrokeResult:
    """The fifth stroke, by which the depth of cut has come up to the downfeed."""
    return grinder.grind(5)


def roughness_exponents(dresser: str) -> tuple[Check, ...]:
    """Exponents of the roughness that a stationary dresser leaves."""

    def fitted(name: str, values: tuple[float, ...], number: int) -> Callable[[Rig], float]:
        return lambda rig: exponent(
            values, [rig.fresh(dresser=dresser, **{name: value}).grind(number).Rg for value in values]
        )

    at = f"{USUAL}; dresser {dresser}"
    ends = {
        "depth": ("depth .005 to .03 mm, lead .1", Band(0.15, 0.35), DEPTHS),
        "lead": ("lead .04 to .2 mm, depth .02", Band(0.4, 0.7), LEADS),
    }
    return tuple(
        Check(
            name=f"{dresser} roughness on {name} stroke {number}",
            group=1,
            what=f"exponent of Ra on dress {name}",
            at=f"{at}; {said}; stroke {number} after the dress",
            band=band,
            measure=fitted(name, values, number),
            basis=MALKIN,
        )
        for name, (said, band, values) in ends.items()
        for number in (1, 5)
    )


def equal_overlap(rig: Rig) -> float:
    """Wear flats of a deep dress with a large lead over those of a shallow one with a small lead; equal overlap."""
    deep, shallow = (rig.fresh(depth=depth, lead=lead).wheel.A for depth, lead in ((0.020, 0.10), (0.005, 0.05)))
    return deep / shallow


def further_passes(shown: Callable[[Grinder], float]) -> Callable[[Rig], float]:
    """What a dull wheel shows after sixteen passes over what it shows after eight."""

    def ratio(rig: Rig) -> float:
        values = []
        for passes in (8.0, 16.0):
            grinder = rig.dulled(0.04)
            grinder.dress(passes)
            values.append(shown(grinder))
        return values[1] / values[0]

    return ratio


def worn_diamond(shown: Callable[[Grinder], float]) -> Callable[[Rig], float]:
    """What a wheel shows after a dress with a diamond of 0.3 mm wear flat over what a sharp diamond leaves."""
    return lambda rig: shown(rig.fresh(diamond_flat=0.3)) / shown(rig.fresh())


def later_dress(shown: Callable[[Grinder], float]) -> Callable[[Rig], float]:
    """What a wheel shows after 300 dresses with one diamond over what it shows after the first."""

    def ratio(rig: Rig) -> float:
        grinder = rig.fresh()
        grinder.dress()
        before = shown(rig.fresh())
        for _ in range(299):
            grinder.dress()
        grinder.wheel = grinder.wheel._replace(ds=grinder.setup.diameter)
        return shown(grinder) / before

    return ratio


def steps(name: str, values: tuple[float, ...], shown: Callable[[Grinder], float]) -> Callable[[Rig], float]:
    """The largest step of what freshly dressed wheels show."""
    return lambda rig: largest_step(over(name, values, shown)(rig))


CHECKS = (
    Check(
        name="flats on depth",
        group=1,
        what="wear-flat area after a deeper dress, largest step",
        at=f"{USUAL}; depth .002 to .05 mm, lead .1",
        band=FALLS,
        measure=steps("depth", ALL_DEPTHS, flats),
        basis=SEVERITY,
    ),
    Check(
        name="energy on depth",
        group=1,
        what="specific energy after a deeper dress, largest step",
        at=f"{USUAL}; depth .002 to .05 mm, lead .1; stroke 5",
        band=FALLS,
        measure=steps("depth", ALL_DEPTHS, lambda grinder: fifth(grinder).u_s),
        basis=SEVERITY,
    ),
    Check(
        name="roughness rises with depth",
        group=1,
        what="Ra after a deeper dress, smallest step",
        at=f"{USUAL}; depth .002 to .05 mm, lead .1; stroke 5",
        band=RISES,
        measure=lambda rig: smallest_step(over("depth", ALL_DEPTHS, lambda grinder: fifth(grinder).Rg)(rig)),
    ),
    Check(
        name="flats on lead",
        group=1,
        what="wear-flat area after a dress of larger lead, largest step",
        at=f"{USUAL}; lead .04 to .2 mm, depth .02",
        band=FALLS,
        measure=steps("lead", LEADS, flats),
        basis=SEVERITY,
    ),
    Check(
        name="energy on lead",
        group=1,
        what="specific energy after a dress of larger lead, largest step",
        at=f"{USUAL}; lead .04 to .2 mm, depth .02; stroke 5",
        band=FALLS,
        measure=steps("lead", LEADS, lambda grinder: fifth(grinder).u_s),
        basis=SEVERITY,
    ),
    *roughness_exponents("single_point"),
    *roughness_exponents("blade"),
    Check(
        name="flats at equal overlap",
        group=1,
        what="wear-flat area, depth .02 lead .1 over depth .005 lead .05, of equal overlap ratio",
        at=USUAL,
        band=Band(0.3, 0.95),
        measure=equal_overlap,
        basis=SEVERITY,
    ),
    Check(
        name="flats of further passes",
        group=1,
        what="wear-flat area of a dull wheel after 16 passes over that after 8",
        at=f"{USUAL}; A 4 % before the dress",
        band=around(1.0, 0.02),
        measure=further_passes(flats),
    ),
    Check(
        name="roughness of further passes",
        group=1,
        what="Ra of a dull wheel after 16 passes over that after 8",
        at=f"{USUAL}; A 4 % before the dress; stroke 1",
        band=around(1.0, 0.02),
        measure=further_passes(lambda grinder: first(grinder).Rg),
    ),
    Check(
        name="flats of a worn diamond",
        group=1,
        what="wear-flat area after a dress with a worn diamond over that of a sharp one",
        at=f"{USUAL}; flat of the diamond .3 mm",
        band=Band(1.05, 2.0),
        measure=worn_diamond(flats),
    ),
    Check(
        name="roughness of a worn diamond",
        group=1,
        what="Ra after a dress with a worn diamond over that of a sharp one",
        at=f"{USUAL}; flat of the diamond .3 mm; stroke 1",
        band=Band(0.5, 0.95),
        measure=worn_diamond(lambda grinder: first(grinder).Rg),
    ),
    Check(
        name="flats of a later dress",
        group=1,
        what="wear-flat area after 300 dresses with one diamond over that after the first",
        at=USUAL,
        band=RISES,
        measure=later_dress(flats),
    ),
    Check(
        name="roughness of a later dress",
        group=1,
        what="Ra after 300 dresses with one diamond over that after the first",
        at=f"{USUAL}; stroke 1",
        band=FALLS,
        measure=later_dress(lambda grinder: first(grinder).Rg),
    ),
)

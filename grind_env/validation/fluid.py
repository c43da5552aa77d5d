"""Group 4: fluid acts on friction, wear and loading, and not on heat alone."""

from grind_env.validation.check import Band, Check, at_least, at_most
from grind_env.validation.rig import USUAL, Grinder, Rig

FLUIDS = ("emulsion", "synthetic", "oil", "dry")
FORCE_RATIOS = {"dry": Band(0.55, 0.65), "emulsion": Band(0.40, 0.50), "oil": Band(0.35, 0.45)}
WHEELS = {"a60j": "alumina", "b126": "cBN"}
INTERVAL = 500.0
"""mm3/mm; from the dress on over which G-ratios of steady wear are taken."""


def force_ratio(wheel: str, fluid: str) -> Check:
    """Tangential over normal force."""

    def measure(rig: Rig) -> float:
        done = rig.sharp(wheel=wheel, fluid=fluid).grind(5)
        return done.Ft / done.Fn

    return Check(
        name=f"force ratio {wheel} {fluid}",
        group=4,
        what=f"Ft/Fn, {WHEELS[wheel]}, {fluid}",
        at=f"{USUAL}; {wheel}, {fluid}; sharp",
        band=FORCE_RATIOS[fluid],
        measure=measure,
    )


def used(rig: Rig, wheel: str, fluid: str, volume: float) -> Grinder:
    """A wheel that has ground some mm3/mm from the dress on."""
    grinder = rig.fresh(wheel=wheel, fluid=fluid)
    grinder.grind_volume(volume)
    return grinder


def steady_g(rig: Rig, wheel: str, fluid: str) -> float:
    """G-ratio of steady wear."""
    grinder = rig.steady(wheel=wheel, fluid=fluid)
    grinder.grind_volume(INTERVAL)
    return grinder.g_ratio()


def dry_wear(wheel: str) -> Check:
    """That a wheel wears fastest without a fluid."""

    def measure(rig: Rig) -> float:
        ratios = {fluid: steady_g(rig, wheel, fluid) for fluid in FLUIDS}
        return ratios.pop("dry") / min(ratios.values())

    return Check(
        name=f"dry wear {wheel}",
        group=4,
        what=f"G-ratio dry over the least one with a fluid, {WHEELS[wheel]}",
        at=f"{USUAL}; {wheel}; steady wear over 500 mm3/mm from the dress on",
        band=at_most(0.9),
        measure=measure,
    )


def dry_loading(rig: Rig) -> float:
    """Loading dry over the most with a fluid."""
    loading = {fluid: used(rig, "a60j", fluid, 300.0).wheel.lam for fluid in FLUIDS}
    return loading.pop("dry") / max(loading.values())


CHECKS = (
    *(force_ratio(wheel, fluid) for wheel in WHEELS for fluid in FORCE_RATIOS),
    Check(
        name="oil wear b126",
        group=4,
        what="G-ratio in oil over that in emulsion, cBN",
        at=f"{USUAL}; b126; steady wear over 500 mm3/mm from the dress on",
        band=at_least(2.0),
        measure=lambda rig: steady_g(rig, "b126", "oil") / steady_g(rig, "b126", "emulsion"),
    ),
    *(dry_wear(wheel) for wheel in WHEELS),
    Check(
        name="dry loading",
        group=4,
        what="loading dry over the most with a fluid",
        at=f"{USUAL}; 300 mm3/mm after the dress",
        band=at_least(1.2),
        measure=dry_loading,
    ),
)

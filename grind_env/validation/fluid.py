"""Group 4: fluid acts on friction, wear and loading, and not on heat alone."""

from functools import partial

from grind_env.validation.check import Band, Question, at_least, at_most
from grind_env.validation.measures import Measurement, g_over, over, quotient, used, value
from grind_env.validation.rig import Grinder, Rig

FLUIDS = over("fluid", ("dry", "emulsion", "synthetic", "oil"))
FORCE_RATIOS = {"dry": Band(0.55, 0.65), "emulsion": Band(0.40, 0.50), "oil": Band(0.35, 0.45)}
WHEELS = {"a60j": "alumina", "b126": "cBN"}
STEADY = "steady wear over 500 mm3/mm from the dress on"

ask = partial(Question, 4)


def steady(wheel: str) -> partial[Grinder]:
    """Make wheels of which nothing is loose."""
    return partial(Rig.steady, wheel=wheel)


CHECKS = (
    *(
        ask(
            f"force ratio {wheel} {fluid}", f"Ft/Fn, {WHEELS[wheel]}, {fluid}", f"usual; {wheel}, {fluid}; sharp"
        ).within(band, value(lambda grinder: (done := grinder.grind(5)).Ft / done.Fn, wheel=wheel, fluid=fluid))
        for wheel in WHEELS
        for fluid, band in FORCE_RATIOS.items()
    ),
    ask("oil wear b126", "G-ratio in oil over that in emulsion, cBN", f"usual; b126; {STEADY}").within(
        at_least(2.0), Measurement(g_over(500.0), over("fluid", ("oil", "emulsion")), quotient, steady("b126"))
    ),
    *(
        ask(
            f"dry wear {wheel}", f"G-ratio dry over the least one with a fluid, {name}", f"usual; {wheel}; {STEADY}"
        ).within(
            at_most(0.9),
            Measurement(g_over(500.0), FLUIDS, lambda dry_first: dry_first[0] / min(dry_first[1:]), steady(wheel)),
        )
        for wheel, name in WHEELS.items()
    ),
    ask("dry loading", "loading dry over the most with a fluid", "usual; 300 mm3/mm after the dress").within(
        at_least(1.2),
        Measurement(
            lambda grinder: grinder.wheel.lam, FLUIDS, lambda dry_first: dry_first[0] / max(dry_first[1:]), used(300.0)
        ),
    ),
)

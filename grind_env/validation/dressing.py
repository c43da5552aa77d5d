"""Groups 1 and 2: what lead, depth and passes of stationary diamonds and rotary dressers do to the wheel."""

from functools import partial

from grind_env.evidence import Basis, Evidence
from grind_env.validation.check import FALLS, RISES, Band, Check, Question, around, at_least, at_most
from grind_env.validation.measures import Measurement, changed_over, exponent_on, flats, over, quotient, stroke
from grind_env.validation.rig import Grinder, Rig
from grind_env.validation.slopes import exponent, largest_step, smallest_step

DEPTHS = (0.005, 0.010, 0.020, 0.030)
"""mm; at the lead of the set-up, 0.1 mm."""
LEADS = (0.04, 0.07, 0.10, 0.14, 0.20)
"""mm per revolution; at the depth of the set-up, 0.02 mm."""
SPEED_RATIOS = (0.3, 0.5, 0.7, 0.9)
"""Speed ratios qd of a rotary dresser; 1 is crushing."""

MALKIN = Basis(Evidence.REMEMBERED, "Ra ~ lead^(1/2) depth^(1/4): Malkin, Grinding Technology")
SEVERITY = Basis(Evidence.OWN, "which way, by the severity 2 ad (fd/dg)^(1/2): Malkin & Murray 1978 (from memory)")
L8 = Basis(Evidence.MEASURED, "eight runs with a rotary dresser (Furtwangen University; flat_grinding_L8_dressing.csv)")

DEEPER, LARGER = "usual; depth .002 to .05 mm, lead .1", "usual; lead .04 to .2 mm, depth .02"
ALL_DEPTHS, ALL_LEADS = over("depth", (0.002, *DEPTHS, 0.050)), over("lead", LEADS)
EXPONENTS = (
    ("depth", "depth .005 to .03 mm, lead .1", Band(0.15, 0.35), DEPTHS),
    ("lead", "lead .04 to .2 mm, depth .02", Band(0.4, 0.7), LEADS),
)
"""Exponents of Ra on a setting of the dress: the setting, its conditions, the band, and the values of the setting."""
EQUAL_OVERLAP = ({"depth": 0.020, "lead": 0.10}, {"depth": 0.005, "lead": 0.05})

ask = partial(Question, 1)


def roughness_exponents(dresser: str) -> list[Check]:
    """Return checks of the roughness that a stationary dresser leaves."""
    return [
        ask(
            f"{dresser} roughness on {name} stroke {number}",
            f"exponent of Ra on dress {name}",
            f"usual; dresser {dresser}; {at}; stroke {number} after the dress",
        ).within(band, exponent_on(name, values, stroke("Rg", number), dresser=dresser), MALKIN)
        for name, at, band, values in EXPONENTS
        for number in (1, 5)
    ]


def dull_then_dressed(rig: Rig, passes: float) -> Grinder:
    """Make a dull wheel and dress it with some passes."""
    grinder = rig.dulled(0.04)
    grinder.dress(passes)
    return grinder


def dressed_often(rig: Rig, dresses: int) -> Grinder:
    """Make a wheel of the usual diameter after further dresses with one diamond."""
    grinder = rig.fresh()
    for _ in range(dresses):
        grinder.dress()
    grinder.wheel = grinder.wheel._replace(ds=grinder.setup.diameter)
    return grinder


further_passes = partial(Measurement, setups=over("passes", (16.0, 8.0)), reduce=quotient, make=dull_then_dressed)
worn_diamond = partial(Measurement, setups=over("diamond_flat", (0.3, 0.0)), reduce=quotient)
later_dress = partial(Measurement, setups=over("dresses", (300, 0)), reduce=quotient, make=dressed_often)

STATIONARY = (
    ask("flats on depth", "wear-flat area after a deeper dress, largest step", DEEPER).within(
        FALLS, Measurement(flats, ALL_DEPTHS, largest_step), SEVERITY
    ),
    ask("energy on depth", "specific energy after a deeper dress, largest step", f"{DEEPER}; stroke 5").within(
        FALLS, Measurement(stroke("u_s"), ALL_DEPTHS, largest_step), SEVERITY
    ),
    ask("roughness rises with depth", "Ra after a deeper dress, smallest step", f"{DEEPER}; stroke 5").within(
        RISES, Measurement(stroke("Rg"), ALL_DEPTHS, smallest_step)
    ),
    ask("flats on lead", "wear-flat area after a dress of larger lead, largest step", LARGER).within(
        FALLS, Measurement(flats, ALL_LEADS, largest_step), SEVERITY
    ),
    ask("energy on lead", "specific energy after a dress of larger lead, largest step", f"{LARGER}; stroke 5").within(
        FALLS, Measurement(stroke("u_s"), ALL_LEADS, largest_step), SEVERITY
    ),
    *roughness_exponents("single_point"),
    *roughness_exponents("blade"),
    ask(
        "flats at equal overlap", "wear-flat area, depth .02 lead .1 over depth .005 lead .05, of equal overlap ratio"
    ).within(Band(0.3, 0.95), Measurement(flats, EQUAL_OVERLAP, quotient), SEVERITY),
    ask(
        "flats of further passes",
        "wear-flat area of a dull wheel after 16 passes over that after 8",
        "usual; A 4 % before the dress",
    ).within(around(1.0, 0.02), further_passes(flats)),
    ask(
        "roughness of further passes",
        "Ra of a dull wheel after 16 passes over that after 8",
        "usual; A 4 % before the dress; stroke 1",
    ).within(around(1.0, 0.02), further_passes(stroke("Rg", 1))),
    ask(
        "flats of a worn diamond",
        "wear-flat area after a dress with a worn diamond over that of a sharp one",
        "usual; flat of the diamond .3 mm",
    ).within(Band(1.05, 2.0), worn_diamond(flats)),
    ask(
        "roughness of a worn diamond",
        "Ra after a dress with a worn diamond over that of a sharp one",
        "usual; flat of the diamond .3 mm; stroke 1",
    ).within(Band(0.5, 0.95), worn_diamond(stroke("Rg", 1))),
    ask("flats of a later dress", "wear-flat area after 300 dresses with one diamond over that after the first").within(
        RISES, later_dress(flats)
    ),
    ask(
        "roughness of a later dress",
        "Ra after 300 dresses with one diamond over that after the first",
        "usual; stroke 1",
    ).within(FALLS, later_dress(stroke("Rg", 1))),
)

ask_rotary = partial(Question, 2)
rotary = partial(Measurement, make=partial(Rig.fresh, dresser="rotary"))
AT = "usual; dresser rotary"
CRUSHING, QD = (changed_over("dresser", "speed_ratio", ratios) for ratios in ((0.9, 0.3), SPEED_RATIOS))


def on_overlap(values: list[float]) -> float:
    """Return the exponent on the overlap ratio: at equal depth that is minus the one on the lead."""
    return -exponent(LEADS, values)


ROTARY = (
    ask_rotary(
        "rotary roughness on overlap",
        "exponent of Ra on the overlap ratio Ud, by the lead at equal depth",
        f"{AT}; lead .04 to .2 mm, depth .02; stroke 1 after the dress",
    ).within(around(-1.1, 0.15), rotary(stroke("Rg", 1), ALL_LEADS, on_overlap), L8, reference=-1.10),
    ask_rotary(
        "rotary roughness on speed ratio",
        "exponent of Ra on the speed ratio qd",
        f"{AT}; qd .3 to .9; stroke 1 after the dress",
    ).within(around(0.38, 0.18), rotary(stroke("Rg", 1), QD, partial(exponent, SPEED_RATIOS)), L8, reference=0.38),
    ask_rotary("rotary flats towards crushing", "wear-flat area at qd .9 over that at qd .3", AT).within(
        Band(0.3, 0.97), rotary(flats, CRUSHING, quotient)
    ),
    ask_rotary(
        "rotary energy towards crushing", "specific energy at qd .9 over that at qd .3", f"{AT}; stroke 5"
    ).within(at_most(0.99), rotary(stroke("u_s"), CRUSHING, quotient)),
    ask_rotary(
        "rotary roughness on depth",
        "Ra after a deeper dress, smallest step",
        f"{AT}; depth .005 to .03 mm, lead .1; stroke 1",
    ).within(at_least(1.0), rotary(stroke("Rg", 1), over("depth", DEPTHS), smallest_step)),
)
CHECKS = (*STATIONARY, *ROTARY)

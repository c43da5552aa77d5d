"""Package and prototype, compared number by number through the same strokes, dresses and waits.

The prototype (`prototype.py`) is a second implementation of the process model from its specification. The cases are
those of model-2.md, section 10.
"""

import dataclasses
import math
import random

import pytest

from grind_env.process.catalogue_parameters import stroke_parameters
from grind_env.process.process_interface import PROCESS
from grind_env.process.stroke_and_dress import dressed_wheel
from grind_env.process.stroke_types import StrokeResult
from tests.process import prototype
from tests.process.harness import CATALOGUE, WarmGrinder, grinder, parameters
from tests.process.prototype import Setup, State

NEAR = 1e-9  #: relative tolerance between bisection and closed form, after a thousand strokes that build on each other
ROUNDING = 1e-12  #: absolute tolerance: rounding of positions of about 1 mm

CASES = {
    # material, wheel, fluid, wheel speed m/s, table speed m/min, downfeed mm
    "R1": ("aisi_52100", "a60j", "emulsion", 30.0, 12.0, 0.010),
    "R1b": ("aisi_52100", "a60j", "emulsion", 30.0, 20.0, 0.020),
    "R2": ("aisi_1045", "a60j", "emulsion", 30.0, 18.0, 0.015),
    "R3a": ("inconel_718", "a60j", "emulsion", 25.0, 10.0, 0.010),
    "R3b": ("inconel_718", "b126", "emulsion", 35.0, 10.0, 0.010),
    "R4": ("aisi_52100", "b126", "emulsion", 35.0, 15.0, 0.010),
    "R5": ("aisi_d2", "a46h", "emulsion", 30.0, 12.0, 0.010),
    "R6": ("aisi_52100", "a120k", "emulsion", 30.0, 12.0, 0.005),
    "R7": ("aisi_52100", "a60j", "oil", 30.0, 12.0, 0.010),
    "R8": ("grey_cast_iron", "a60j", "emulsion", 30.0, 12.0, 0.025),
    "D2": ("aisi_d2", "a60j", "emulsion", 30.0, 12.0, 0.010),
    "A120K": ("aisi_52100", "a120k", "emulsion", 30.0, 12.0, 0.010),
    "dry": ("grey_cast_iron", "a60j", "dry", 30.0, 7.8, 0.025),
}


def setup_of(case: str) -> Setup:
    material, wheel, fluid, wheel_speed, table_speed, _ = CASES[case]
    return Setup(
        CATALOGUE.material(material),
        CATALOGUE.wheel(wheel),
        CATALOGUE.dresser("single_point"),
        CATALOGUE.fluid(fluid),
        CATALOGUE.machine("default"),
        wheel_speed,
        table_speed / 0.06,
    )


def downfeed_of(case: str) -> float:
    return CASES[case][-1]


def assert_alike(found: dict[str, float], expected: dict[str, float]) -> None:
    unlike = {
        name: (number, expected[name])
        for name, number in found.items()
        if not math.isclose(number, expected[name], rel_tol=NEAR, abs_tol=ROUNDING)
    }
    assert unlike == {}


class Both(WarmGrinder):
    """Package and prototype side by side, compared after every step."""

    def __init__(self, at: Setup, lead: float = 0.10, depth: float = 0.020, diamond_flat: float = 0.0) -> None:
        entries = (at.material, at.wheel, at.dresser, at.fluid, at.machine)
        p = stroke_parameters(*entries, wheel_speed=at.wheel_speed, width=at.width, height=at.height)
        wheel = dressed_wheel(at.wheel.diameter, diamond_flat, lead, depth, p)
        super().__init__(p, 0.06 * at.table_speed, wheel, at.width, at.length)
        self.at = at
        self.second = prototype.fresh(at, lead, depth, diameter=at.wheel.diameter, wd=diamond_flat)
        self.compare()

    def compare(self) -> None:
        state = {**self.wheel._asdict(), "Z": self.Z, "S": self.S, "Rs": self.Rs, **self.own._asdict()}
        second = dataclasses.asdict(self.second)
        second |= {f"dT_{mode}": rise for mode, rise in enumerate(second.pop("dT"), 1)}
        assert state.keys() == second.keys()
        assert_alike(state, second)

    def stroke(self, downfeed: float = 0.0, seconds: float = 1.8) -> StrokeResult:
        stroke = super().stroke(downfeed, seconds)
        self.second, expected = prototype.ground(self.second, self.at, downfeed, seconds)
        if stroke.torque < 1.0:  # a stalled spindle has no other valid number
            assert stroke._asdict().keys() == expected.keys()
            assert_alike(stroke._asdict(), expected)
            self.compare()
        else:
            assert expected["torque"] >= 1.0
            # the prototype goes on from the state of the package
            self.second = State(**self.wheel._asdict(), Z=self.Z, S=self.S, Rs=self.Rs, dT=tuple(self.own))
        return stroke

    def dress(self, passes: float = 2.0, lead: float = 0.10, depth: float = 0.020) -> float:
        self.wheel, self.own, removed = PROCESS.dress(self.wheel, self.own, passes, lead, depth, self.p)
        assert removed == pytest.approx(prototype.dressed_off(self.second, self.at, passes, depth), rel=NEAR)
        self.second = prototype.dressed(self.second, self.at, passes, lead, depth)
        self.compare()
        return removed

    def wait(self, seconds: float) -> None:
        super().wait(seconds)
        self.second = prototype.waited(self.second, self.at, seconds)
        self.compare()

    def load(self) -> None:
        super().load()
        self.second = prototype.loaded(self.second)
        self.compare()

    def dull(self, A: float) -> None:
        """Set the flats to an area."""
        self.wheel, self.second = self.wheel._replace(A=A), dataclasses.replace(self.second, A=A)


@pytest.mark.parametrize("case", CASES)
def test_both_agree_in_a_long_cut_with_a_dressed_wheel(case: str) -> None:
    """Grind a part of a tenth of a millimetre, then up to 2000 mm3/mm of stock, then spark out."""
    both = Both(setup_of(case))
    both.strokes(10, 0.010)
    both.strokes(4)
    both.load()
    while both.wheel.V < 2000.0:
        both.stroke(downfeed_of(case))
    both.strokes(6)


@pytest.mark.parametrize("case", CASES)
def test_both_agree_with_a_dull_wheel(case: str) -> None:
    both = Both(setup_of(case))
    for _ in range(25):
        both.dull(0.04)
        stroke = both.stroke(downfeed_of(case))
    assert stroke.burn_ratio > 0.5


@pytest.mark.parametrize("depth", [0.1, 0.5, 3.0])
def test_both_agree_in_a_deep_pass_at_a_slow_feed(depth: float) -> None:
    at = setup_of("R1")
    strong = dataclasses.replace(at.machine, power_limit=500_000)
    for table_speed in (0.02, 0.3, 1.5):
        both = Both(dataclasses.replace(at, machine=strong, table_speed=table_speed / 0.06))
        assert both.stroke(depth).torque < 1.0


@pytest.mark.parametrize("table_speed", [4.0, 12.0, 30.0])
def test_both_agree_on_parts_of_a_tenth_of_a_millimetre(table_speed: float) -> None:
    """Grind ten strokes of 10 um and two spark-outs. The part warms up and grows; the next part is cold."""
    both = Both(dataclasses.replace(setup_of("R1"), table_speed=table_speed / 0.06))
    for part in range(40):
        both.load()
        assert both.own == PROCESS.own()
        both.strokes(10, 0.010)
        hot = sum(both.own)
        both.strokes(2)
        both.wait(5.0)
        assert 0.0 < sum(both.own) < hot
        if part % 15 == 14:
            both.dress()
            both.wait(16.4)


@pytest.mark.parametrize("dresser", CATALOGUE.dressers)
@pytest.mark.parametrize("lead", [0.04, 0.10, 0.20])
@pytest.mark.parametrize("depth", [0.005, 0.020, 0.040])
def test_both_agree_in_strokes_after_any_dress(dresser: str, lead: float, depth: float) -> None:
    at = dataclasses.replace(setup_of("R1"), dresser=CATALOGUE.dresser(dresser))
    for diamond_flat in (0.0, 0.3):
        both = Both(at, lead, depth, diamond_flat)
        both.strokes(20, 0.010)
        both.dress(1.0, lead, depth)
        both.strokes(20, 0.010)


@pytest.mark.parametrize("seed", range(60))
def test_both_agree_on_random_strokes_dresses_and_waits_in_any_set_up(seed: int) -> None:
    """Feeds go down, up or nowhere; spindles slow and stall; some wheels only rub."""
    draw = random.Random(seed)
    entries = (CATALOGUE.materials, CATALOGUE.wheels, CATALOGUE.dressers, CATALOGUE.fluids)
    machine = dataclasses.replace(
        CATALOGUE.machine("default"),
        power_limit=draw.choice([1500, 3000, 7500]),
        stiffness=draw.choice([1e4, 2e4, 2e5]),
    )
    at = Setup(
        *(draw.choice([*each.values()]) for each in entries),
        machine,
        wheel_speed=draw.choice([20.0, 30.0, 45.0]),
        table_speed=draw.uniform(3.0, 40.0) / 0.06,
        width=draw.uniform(2.0, 25.0),
        height=draw.uniform(5.0, 60.0),
        length=draw.uniform(20.0, 300.0),
    )
    both = Both(at)
    for _ in range(60):
        what = draw.random()
        if what < 0.05:
            both.dress(float(draw.randint(1, 6)), draw.uniform(0.02, 0.30), draw.uniform(0.002, 0.040))
        elif what < 0.10:
            both.wait(draw.uniform(0.0, 60.0))
        elif what < 0.12:
            both.load()
        both.stroke(draw.choice([0.0, 1e-4, 0.001, 0.005, 0.010, 0.030, -0.005]), draw.uniform(0.3, 6.0))


def test_both_agree_in_rubbing_lifting_slowing_stalling_and_boiling() -> None:
    at = setup_of("R1")
    both = Both(dataclasses.replace(at, machine=dataclasses.replace(at.machine, power_limit=1500)))
    both.dull(0.02)
    rubs, lifts = both.stroke(1e-4), both.stroke(-0.010)
    assert rubs.ae == 0.0 < rubs.Fn
    assert lifts.Fn == 0.0
    harder = [both.stroke(0.001 * downfeed) for downfeed in range(10, 40, 2)]
    assert any(stroke.torque < 1.0 and stroke.vs < 0.99 * at.wheel_speed for stroke in harder)
    assert harder[-1].torque >= 1.0
    wet, boiled = Both(at), Both(at)
    boiled.dull(0.10)
    assert wet.strokes(3, 0.010)[-1].T < at.fluid.boiling_rise - 10.0 < 200.0 < boiled.strokes(3, 0.010)[-1].T


# flats relative to a medium dress, by hand: s = ad/.02 sqrt(fd/.1), (0.25 + 0.75/sqrt(s))
DRESSES = [(0.10, 0.005, 1.75), (0.10, 0.080, 0.625), (0.40, 0.020, 0.25 + 0.75 / math.sqrt(2.0)), (0.025, 0.040, 1.0)]


@pytest.mark.parametrize(("lead", "depth", "flats"), DRESSES)
def test_wear_flats_of_a_dressed_wheel_match_values_by_hand(lead: float, depth: float, flats: float) -> None:
    machine = grinder(parameters(), lead=lead, depth=depth)
    assert pytest.approx(flats * CATALOGUE.wheel("a60j").dressed_wear_flat, rel=1e-12) == machine.wheel.A


def test_constant_surface_speed_does_not_fall_as_the_wheel_shrinks() -> None:
    p = parameters(constant_surface_speed=True)
    new, used = (grinder(p, diameter=diameter).stroke(0.020) for diameter in (300.0, 220.0))
    assert new == grinder(parameters()).stroke(0.020)
    assert (new.vs, used.vs) == (30.0, 30.0)

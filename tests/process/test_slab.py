"""Heat in the part: four modes against a slab of thin layers, and against analytic limits."""

import math
from functools import cached_property

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import eigh_tridiagonal

from grind_env.array_types import Array
from grind_env.process.equations.part_slab import slab_modes
from tests.process.harness import CATALOGUE, parameters

STEEL = CATALOGUE.material("aisi_52100")
CAPACITY = STEEL.density * STEEL.specific_heat
#: height, conductivity, heat capacity of a volume, conductances into fluid and chuck; SI
SLABS = [
    (height, STEEL.conductivity, CAPACITY, top, bottom)
    for height in (0.005, 0.010, 0.020, 0.040, 0.080)
    for top in (1000.0, 3000.0, 6000.0)
    for bottom in (1000.0, 3000.0)
]
TIMES = np.geomspace(0.1, 300.0, 60)  #: times after a pulse or after the last pulse of a train, s
LEFT = 0.01  #: share of the growth by a pulse; below it the tolerance is absolute, 0.05 % of the pulse

Slab = tuple[float, float, float, float, float]


class Layers:
    """Slab of isothermal layers, thin near the upper face; exact in time."""

    def __init__(self, height: float, conductivity: float, capacity: float, top: float, bottom: float) -> None:
        thickness = np.geomspace(1.0, 300.0, 240)
        thickness *= height / thickness.sum()
        half = 0.5 * thickness / conductivity
        holds = capacity * thickness
        to_fluid, to_chuck = (1.0 / (1.0 / h + r) for h, r in ((top, half[0]), (bottom, half[-1])))
        between = 1.0 / (half[:-1] + half[1:])
        leaves = np.zeros(thickness.size)
        leaves[:-1] += between
        leaves[1:] += between
        leaves[0] += to_fluid
        leaves[-1] += to_chuck
        self.root = root = np.sqrt(holds)
        self.rates, self.shapes = eigh_tridiagonal(leaves / holds, -between / (root[:-1] * root[1:]))

    def growth(self, after: Array) -> Array:
        """Return the share of a pulse's heat, and so of its growth, that is left `after` s later."""
        amplitudes = self.shapes[0] / self.root[0] * np.exp(-np.outer(after, self.rates))
        return np.asarray((amplitudes @ self.shapes.T * self.root).sum(1))


class Modes:
    """Modes of the package for a slab."""

    def __init__(self, *slab: float) -> None:
        self.shares, self.rates = (np.array(each) for each in slab_modes(*slab))

    @cached_property
    def lasting(self) -> float:
        """Mean rise under a steady flux, relative to the rise of an insulated part in 1 s, s."""
        return float((self.shares / self.rates).sum())

    def growth(self, after: Array) -> Array:
        return np.asarray((self.shares * np.exp(-np.outer(after, self.rates))).sum(1))


def train(of: Layers | Modes, pulses: int, period: float, after: Array) -> Array:
    """Return the growth by a train of pulses, `after` s past the last one."""
    return np.sum([of.growth(after + period * number) for number in range(pulses)], axis=0)


@pytest.mark.parametrize("slab", SLABS)
def test_growth_after_a_pulse_matches_the_layered_slab(slab: Slab) -> None:
    """The tolerance is 5 % of the growth while 1 % of the pulse is left, and absolute after that."""
    exact, found = Layers(*slab).growth(TIMES), Modes(*slab).growth(TIMES)
    assert (np.abs(found - exact) <= 0.05 * np.maximum(exact, LEFT)).all()


@pytest.mark.parametrize("slab", SLABS[::3])
@pytest.mark.parametrize("period", [0.2, 1.0, 5.0])
def test_growth_in_a_train_of_pulses_matches_the_layered_slab(slab: Slab, period: float) -> None:
    layers, modes = Layers(*slab), Modes(*slab)
    for pulses in (5, 50):
        exact, found = (train(each, pulses, period, TIMES[::4]) for each in (layers, modes))
        assert (np.abs(found - exact) <= 0.05 * np.maximum(exact, LEFT)).all()


@pytest.mark.parametrize("slab", SLABS)
def test_modes_begin_without_loss_and_end_in_a_straight_profile(slab: Slab) -> None:
    height, conductivity, capacity, top, bottom = slab
    modes = Modes(*slab)
    assert modes.shares.sum() == pytest.approx(1.0, rel=1e-12)
    # a flux of 1 raises the faces by `upper` and `lower`; the chuck takes the heat that the fluid leaves
    lower = 1.0 / (top * (1.0 + bottom * height / conductivity) + bottom)
    upper = lower * (1.0 + bottom * height / conductivity)
    assert top * upper + bottom * lower == pytest.approx(1.0, rel=1e-12)
    assert modes.lasting == pytest.approx(capacity * height * 0.5 * (upper + lower), rel=1e-9)


@given(
    height=st.floats(1e-4, 0.1), conductivity=st.floats(6.0, 500.0), top=st.floats(0.0, 1e5), bottom=st.floats(0.0, 1e5)
)
def test_growth_after_a_pulse_stays_between_minus_0_1_and_1_12(
    height: float, conductivity: float, top: float, bottom: float
) -> None:
    modes = Modes(height, conductivity, CAPACITY, top, bottom)
    growth = modes.growth(np.array([0.0, *TIMES]))
    assert (modes.rates >= 0.0).all()
    assert growth[0] == pytest.approx(1.0, abs=1e-9)
    assert (growth >= -0.1).all() and (growth <= (1.1 if conductivity >= 12.5 else 1.12)).all()


@pytest.mark.parametrize(("top", "bottom"), [(30.0, 0.0), (0.0, 30.0), (20.0, 10.0)])
def test_a_well_conducting_part_cools_as_a_lump(top: float, bottom: float) -> None:
    """The Biot number is 0.001; the reference is Newton's law."""
    shares, rates = slab_modes(0.010, 300.0, CAPACITY, top, bottom)
    assert shares[0] == pytest.approx(1.0, abs=0.001)
    assert rates[0] == pytest.approx((top + bottom) / (CAPACITY * 0.010), rel=0.001)


def test_an_insulated_part_keeps_its_heat() -> None:
    assert slab_modes(0.020, 34.3, CAPACITY, 0.0, 0.0) == ((1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0))
    nearly = Modes(0.020, 34.3, CAPACITY, 1e-3, 1e-3)
    assert nearly.growth(TIMES) == pytest.approx(1.0, abs=1e-5)


@pytest.mark.parametrize(("bottom", "seconds"), [(0.0, 43.0), (1000.0, 26.0), (3000.0, 17.2)])
def test_the_slowest_decay_of_20_mm_of_bearing_steel_matches_the_series(bottom: float, seconds: float) -> None:
    """Under 3000 W/(m2 K), by the roots of the series. A lump would give 26, 20 and 13 s."""
    _, rates = slab_modes(0.020, STEEL.conductivity, CAPACITY, 3000.0, bottom)
    assert 1.0 / rates[0] == pytest.approx(seconds, rel=0.005)
    b = math.sqrt(rates[0] * CAPACITY / STEEL.conductivity) * 0.020
    top, below = 3000.0 * 0.020 / STEEL.conductivity, bottom * 0.020 / STEEL.conductivity
    assert (b * b - top * below) * math.tan(b) == pytest.approx(b * (top + below), rel=1e-9)


def test_parameters_contain_the_modes_of_fluid_and_chuck() -> None:
    p, fluid, machine = parameters(), CATALOGUE.fluid("emulsion"), CATALOGUE.machine("default")
    modes = slab_modes(0.020, STEEL.conductivity, CAPACITY, fluid.part_cooling, machine.chuck_conductance)
    assert ((p.w_1, p.w_2, p.w_3, p.w_4), (p.r_1, p.r_2, p.r_3, p.r_4)) == modes

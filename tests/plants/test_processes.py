"""Strokes of the two families that replace the process: neutral numbers, limits, and their laws."""

import math
from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from grind_env.plants import FAMILIES, Plant
from grind_env.plants.bursts import BURSTS
from grind_env.plants.foreign import DEPTH, FOREIGN, SPEED, VOLUME, depth_share
from grind_env.plants.plant import mixed
from grind_env.process.stroke_types import StrokeParameters, StrokeResult
from tests.plants.written import Shop, written
from tests.process.harness import parameters

OURS = Plant(name="ours")
LAWS = {"foreign_force": 1.0, "foreign_f": 0.75, "foreign_e": 0.4, "foreign_q": 0.6, "foreign_d": 0.7}


def foreign(**numbers: float) -> Plant:
    named = {f"foreign_{name}": number for name, number in numbers.items()}
    return mixed("foreign", (FOREIGN,), LAWS | named)


def bursting(**numbers: float) -> Plant:
    return mixed("bursts", (BURSTS,), {f"bursts_{name}": number for name, number in numbers.items()})


def bare(**changes: float) -> StrokeParameters:
    """Return parameters of a stiff machine with a wheel that neither fractures nor has early wear."""
    return parameters(ke=1e12, power=1e9, kf=0.0, wi=0.0, **changes)


def first(plant: Plant, depth: float = DEPTH, speed: float = SPEED, **state: float) -> StrokeResult:
    """Return a stroke of exactly this depth, mm, and speed, mm/s."""
    shop = Shop(plant, bare(), table_speed=0.06 * speed)
    shop.wheel = shop.wheel._replace(**state)
    return shop.stroke(depth)


@pytest.mark.parametrize("family", FAMILIES, ids=lambda family: family.name)
def test_neutral_numbers_change_no_bit_of_a_stroke_or_a_dress(family) -> None:
    plain, other = Shop(OURS), Shop(mixed(family.name, (family,), {}))
    other.begin()
    for downfeed in (0.02, 0.01, 0.0, -0.05):
        assert plain.stroke(downfeed) == other.stroke(downfeed)
    for shop in (plain, other):
        shop.dress()
    assert plain.wheel == other.wheel
    assert other.own == other.plant.remembers()._replace(**plain.own._asdict())


# --- foreign


@settings(deadline=None)
@given(kappa=st.floats(1e-9, 1e9), f=st.floats(0.5, 1.0))
def test_the_depth_of_cut_solves_its_balance(kappa: float, f: float) -> None:
    y = written(depth_share)(kappa, f)
    assert y + kappa * y**f == pytest.approx(1.0, rel=1e-9)


@pytest.mark.parametrize("A", [0.008, 0.03])
@pytest.mark.parametrize("factor", [0.75, 1.35])
def test_foreign_factors_scale_force_roughness_and_wear_at_the_nominal_point(factor: float, A: float) -> None:
    ours = first(OURS, A=A)
    theirs = first(foreign(force=factor, ra=factor, wear=factor), A=A)
    assert theirs.ae == pytest.approx(DEPTH, rel=1e-6)
    assert theirs.Ft / ours.Ft == pytest.approx(factor, rel=1e-6)
    assert theirs.Rg / ours.Rg == pytest.approx(factor, rel=1e-6)
    assert theirs.dw / ours.dw == pytest.approx(factor, rel=1e-6)


@pytest.mark.parametrize("depth", [0.005, 0.02])
def test_force_roughness_and_wear_are_powers_of_the_chip_thickness(depth: float) -> None:
    plant = foreign()
    at, other = first(plant), first(plant, depth)
    thicker = math.log(other.heq / at.heq)
    assert thicker == pytest.approx(math.log(depth / DEPTH), rel=1e-6)
    assert math.log(other.Ft / at.Ft) / thicker == pytest.approx(0.75)
    assert math.log(other.Rg / at.Rg) / thicker == pytest.approx(0.4)
    assert math.log(other.G / at.G) / thicker == pytest.approx(-0.6)
    faster = first(plant, DEPTH * SPEED / 400.0, 400.0)  # chips of equal thickness
    assert (faster.Ft, faster.Rg) == pytest.approx((at.Ft, at.Rg))


def test_flats_grow_as_a_power_of_volume_and_at_our_rate_at_nominal_volume() -> None:
    ours, theirs = (Shop(plant, bare(Amax=1e9, dr=1e9)) for plant in (OURS, foreign()))
    grown, volume = [], []
    start = theirs.wheel.A
    while theirs.wheel.V < 1.5 * VOLUME:
        theirs.stroke(DEPTH)
        grown.append(theirs.wheel.A - start)
        volume.append(theirs.wheel.V)
    powers = [(V + 1.0) ** 0.7 - 1.0 for V in volume]
    assert [A / grown[-1] for A in grown] == pytest.approx([power / powers[-1] for power in powers], rel=1e-4)
    k = next(k for k, V in enumerate(volume) if V > VOLUME)
    ours.wheel = ours.wheel._replace(V=VOLUME)
    heat = math.exp(0.002 * (ours.stroke(DEPTH).T - 200.0))  # the foreign law leaves heat out
    assert (grown[k] - grown[k - 1]) * heat == pytest.approx(ours.wheel.A - start, rel=0.01)


def test_the_machine_deflects_under_the_force_of_the_law() -> None:
    shop = Shop(foreign())
    for downfeed in (0.01, 0.01, 0.01, 0.0, 0.0):
        u = shop.Z + downfeed - shop.wheel.W - shop.S
        done = shop.stroke(downfeed)
        assert u - done.ae == pytest.approx(shop.width * done.Fn / shop.p.ke, rel=1e-6)
    nothing = shop.stroke(-1.0)
    assert nothing.Q == nothing.Ft == nothing.dw == 0.0


def test_dull_flats_and_higher_force_factors_take_more_power() -> None:
    sharp, dull = (first(foreign(), A=A).power for A in (0.008, 0.04))
    assert sharp < dull
    assert first(foreign(force=0.75)).power < sharp < first(foreign(force=1.35)).power
    grown = [Shop(foreign(dulls=factor)) for factor in (0.75, 1.35)]
    for shop in grown:
        shop.strokes(10, 0.01)
    assert grown[0].wheel.A < grown[1].wheel.A


# --- bursts


def dulled(plant: Plant, strokes: int) -> list[float]:
    """Return the flats after each stroke of a wheel that begins dull and dulls no further."""
    shop = Shop(plant, bare(kA=0.0))
    shop.wheel = shop.wheel._replace(A=0.05, V=1e4)
    found = []
    for _ in range(strokes):
        shop.stroke(0.01)
        found.append(shop.wheel.A)
    return found


def test_grains_pull_out_in_bursts_and_not_between_them() -> None:
    flats = dulled(bursting(share=1.0, threshold=0.01), 60)
    steps = {round(after / before, 9) for before, after in pairwise(flats)}
    assert 1.0 in steps and min(steps) < 0.995
    smooth = dulled(OURS, 60)
    assert all(b < a for a, b in pairwise(smooth))


def test_bursts_renew_flats_like_smooth_wear_times_their_factor() -> None:
    smooth, bursts, more = (
        dulled(plant, 300)[-1]
        for plant in (OURS, bursting(share=1.0, threshold=0.01), bursting(share=1.0, threshold=0.01, takes=4.0))
    )
    assert bursts == pytest.approx(smooth, rel=0.02)
    Af = parameters().Af
    assert math.log((0.05 - Af) / (more - Af)) == pytest.approx(4.0 * math.log((0.05 - Af) / (bursts - Af)))


def test_a_dress_clears_owed_wear_and_burst_thresholds_scatter() -> None:
    shop = Shop(bursting(seed=2.0, share=1.0, at=0.2, spread=0.3))
    shop.strokes(3, 0.01)
    assert shop.own.bursts_owed > 0.0
    shop.dress()
    assert shop.own.bursts_owed == 0.0
    found = []
    for number in range(300):
        shop.begin(number=number)
        found.append(math.log(shop.own.bursts_threshold / 0.2))
    assert sum(found) / 300 == pytest.approx(0.0, abs=0.06)
    assert (sum(x * x for x in found) / 300) ** 0.5 == pytest.approx(0.3, rel=0.15)

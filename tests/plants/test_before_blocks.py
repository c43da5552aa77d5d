"""Effects of the families before a block and on readings: directions, limits, and numbers by hand."""

import math
from typing import Any

import numpy as np
import pytest

from grind_env.envs.task_gauges import GAUGE, noisy
from grind_env.plants import FAMILIES, Plant
from grind_env.plants.plant import mixed
from grind_env.process import equations as eq
from grind_env.process.gauge_readings import QUIET, GaugeReadings, chain_gauges
from tests.plants.written import Shop, written
from tests.process.harness import CATALOGUE, parameters

FAMILY = {each.name: each for each in FAMILIES}
TRUTH = GaugeReadings(
    mean_power=2000.0, first_power=1500.0, peak_power=3000.0, size_error=4.0, roughness=0.8, diameter=290.0
)
POWERS = ("mean_power", "first_power", "peak_power")


def machine(name: str, **numbers: float) -> Plant:
    """Return a machine of a family with these numbers and neutral numbers otherwise."""
    return mixed(name, (FAMILY[name],), {f"{name}_{field}": number for field, number in numbers.items()})


def readings(plant: Plant, seconds: float = 0.0, own: Any = None) -> GaugeReadings:
    """Return the readings of the truth without noise; the diameter keeps its steps."""
    own = plant.remembers(*plant.own) if own is None else own
    found, _ = written(plant.gauge.read)(TRUTH, own, seconds, QUIET)
    return found


@pytest.mark.parametrize("name", [name for name, family in FAMILY.items() if family.hook])
def test_neutral_numbers_change_nothing_before_a_block(name: str) -> None:
    shop = Shop(machine(name))
    wheel = shop.wheel
    for number in range(3):
        assert shop.begin(number=number, seconds=3000.0 * number, place=250.0) == shop.p
    assert shop.wheel == wheel and shop.drive == (1.0, 0.15)
    assert tuple(shop.own) == tuple(shop.plant.remembers())


@pytest.mark.parametrize("name", [name for name, family in FAMILY.items() if family.gauge])
def test_neutral_numbers_change_no_reading(name: str) -> None:
    assert readings(machine(name), 5000.0) == TRUTH


# --- meter


def test_the_gain_of_a_meter_scales_power_readings_only() -> None:
    found = readings(machine("meter", gain=1.2))
    assert [getattr(found, name) for name in POWERS] == pytest.approx([1.2 * getattr(TRUTH, name) for name in POWERS])
    assert found._replace(**dict.fromkeys(POWERS, 0.0)) == TRUTH._replace(**dict.fromkeys(POWERS, 0.0))


def test_a_lagging_meter_shows_less_of_the_first_stroke_and_of_peaks() -> None:
    found = readings(machine("meter", lag=1.0))
    assert found[:3] == (2000.0, 750.0, 2500.0)  # half of the first power, and half of the peak above the mean
    assert readings(machine("meter", lag=1e9))[:3] == pytest.approx((2000.0, 0.0, 2000.0), abs=1e-3)


def test_the_idle_reading_creeps_to_its_final_share() -> None:
    plant = machine("meter", idle=1000.0, creeps=-0.1, warms=600.0)
    assert readings(plant, 600.0).mean_power == pytest.approx(2000.0 - 100.0 * (1.0 - math.exp(-1.0)))
    assert readings(plant, 1e6)[:3] == pytest.approx((1900.0, 1400.0, 2900.0))


# --- thermal


def test_a_growing_head_cuts_deeper_by_its_growth_since_the_last_block() -> None:
    shop = Shop(machine("thermal", grows=100.0, warms=3600.0))
    shop.begin(seconds=1800.0)
    first = shop.wheel.W
    assert first == pytest.approx(-0.1 * (1.0 - math.exp(-0.5)))
    shop.wheel = shop.wheel._replace(W=0.0)  # touched off
    shop.begin(number=1, seconds=3600.0)
    assert first + shop.wheel.W == pytest.approx(-0.1 * (1.0 - math.exp(-1.0)))
    assert first < shop.wheel.W  # it settles


def test_the_zero_of_the_gauge_drifts() -> None:
    plant = machine("thermal", drifts=3.0, warms=3600.0)
    assert readings(plant, 3600.0).size_error == pytest.approx(4.0 + 3.0 * (1.0 - math.exp(-1.0)))
    assert readings(plant, 1e7) == TRUTH._replace(size_error=pytest.approx(7.0))


# --- table, soft, fluid


def test_lag_and_rest_of_the_table_grow_in_proportion_to_its_speed() -> None:
    shop = Shop(machine("table", behind=0.2, rests=0.3))
    drives = []
    for E in (15_000.0, 30_000.0):
        shop.begin(E=E)
        drives.append(shop.drive)
    assert drives == [pytest.approx((0.9, 0.3)), pytest.approx((0.8, 0.45))]


def test_a_soft_machine_yields_more_and_most_at_the_end_of_the_table() -> None:
    shop = Shop(machine("soft", gives=2.0, end=1.5))
    stiff = [shop.begin(place=place).ke for place in (0.0, 150.0, 300.0, -900.0)]
    assert stiff == pytest.approx([shop.p.ke / gives for gives in (2.0, 2.5, 3.0, 3.0)])


def test_a_soft_machine_leaves_more_stock() -> None:
    stiff, soft = Shop(machine("soft")), Shop(machine("soft", gives=4.0))
    for shop in (stiff, soft):
        shop.p = shop.begin()
        shop.strokes(6, 0.01)
    assert soft.S < stiff.S < 0.06


def test_warm_coolant_boils_sooner_and_the_nozzle_clogs_after_a_time() -> None:
    shop = Shop(machine("fluid", hotter=10.0, warms=3600.0, clogs=0.5, clogs_at=1800.0))
    early, late, last = (shop.begin(seconds=seconds) for seconds in (1800.0, 5400.0, 1e6))
    assert early.Tb == pytest.approx(shop.p.Tb - 10.0 * (1.0 - math.exp(-0.5))) and early.hf == shop.p.hf
    assert late.hf == pytest.approx(shop.p.hf * math.exp(-0.5))
    assert (last.Tb, last.hf) == (pytest.approx(shop.p.Tb - 10.0), pytest.approx(0.2 * shop.p.hf))


# --- graded


def test_a_graded_ring_equals_the_catalogue_wheel_of_its_grade() -> None:
    wheel = CATALOGUE.wheel("a46j")
    swing = math.log(0.8 / 1.2)
    shop = Shop(machine("graded", swing=swing, pitch=10.0, phase=0.5), parameters(wheel="a46j"))
    shop.wheel = shop.wheel._replace(ds=wheel.diameter)
    found, soft = shop.begin(), parameters(wheel="a46h")
    assert (found.fc, found.Gref, found.dr) == pytest.approx((soft.fc, soft.Gref, soft.dr))


def test_rings_repeat_and_average_to_the_nominal_hardness() -> None:
    shop = Shop(machine("graded", swing=0.5, pitch=8.0, phase=0.25))
    hard = []
    for ds in np.arange(280.0, 296.0, 0.125):
        shop.wheel = shop.wheel._replace(ds=float(ds))
        hard.append(math.log(shop.begin().fc / shop.p.fc))
    assert hard[:64] == pytest.approx(hard[64:]) and np.mean(hard) == pytest.approx(0.0, abs=1e-12)
    assert max(hard) == pytest.approx(0.5) and min(hard) == pytest.approx(-0.5)


def test_a_diamond_chips_at_random_and_its_flat_blunts_the_dress() -> None:
    shop = Shop(machine("graded", seed=5.0, chips=0.1, flat=0.2))
    chipped = []
    for number in range(400):
        shop.wheel = shop.wheel._replace(wd=0.0)
        shop.begin(number=number)
        chipped.append(shop.wheel.wd)
    assert {*chipped} == {0.0, 0.2}
    assert 20 < np.count_nonzero(chipped) < 60  # 40 are expected, with a standard deviation of 6
    sharp, blunt = (eq.blunting(wd, shop.p.b0) for wd in (0.0, 0.2))
    assert sharp < blunt


# --- drift


def walked(blocks: int, **numbers: float) -> np.ndarray:
    """Return the logs of the factors on kA and pm, and the idle power in W, after each block."""
    shop, found = Shop(machine("drift", **numbers)), []
    for number in range(blocks):
        p = shop.begin(number=number)
        found.append((math.log(p.kA / shop.p.kA), math.log(p.pm / shop.p.pm), shop.p.power - p.power))
        assert shop.own[-3:] == pytest.approx(found[-1], abs=1e-9)
    return np.array(found)


def test_drift_steps_have_their_standard_deviations_and_no_correlation() -> None:
    steps = np.diff(walked(600, seed=3.0, dulls=0.002, presses=0.001, idles=0.5), axis=0)
    assert np.std(steps, axis=0) == pytest.approx([0.002, 0.001, 0.5], rel=0.1)
    assert np.abs(np.corrcoef(steps.T) - np.eye(3)).max() < 0.15
    assert np.abs(np.mean(steps, axis=0) / np.std(steps, axis=0)).max() < 0.15


def test_drift_stays_within_its_bounds_and_repeats_with_its_seed() -> None:
    far = walked(60, seed=3.0, dulls=0.5, presses=0.2, idles=200.0)
    assert np.abs(far).max(axis=0) == pytest.approx([math.log(2.5), 0.2, 300.0])
    assert (far == walked(60, seed=3.0, dulls=0.5, presses=0.2, idles=200.0)).all()
    assert (far != walked(60, seed=4.0, dulls=0.5, presses=0.2, idles=200.0)).any(axis=0).all()


def test_drifted_idle_power_adds_to_power_readings() -> None:
    plant = machine("drift", idles=50.0)
    own = plant.remembers(*plant.own)._replace(drift_idle=120.0)
    assert readings(plant, own=own)[:3] == (2120.0, 1620.0, 3120.0)


# --- gauges in a chain


def test_chained_gauges_build_on_each_other_and_add_noise_once() -> None:
    numbers = {"meter_gain": 1.1, "drift_idle": 100.0, "thermal_drifts": 2.0, "thermal_warms": 1.0}
    plant = mixed("all", FAMILIES, numbers)
    found = readings(plant, 1e3)
    assert found.mean_power == pytest.approx(1.1 * 2000.0 + 100.0)  # in the order of the mix: the meter first
    assert found.size_error == pytest.approx(6.0)
    noise = GaugeReadings(*[1.0] * 6)
    own = plant.remembers(*plant.own)
    both, _ = written(noisy(plant.gauge).read)(TRUTH, own, 1e3, noise)
    plain, _ = written(GAUGE.read)(found._replace(diameter=TRUTH.diameter), own, 1e3, noise)
    assert both == plain and noisy(chain_gauges()) is GAUGE
    assert all(chain_gauges(*gauges) is chain_gauges(*gauges) for gauges in ((), (FAMILY["meter"].gauge,)))

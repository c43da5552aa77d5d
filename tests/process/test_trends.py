"""The trends that an implementation of the process model has to show (model.md, section 12, by its numbers).

The tenth, that states stay finite and within their bounds, is the subject of test_bounds.py.
"""

import math
from collections.abc import Callable
from itertools import pairwise, product

import numpy as np
import pytest

from grind_env.process import equations as eq
from grind_env.process.state import StrokeParameters
from tests.process.harness import Grinder, cut, grinder, parameters
from tests.process.jobs import deep_cycles, small_parts, stroke_seconds

ALUMINA, CBN = parameters(), parameters(wheel="b126")
INCONEL = parameters("inconel_718", wheel_speed=25.0)


def settled(p: StrokeParameters, table_speed: float = 12.0, **state: float) -> Grinder:
    """A grinder whose dressed topography has worn in."""
    return grinder(p, table_speed, **{"V": 400.0, "A": 0.015, **state})


def log_slope(value: Callable[[float], float], at: float) -> float:
    step = 1.02
    return math.log(value(at * step) / value(at / step)) / (2.0 * math.log(step))


def rising(values: list[float]) -> bool:
    return all(first < second for first, second in pairwise(values))


def falling(values: list[float]) -> bool:
    return rising(values[::-1])


# --- 1 ------------------------------------------------------------------------------------------------------


def test_specific_energy_falls_with_the_removal_rate_towards_the_chip_energy() -> None:
    for p in (ALUMINA, CBN):
        over_depth = [cut(depth, settled(p)).u_s for depth in (0.001, 0.004, 0.010, 0.040, 1.0, 1e3, 1e5)]
        over_speed = [cut(0.010, settled(p, speed)).u_s for speed in (3.0, 6.0, 12.0, 24.0, 40.0)]
        assert falling(over_depth)
        assert falling(over_speed)
        assert p.u_ch < over_depth[-1] < 1.01 * p.u_ch


def test_specific_energy_is_linear_in_the_wear_flat_area() -> None:
    low, middle, high = (cut(0.010, settled(ALUMINA, A=A)).u_s for A in (0.010, 0.045, 0.080))
    assert high - low > 50.0
    assert middle == pytest.approx(0.5 * (low + high), rel=1e-9)


def test_force_ratio() -> None:
    ratios: dict[str, list[float]] = {"alumina": [], "cbn": []}
    for name, p in (("alumina", ALUMINA), ("cbn", CBN)):
        for A, speed, depth in product((0.01, 0.02, 0.04), (6.0, 12.0, 30.0), (0.005, 0.010, 0.030)):
            stroke = cut(depth, settled(p, speed, A=A))
            ratios[name].append(stroke.Ft / stroke.Fn)
    assert all(0.40 <= ratio <= 0.50 for ratio in ratios["alumina"])
    assert all(0.33 <= ratio <= 0.42 for ratio in ratios["cbn"])


# --- 2 ------------------------------------------------------------------------------------------------------


def test_depth_of_cut_converges_within_three_strokes_and_slower_in_a_softer_or_wider_set_up() -> None:
    def third(width: float = 20.0, stiffness: float = 20_000.0) -> float:
        machine = grinder(parameters(ke=stiffness), width=width)
        return machine.strokes(3, 0.010)[-1].ae

    assert 0.0095 < third() < 0.010
    assert third() > third(width=40.0) > third(width=60.0)
    assert third() > third(stiffness=15_000.0) > third(stiffness=10_000.0)


def test_spark_out_is_slower_with_a_duller_wheel() -> None:
    def ratio(A: float) -> float:
        machine = settled(ALUMINA, A=A)
        machine.strokes(10, 0.010)
        first, second = machine.strokes(2)
        return second.ae / first.ae

    assert rising([ratio(A) for A in (0.01, 0.02, 0.04, 0.08)])


# --- 3 ------------------------------------------------------------------------------------------------------


def test_power_and_wear_flats_drop_at_a_dress_and_rise_after_it() -> None:
    machine = settled(ALUMINA, A=0.04, lam=0.2)
    dull = machine.strokes(5, 0.010)[-1].power
    machine.dress()
    machine.new_part()
    flats, powers = [machine.wheel.A], [machine.strokes(5, 0.010)[-1].power]
    for _ in range(4):
        powers.append(machine.strokes(50, 0.010)[-1].power)
        flats.append(machine.wheel.A)
    assert flats[0] < 0.4 * 0.04
    assert powers[0] < 0.6 * dull
    assert rising(flats)
    assert rising(powers)


def test_a_dress_sharpens_less_with_a_worn_diamond_and_with_one_pass() -> None:
    def dressed(wd: float = 0.0, passes: float = 2.0) -> float:
        machine = settled(ALUMINA, A=0.06, lam=0.3, wd=wd)
        machine.dress(passes)
        return machine.wheel.A

    assert rising([dressed(wd) for wd in (0.0, 0.1, 0.3)])
    assert falling([dressed(passes=passes) for passes in (1.0, 2.0, 3.0)])


# --- 4 ------------------------------------------------------------------------------------------------------


def test_roughness_after_a_dress_follows_lead_and_depth() -> None:
    def roughness(lead: float = 0.10, depth: float = 0.020) -> float:
        return cut(0.010, grinder(ALUMINA, lead=lead, depth=depth)).Rg

    assert 0.4 < log_slope(lambda lead: roughness(lead=lead), 0.10) < 0.7
    assert 0.1 < log_slope(lambda depth: roughness(depth=depth), 0.020) < 0.25


@pytest.mark.parametrize("exponent", [0.15, 0.30, 0.60])
def test_roughness_follows_the_chip_thickness(exponent: float) -> None:
    smooth = settled(parameters(x=exponent), alw=0.0)
    assert log_slope(lambda depth: cut(depth, smooth).Rg, 0.010) == pytest.approx(exponent, rel=1e-6)


def test_a_coarse_dress_settles_and_a_fine_one_rises_to_the_same_roughness() -> None:
    def roughness(lead: float, depth: float) -> list[float]:
        strokes = grinder(ALUMINA, lead=lead, depth=depth).strokes(100, 0.010)
        return [stroke.Rg for stroke in strokes[4::19]]

    coarse, fine = roughness(0.20, 0.030), roughness(0.04, 0.010)
    assert falling(coarse)
    assert rising(fine)
    assert coarse[0] > 2.0 * fine[0]
    assert coarse[-1] == pytest.approx(fine[-1], rel=0.02)


# --- 5 ------------------------------------------------------------------------------------------------------


def test_g_ratio_falls_with_the_chip_thickness() -> None:
    for depth in (0.003, 0.010, 0.030):
        assert -1.2 < log_slope(lambda depth: cut(depth, settled(ALUMINA)).G, depth) < -0.6
    assert -1.2 < log_slope(lambda speed: cut(0.010, settled(ALUMINA, speed)).G, 12.0) < -0.6


def test_a_freshly_dressed_wheel_wears_faster() -> None:
    assert rising([cut(0.010, settled(ALUMINA, V=V)).G for V in (0.0, 20.0, 80.0, 320.0)])


def test_cbn_outlasts_alumina() -> None:
    for depth in (0.005, 0.010, 0.030):
        assert cut(depth, settled(CBN)).G > 20.0 * cut(depth, settled(ALUMINA)).G


# --- 6 ------------------------------------------------------------------------------------------------------


def test_temperature_and_burn_ratio_rise_with_the_wear_flats() -> None:
    strokes = [cut(0.010, settled(ALUMINA, A=A)) for A in (0.005, 0.01, 0.02, 0.04, 0.08, 0.12)]
    assert rising([stroke.T for stroke in strokes])
    assert rising([stroke.Br for stroke in strokes])


def test_temperature_jumps_where_the_fluid_boils() -> None:
    powers = np.arange(40.0, 400.0, 0.5)  # W/mm
    rises = np.array([eq.temperature(P, 2.0, 2.4, 3.3e5, 0.85, 0.0, 1.5e5, 110.0) for P in powers])
    slope = np.diff(rises) / np.diff(powers)
    steepest = np.argmax(slope)
    # before and after, temperature is linear in power; the film boils where the wet rise passes 110 K
    wet = slope[0] * (powers - powers[0]) + rises[0]
    assert wet[steepest] == pytest.approx(110.0, abs=5.0)
    assert slope[steepest] > 2.0 * slope[0]
    # nine tenths of the convection are lost: (3.3e5/0.85 + 1.5e5) / (3.3e5/0.85 + 0.15e5)
    assert slope[-1] == pytest.approx(1.3348 * slope[0], rel=1e-4)


def test_deep_cuts_are_hotter_at_the_same_removal_rate() -> None:
    assert rising([cut(0.12 / speed, settled(ALUMINA, speed)).T for speed in (30.0, 12.0, 6.0, 3.0)])


def test_cbn_is_cooler_at_the_same_power() -> None:
    def rise(p: StrokeParameters, power: float) -> float:
        hw = eq.work_conductance(2.4, 200.0, p.beta, eq.jaeger_factor(2.4, 200.0, p.alpha))
        return eq.temperature(power, 2.0, 2.4, hw, eq.work_partition(0.015, 30.0, p.kg, p.beta), 0.0, p.hf, p.Tb)

    for power in (40.0, 80.0, 160.0, 320.0):
        assert rise(CBN, power) < 0.85 * rise(ALUMINA, power)


# --- 7 ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("material", ["aisi_52100", "aisi_1020", "inconel_718"])
def test_energy_partition(material: str) -> None:
    alumina = parameters(material)
    for A, speed, depth in product((0.02, 0.04, 0.08), (6.0, 12.0, 30.0), (0.010, 0.020)):
        assert 0.55 < cut(depth, settled(alumina, speed, A=A)).eps < 0.80
    cbn = parameters(material, "b126", 35.0)
    for A, speed in product((0.005, 0.010, 0.015), (6.0, 12.0, 30.0)):
        assert cut(0.010, settled(cbn, speed, A=A)).eps < 0.50


# --- 8 ------------------------------------------------------------------------------------------------------


def best(costs: dict[int, float]) -> int:
    return min(costs, key=costs.__getitem__)


def inside(costs: dict[int, float]) -> bool:
    """Whether the best choice is neither the least nor the most that was tried."""
    return min(costs) < best(costs) < max(costs)


def test_there_is_a_best_dress_interval_which_shifts_with_table_speed_and_material() -> None:
    def best_interval(p: StrokeParameters, table_speed: float) -> int:
        costs = {n: small_parts(p, table_speed, n, parts=60) for n in (2, 6, 10, 15, 20, 30)}
        assert inside(costs)
        return best(costs)

    soft = parameters(kA=4.0 * ALUMINA.kA)
    assert best_interval(soft, 12.0) < best_interval(ALUMINA, 6.0) < best_interval(ALUMINA, 12.0)


def test_there_is_a_best_number_of_dress_passes_which_shifts_with_the_interval() -> None:
    def costs(interval: int) -> dict[int, float]:
        return {n: small_parts(ALUMINA, 12.0, interval, float(n), parts=120) for n in (1, 2, 3, 4, 6)}

    often, seldom = costs(15), costs(40)
    assert inside(often)
    assert inside(seldom)
    assert best(often) < best(seldom)


def test_there_is_a_best_number_of_dresses_in_a_deep_cycle_which_shifts_with_speed_depth_material() -> None:
    def best_executions(
        p: StrokeParameters, table_speed: float, stock: float, size: float = 12.0, rise: float = 450.0
    ) -> int:
        costs = {n: deep_cycles(p, table_speed, stock, n, size, rise) for n in (0, 1, 2, 3, 4, 6)}
        assert inside(costs)
        return best(costs)

    usual = best_executions(ALUMINA, 18.0, 1.0)
    assert usual < best_executions(ALUMINA, 25.0, 1.0)
    assert usual < best_executions(ALUMINA, 18.0, 2.0)
    assert usual < best_executions(INCONEL, 9.0, 0.5, 15.0, 600.0)


# --- 9 ------------------------------------------------------------------------------------------------------


def test_the_cheapest_table_speed_lies_below_the_fastest() -> None:
    speeds = [float(speed) for speed in range(6, 41)]
    fastest = min(speeds, key=lambda speed: stroke_seconds(grinder(ALUMINA, speed)))
    # minimum of L/v + v/acc, in m/min
    assert fastest == round(0.06 * math.sqrt(260.0 * 1000.0))
    cheapest = min(speeds, key=lambda speed: deep_cycles(ALUMINA, speed, 1.0, 1, 12.0, 450.0))
    assert 6.0 < cheapest < 0.75 * fastest

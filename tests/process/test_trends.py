"""Trends that an implementation of the process model has to show (model.md, sections 12 and 14).

Trends of dress, grit, grade, spark-out roughness and G-ratio are rows of `grind_env.validation`, tested in
tests/validation/test_rows.py. Finite states within bounds are tested in test_bounds.py.
"""

import dataclasses
import math
from collections.abc import Callable
from itertools import pairwise, product

import numpy as np
import pytest

from grind_env.process.catalogue_parameters import stroke_parameters
from grind_env.process.stroke_types import StrokeParameters, StrokeResult
from tests.process.harness import CATALOGUE, INSULATED, Grinder, WarmGrinder, cut, grinder, parameters, warm_grinder
from tests.process.jobs import deep_cycles, small_parts, stroke_seconds

UNLIMITED = 1e12  #: power limit of a spindle that never slows, W
ALUMINA, CBN = parameters(power=UNLIMITED), parameters(wheel="b126", power=UNLIMITED)
RS = parameters().rs


def settled(p: StrokeParameters, table_speed: float = 12.0, **state: float) -> Grinder:
    """Return a grinder with a worn-in topography."""
    return grinder(p, table_speed, **{"V": 400.0, "A": 0.015, **state})


def changed(kind: str, height: float = 20.0, **values: float) -> StrokeParameters:
    """Return parameters of the default set-up with other values in one of its entries."""
    names = {"material": "aisi_52100", "wheel": "a60j", "dresser": "rotary", "fluid": "emulsion", "machine": "default"}
    entries = {each: getattr(CATALOGUE, each)(name) for each, name in names.items()}
    entries[kind] = dataclasses.replace(entries[kind], **values)
    return stroke_parameters(*entries.values(), wheel_speed=30.0, width=20.0, height=height)


def log_slope(value: Callable[[float], float], at: float) -> float:
    step = 1.02
    return math.log(value(at * step) / value(at / step)) / (2.0 * math.log(step))


def rising(values: list[float]) -> bool:
    return all(first < second for first, second in pairwise(values))


def falling(values: list[float]) -> bool:
    return rising(values[::-1])


# --- energy and forces --------------------------------------------------------------------------------------


def test_specific_energy_falls_with_the_removal_rate_towards_the_chip_energy() -> None:
    for p in (ALUMINA, CBN):
        over_depth = [cut(depth, settled(p)).u_s for depth in (0.001, 0.004, 0.010, 0.040, 1.0, 1e3, 1e5)]
        over_speed = [cut(0.010, settled(p, speed)).u_s for speed in (3.0, 6.0, 12.0, 24.0, 40.0)]
        assert falling(over_depth)
        assert falling(over_speed)
        assert p.u_ch < over_depth[-1] < 1.01 * p.u_ch


def test_tangential_over_normal_force_falls_a_little_as_the_wheel_dulls() -> None:
    for p, speed, depth in product((ALUMINA, CBN), (6.0, 12.0, 30.0), (0.005, 0.010, 0.030)):
        strokes = [cut(depth, settled(p, speed, A=A)) for A in (0.01, 0.02, 0.04)]
        ratios = [stroke.Ft / stroke.Fn for stroke in strokes]
        assert falling(ratios)
        assert 0.33 < ratios[-1] < ratios[0] < 0.55


# --- depth of cut and spark-out -----------------------------------------------------------------------------


def test_depth_of_cut_converges_in_three_strokes_and_slower_in_soft_or_wide_set_ups() -> None:
    def third(width: float = 20.0, stiffness: float = 20_000.0) -> float:
        machine = grinder(parameters(ke=stiffness), width=width, V=400.0)
        return machine.strokes(3, 0.010)[-1].ae

    assert 0.0095 < third() < 0.010
    assert third() > third(width=40.0) > third(width=60.0)
    assert third() > third(stiffness=15_000.0) > third(stiffness=10_000.0)


def test_a_freshly_dressed_wheel_cuts_less_by_the_wear_of_the_last_stroke() -> None:
    fresh, settled = grinder(parameters()).strokes(6, 0.010), grinder(parameters(), V=400.0).strokes(6, 0.010)
    assert 0.0095 < fresh[2].ae + fresh[1].dw < 0.010
    assert fresh[5].ae + fresh[4].dw == pytest.approx(0.010, rel=0.01)
    for early, steady in list(zip(fresh, settled, strict=True))[1:]:
        assert early.ae < steady.ae
        assert early.dw > 3.0 * steady.dw


def test_spark_out_is_slower_with_a_duller_wheel() -> None:
    def ratio(A: float) -> float:
        machine = settled(ALUMINA, A=A)
        machine.strokes(10, 0.010)
        first, second = machine.strokes(2)
        return second.ae / first.ae

    assert rising([ratio(A) for A in (0.01, 0.02, 0.04, 0.08)])


@pytest.mark.parametrize("A", [0.008, 0.02, 0.06])
def test_spark_out_ends_at_the_threshold_force_which_grows_with_the_flats(A: float) -> None:
    machine = settled(parameters(kA=0.0), A=A)
    machine.strokes(5, 0.010)
    last = machine.strokes(200)[-1]
    # nothing more is cut, and the deflection at the threshold stays on the part
    threshold = cut(1e-12, machine)
    assert last.ae < 1e-6
    assert last.Fn == pytest.approx(threshold.Fn, rel=1e-3)
    assert last.power == pytest.approx(threshold.power, rel=1e-3)
    left = machine.Z - machine.wheel.W - machine.S
    assert left == pytest.approx(machine.width * threshold.Fn / machine.p.ke, rel=1e-3)
    assert threshold.Fn < cut(1e-12, settled(ALUMINA, A=1.1 * A)).Fn


# --- dressing -----------------------------------------------------------------------------------------------


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


def test_a_coarse_dress_settles_and_a_fine_one_rises_to_the_same_roughness() -> None:
    def roughness(lead: float, depth: float) -> list[float]:
        strokes = grinder(ALUMINA, lead=lead, depth=depth).strokes(100, 0.010)
        return [stroke.Rg for stroke in strokes[4::19]]

    coarse, fine = roughness(0.20, 0.030), roughness(0.04, 0.010)
    assert falling(coarse)
    assert rising(fine)
    assert coarse[0] > 2.0 * fine[0]
    assert coarse[-1] == pytest.approx(fine[-1], rel=0.02)


# --- roughness ----------------------------------------------------------------------------------------------


def test_roughness_rises_with_the_removal_rate_and_falls_with_the_wheel_speed() -> None:
    smooth = settled(ALUMINA)
    assert rising([cut(depth, smooth).Rg for depth in (1e-5, 0.001, 0.004, 0.010, 0.030)])
    assert rising([cut(0.010, settled(ALUMINA, speed)).Rg for speed in (3.0, 6.0, 12.0, 24.0, 40.0)])

    def slope(**changes: float) -> float:
        return log_slope(lambda speed: cut(0.010, settled(parameters(wheel_speed=speed, **changes))).Rg, 30.0)

    assert slope(nr=0.0) == pytest.approx(-0.5, rel=1e-6)
    unbroken = slope(kf=0.0)
    assert unbroken == pytest.approx(-0.5 - ALUMINA.nr * ALUMINA.mG, rel=1e-6)
    assert -0.7 < slope() < unbroken


def test_abrasive_materials_raise_roughness_more_with_alumina_than_with_cbn() -> None:

    def over_steel(material: str, wheel: str, depth: float) -> float:
        hard, steel = (
            cut(depth, settled(parameters(each, wheel, power=UNLIMITED))) for each in (material, "aisi_52100")
        )
        return hard.Rg / steel.Rg

    for material in ("inc751", "inconel_718", "aisi_d2"):
        for depth in (0.010, 0.015, 0.030):
            assert 1.0 < over_steel(material, "b126", depth) < over_steel(material, "a60j", depth)
    # cast iron wears the wheel less
    assert over_steel("grey_cast_iron", "a60j", 0.010) < 0.95


# --- wear ---------------------------------------------------------------------------------------------------


def test_a_freshly_dressed_wheel_wears_faster_especially_cbn() -> None:
    alumina, cbn = ([cut(0.010, settled(p, V=V)).G for V in (0.0, 20.0, 80.0, 320.0)] for p in (ALUMINA, CBN))
    assert rising(alumina)
    assert rising(cbn)
    assert cbn[-1] / cbn[0] > 3.0 * alumina[-1] / alumina[0]


@pytest.mark.parametrize("material", CATALOGUE.materials)
def test_cbn_outlasts_alumina(material: str) -> None:
    cbn, alumina = (parameters(material, wheel, power=UNLIMITED) for wheel in ("b126", "a60j"))
    for depth in (0.005, 0.010, 0.030):
        assert cut(depth, settled(cbn)).G > 5.0 * cut(depth, settled(alumina)).G


def test_a_slow_table_dulls_the_wheel_more_per_volume() -> None:
    def grown(table_speed: float) -> float:
        machine = grinder(ALUMINA, table_speed)
        machine.strokes(50, 0.010)
        return machine.wheel.A

    assert falling([grown(speed) for speed in (4.0, 8.0, 16.0, 30.0)])


def test_a_wheel_that_shrinks_at_constant_rpm_acts_softer() -> None:
    strokes = [cut(0.010, settled(ALUMINA, diameter=diameter)) for diameter in (300.0, 260.0, 220.0)]
    assert falling([stroke.power for stroke in strokes])
    assert falling([stroke.G for stroke in strokes])
    for name in ("heq", "fg", "Rg"):
        assert rising([getattr(stroke, name) for stroke in strokes])


# --- fluids -------------------------------------------------------------------------------------------------


def test_better_lubrication_lowers_friction_energy_wear_and_loading() -> None:
    for wheel in ("a60j", "b126"):
        machines = [grinder(parameters(wheel=wheel, fluid=fluid)) for fluid in ("dry", "synthetic", "emulsion", "oil")]
        strokes = [cut(0.010, machine) for machine in machines]
        assert falling([stroke.Ft / stroke.Fn for stroke in strokes])
        assert falling([stroke.u_s for stroke in strokes])
        assert rising([stroke.G for stroke in strokes])
        for machine in machines:
            machine.strokes(100, 0.010)
        assert falling([machine.wheel.lam for machine in machines])
        assert falling([machine.wheel.A for machine in machines])


# --- heat ---------------------------------------------------------------------------------------------------


def test_temperature_and_burn_ratio_rise_with_the_wear_flats() -> None:
    strokes = [cut(0.010, settled(ALUMINA, A=A)) for A in (0.005, 0.01, 0.02, 0.04, 0.08, 0.12)]
    assert rising([stroke.T for stroke in strokes])
    assert rising([stroke.burn_ratio for stroke in strokes])


def test_oil_boils_at_more_power_than_emulsion_and_nothing_boils_without_fluid() -> None:
    def flats_that_boil(fluid: str) -> float:
        """Return the flats at which the energy partition jumps by a tenth."""
        areas = np.linspace(0.005, 0.12, 47)
        shares = np.array([cut(0.010, settled(parameters(fluid=fluid), A=A)).eps for A in areas])
        jumps = np.diff(shares) > 0.1
        return float(areas[np.argmax(jumps)]) if jumps.any() else math.inf

    assert flats_that_boil("emulsion") < flats_that_boil("oil") < flats_that_boil("dry") == math.inf


def test_deep_cuts_are_hotter_at_the_same_removal_rate() -> None:
    for A in (0.008, 0.015, 0.030):
        assert rising([cut(0.12 / speed, settled(ALUMINA, speed, A=A)).T for speed in (30.0, 12.0, 6.0, 3.0)])


# --- heat of the part ---------------------------------------------------------------------------------------


def ground_warm(p: StrokeParameters, wait: float = 0.0, **state: float) -> WarmGrinder:
    """Rough in ten strokes, wait, and finish in four, with a wheel that does not wear: only heat has an effect."""
    machine = warm_grinder(p._replace(wi=0.0, Gref=1e12, kA=0.0), V=400.0, **state)
    machine.strokes(10, 0.010)
    machine.wait(wait)
    machine.strokes(4, 0.002)
    return machine


def size_error(machine: Grinder) -> float:
    """Return the stock that is left on the cold part, mm."""
    return machine.Z - machine.S


def test_a_hot_part_is_ground_too_thin_and_less_so_after_a_longer_wait() -> None:
    cold = ground_warm(ALUMINA._replace(swell=0.0))
    errors = [size_error(ground_warm(ALUMINA, wait)) for wait in (0.0, 10.0, 30.0, 600.0)]
    assert rising(errors)
    assert errors[0] < size_error(cold) - 0.001
    assert size_error(cold) - errors[0] == pytest.approx(ground_warm(ALUMINA).grown, rel=0.25)


def test_flats_and_poorly_cooling_fluids_heat_the_part() -> None:
    over_flats = [ground_warm(ALUMINA, A=A) for A in (0.008, 0.02, 0.04, 0.08)]
    assert rising([sum(machine.own) for machine in over_flats])
    assert rising([machine.grown for machine in over_flats])
    sharp, oiled, dry = (ground_warm(parameters(fluid=fluid, power=UNLIMITED)) for fluid in ("emulsion", "oil", "dry"))
    assert sum(sharp.own) < sum(oiled.own) < sum(dry.own)


def test_a_higher_part_warms_up_less_grows_as_much_and_cools_slower() -> None:
    setups = [changed("machine", height) for height in (10.0, 40.0)]
    low, high = (ground_warm(p._replace(**INSULATED)) for p in setups)
    assert sum(low.own) == pytest.approx(4.0 * sum(high.own), rel=0.01)
    assert low.grown == pytest.approx(high.grown, rel=0.01)
    low, high = map(ground_warm, setups)
    assert sum(high.own) < sum(low.own)
    assert high.grown > 1.5 * low.grown


# --- spindle ------------------------------------------------------------------------------------------------


def heavy(limit: float, constant_surface_speed: bool = False) -> StrokeResult:
    """Return a cut of 30 um at 250 mm/s over 40 mm of width."""
    p = parameters(power=limit, constant_surface_speed=constant_surface_speed)
    return cut(0.030, settled(p, 15.0, width=40.0))


CHIPS = 13.8 * 0.030 * 250.0 * 40.0  #: power of chip formation in this cut, W; independent of the wheel speed


def test_the_spindle_stalls_where_it_has_slowed_to_its_stall_speed() -> None:
    limit = CHIPS + RS * (heavy(UNLIMITED).power - CHIPS)
    over, at, under = (heavy(share * limit) for share in (1.000001, 1.0, 0.999999))
    assert over.torque < 1.0 < under.torque
    assert at.torque == pytest.approx(1.0, rel=1e-6)
    assert at.vs == pytest.approx(0.6 * 30.0, rel=1e-6)
    assert heavy(0.5 * limit).vs == pytest.approx(0.6 * 30.0, rel=1e-12)  # no slower before it has stalled
    # at the power limit and the set speed, the torque is rs of the stall torque and rises without a jump
    asked = heavy(UNLIMITED).power
    assert heavy(asked).torque == pytest.approx(RS, rel=1e-6)
    assert rising([heavy(share * asked).torque for share in (4.0, 2.0, 1.01, 0.99, 0.9, 0.8, 0.5)])


def test_a_spindle_with_power_to_spare_keeps_its_speed_to_the_bit() -> None:
    asked = heavy(UNLIMITED, True).power
    free, enough = heavy(UNLIMITED, True), heavy(1.000001 * asked, True)
    assert enough.vs == 30.0
    assert enough == free._replace(torque=enough.torque)
    assert enough.torque == pytest.approx(RS / 1.000001, rel=1e-6)


# --- cost ---------------------------------------------------------------------------------------------------


def best(costs: dict[int, float]) -> int:
    return min(costs, key=costs.__getitem__)


def inside(costs: dict[int, float]) -> bool:
    """Return whether the best choice is neither the least nor the greatest tried one."""
    return min(costs) < best(costs) < max(costs)


def test_there_is_a_best_dress_interval_which_shifts_with_table_speed_and_material() -> None:
    """Dresses cost time and wheel; a dull wheel burns, sooner with a slow table or quick dulling.

    At 4 m/min the fluid boils after few parts: a slow table keeps its short contact hot for long.
    """

    def best_interval(p: StrokeParameters, table_speed: float) -> int:
        costs = {n: small_parts(p, table_speed, n, parts=60) for n in (2, 4, 5, 6, 8, 10, 15, 20, 30)}
        assert inside(costs)
        return best(costs)

    usual = parameters()
    quick = usual._replace(kA=4.0 * usual.kA)
    assert max(best_interval(quick, 12.0), best_interval(usual, 4.0)) < best_interval(usual, 12.0)


def test_there_is_a_best_number_of_dress_passes_which_shifts_with_the_interval() -> None:
    """One pass leaves damage, many passes waste wheel. A duller wheel has deeper damage.

    The intervals end where dressing still pays. At 40 parts the last parts reach the scrap temperature, and many passes
    help there only because they make the wheel smaller and so cooler.
    """

    def costs(interval: int) -> dict[int, float]:
        return {n: small_parts(parameters(), 12.0, interval, float(n), parts=120) for n in (1, 2, 3, 5, 10)}

    often, seldom = costs(20), costs(30)
    assert inside(often)
    assert inside(seldom)
    assert best(often) < best(seldom)


def test_the_best_number_of_dresses_in_a_deep_cycle_shifts_with_speed_depth_material() -> None:
    """Uncompensated wear costs size. It grows with depth, with chip thickness and with abrasive materials.

    With a quickly dulling material the wheel burns the part, too. A dress also costs size by early wear, so another
    dress pays only in a deeper cycle.
    """

    def best_executions(material: str, table_speed: float, stock: float, rise: float = 450.0) -> int:
        p = parameters(material)
        costs = {n: deep_cycles(p, table_speed, stock, n, 12.0, rise) for n in (0, 1, 2, 3, 4, 6)}
        assert inside(costs)
        return best(costs)

    shallow, deep, deepest = (best_executions("aisi_52100", 18.0, stock) for stock in (1.0, 2.0, 3.0))
    assert shallow <= deep < deepest
    assert best_executions("aisi_52100", 12.0, 2.0) < best_executions("aisi_52100", 25.0, 2.0)
    assert best_executions("aisi_52100", 12.0, 1.0) < best_executions("aisi_d2", 12.0, 1.0, 480.0)


def test_the_cheapest_table_speed_lies_below_the_fastest() -> None:
    speeds = [float(speed) for speed in range(6, 41)]
    fastest = min(speeds, key=lambda speed: stroke_seconds(grinder(ALUMINA, speed)))
    # minimum of L/v + v/acc, in m/min
    assert fastest == round(0.06 * math.sqrt(260.0 * 1000.0))
    cheapest = min(speeds, key=lambda speed: deep_cycles(parameters(), speed, 1.0, 1, 12.0, 450.0))
    assert 6.0 < cheapest < fastest

"""The relations of the process model against analytic limits, independent solutions and published numbers."""

import math
from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from grind_env.process import equations as eq
from grind_env.process.state import WheelState
from grind_env.process.stroke import dress_wheel
from tests.process.harness import CATALOGUE, cut, grinder, parameters

# --- depth of cut -------------------------------------------------------------------------------------------


@settings(deadline=None)  # the first call compiles
@given(
    u=st.floats(-0.01, 0.3),
    b=st.floats(1.0, 60.0),
    Kn=st.floats(0.0, 100.0),
    a0=st.floats(1e-6, 1e-3),
    vw=st.floats(50.0, 670.0),
    ke=st.floats(1e4, 1e6),
)
def test_depth_of_cut_balances_the_loop(u: float, b: float, Kn: float, a0: float, vw: float, ke: float) -> None:
    def unbalance(ae: float) -> float:
        force = 2.1 * 13.8 * ae * vw / 30.0 + Kn * math.sqrt(300.0 * (ae + a0))
        return u - ae - b * force / ke

    low, high = 0.0, max(u, 0.0)
    for _ in range(100):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if unbalance(middle) > 0.0 else (low, middle)
    sd, sa = math.sqrt(300.0), math.sqrt(a0)
    x = eq.cut_root(u, b / ke, eq.threshold_force(Kn, sd, sa), Kn, sd, sa, eq.chip_force(vw, 1.0 / 30.0, 13.8), 2.1)
    # near the threshold the difference of u and the deflection is what rounding leaves
    assert eq.depth_of_cut(x, sa) == pytest.approx(low, rel=1e-9, abs=1e-13)


def test_a_wheel_only_rubs_below_the_interference_that_the_threshold_takes_up() -> None:
    # a contact of sqrt(300*3e-4) = 0.3 mm at 5 N/mm2: 1.5 N/mm, which over 20 mm deflect 20 N/um by 1.5 um
    sd, sa, give = math.sqrt(300.0), math.sqrt(3e-4), 20.0 / 2e4
    F0 = eq.threshold_force(5.0, sd, sa)
    assert pytest.approx(1.5, rel=1e-12) == F0
    at, half, above, away = (
        (eq.cut_root(u, give, F0, 5.0, sd, sa, 92.0, 2.1), eq.pressed_share(u, give, F0))
        for u in (give * F0, 0.00075, 0.0016, -0.001)
    )
    assert at == (0.0, 1.0)
    assert half == (0.0, pytest.approx(0.5, rel=1e-12))
    assert away == (0.0, 0.0)
    assert 0.0 < eq.depth_of_cut(above[0], sa) < 0.0001
    assert above[1] == 1.0
    # the contact that presses: all of the 0.3 mm, half of it, none
    assert eq.rubbing_length(*at, sd, sa) == pytest.approx(0.3, rel=1e-12)
    assert eq.rubbing_length(*half, sd, sa) == pytest.approx(0.15, rel=1e-12)
    assert eq.rubbing_length(*away, sd, sa) == 0.0


def test_depth_of_cut_of_a_rigid_machine_and_of_a_perfectly_sharp_wheel() -> None:
    sd, sa = math.sqrt(300.0), math.sqrt(3e-4)
    rigid = eq.cut_root(0.010, 1e-15, 1.5, 5.0, sd, sa, 92.0, 2.0)
    assert eq.depth_of_cut(rigid, sa) == pytest.approx(0.010, rel=1e-9)
    # without flats and ploughing the force is proportional: 0.010/(1 + 0.001*2*92)
    sharp = eq.cut_root(0.010, 0.001, 0.0, 0.0, sd, sa, 92.0, 2.0)
    assert eq.depth_of_cut(sharp, sa) == pytest.approx(0.010 / 1.184, rel=1e-12)


# --- spindle ------------------------------------------------------------------------------------------------


@settings(deadline=None)
@given(chip=st.floats(0.0, 20_000.0), rubbing=st.floats(1.0, 20_000.0), rs=st.floats(0.2, 0.98))
def test_a_spindle_slows_until_it_has_the_power_that_is_asked_for(chip: float, rubbing: float, rs: float) -> None:
    def asked(kept: float) -> float:
        return chip + rubbing * kept

    low, high = rs, 1.0
    for _ in range(100):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if asked(middle) < 7500.0 else (low, middle)
    kept, over = eq.slowing(7500.0 - chip, rubbing, rs)
    assert kept == pytest.approx(low, rel=1e-9)
    assert kept * over == pytest.approx(1.0, rel=1e-12)
    if asked(1.0) <= 7500.0:
        assert (kept, over) == (1.0, 1.0)


# --- geometry of the contact --------------------------------------------------------------------------------


def test_wheel_speed() -> None:
    # a dressing example seen on the web: 406 mm at 1410 rpm is 30 m/s
    assert eq.wheel_speed(406.0, 1410.0 / 60.0, 0.0) == pytest.approx(30.0, rel=2e-3)
    assert eq.wheel_speed(406.0, 1410.0 / 60.0, 45.0) == 45.0


def test_contact_length_of_a_rigid_and_of_an_elastic_contact() -> None:
    def flattening(Rr: float, E_star: float) -> float:
        return 8.0 * Rr * Rr / (math.pi * E_star)

    sd = math.sqrt(300.0)
    assert eq.contact_length(0.01, sd, 10.0, flattening(5.0, 1e15)) == pytest.approx(math.sqrt(3.0), rel=1e-9)
    # smooth and without depth: twice the half-width of Hertz's cylinder on a plane, sqrt(4 F R/(pi E*))
    hertz = 2.0 * math.sqrt(4.0 * 10.0 * 150.0 / (math.pi * 4e4))
    assert eq.contact_length(0.0, sd, 10.0, flattening(1.0, 4e4)) == pytest.approx(hertz, rel=1e-12)
    both = eq.contact_length(0.01, sd, 10.0, flattening(5.0, 4e4))
    assert both == pytest.approx(math.hypot(math.sqrt(3.0), 5.0 * hertz), rel=1e-12)


def test_wear_flat_pressure_is_linear_in_the_curvature_difference() -> None:
    # 4*200/(300*30000) = 8.889e-5 per mm; 68 + 7e5*8.889e-5 = 130.2 N/mm2
    slope = 7e5 * eq.curvature_difference(200.0)
    assert eq.wear_flat_pressure(1.0 / (300.0 * 30.0), 68.0, slope) == pytest.approx(130.222, rel=1e-5)
    assert eq.wear_flat_pressure(0.0, 68.0, slope) == 68.0


def test_dense_and_loaded_wheels_plough_more() -> None:
    assert eq.ploughing_pressure(3.0, 0.0, 0.6, 1.0 / 3.0) == pytest.approx(0.6, rel=1e-12)
    assert eq.ploughing_pressure(12.0, 0.0, 0.6, 1.0 / 3.0) == pytest.approx(1.2, rel=1e-12)
    assert eq.ploughing_pressure(3.0, 1.0, 0.6, 1.0 / 3.0) == pytest.approx(0.9, rel=1e-12)
    assert eq.flat_area(0.01, 0.5, 0.02) == pytest.approx(0.02, rel=1e-12)


def test_force_per_grain() -> None:
    # 6 N/mm over 2.4 mm of contact with 3 grains per mm2
    assert eq.force_per_grain(6.0, 3.0, 2.4) == pytest.approx(0.83333, rel=1e-5)


# --- grit and structure -------------------------------------------------------------------------------------


def test_grit_and_structure_at_their_reference_and_at_half_the_size() -> None:
    reference, fine = eq.fineness(0.25), eq.fineness(0.125)
    assert (reference, fine, eq.density(0.52), eq.density(0.26)) == (1.0, 2.0, 1.0, 0.5)
    # half the size: four times as many grains, each held by 2^-1.5 of the force, on a face with 2^0.5 of the flats
    assert eq.active_grains(0.125, 0.52) == pytest.approx(4.0 * eq.active_grains(0.25, 0.52), rel=1e-12)
    assert eq.active_grains(0.25, 0.52) == pytest.approx(2.9952, rel=1e-12)
    assert eq.bond_post_strength(1.2, fine) == pytest.approx(0.424264, rel=1e-6)
    assert eq.fresh_flats(0.008, fine, 0.5) == pytest.approx(0.008, rel=1e-12)
    assert eq.ploughing_share(fine, 2.0) == pytest.approx(2.0, rel=1e-12)
    assert eq.dulling(0.5, fine, 2.0) == pytest.approx(2.0, rel=1e-12)
    assert eq.grain_contact_radius(4.0) == pytest.approx(10e-6, rel=1e-12)
    # 2^-0.7 and 0.5^-0.3
    assert eq.grit_roughness(0.5, fine, 1.0) == pytest.approx(0.307786, rel=1e-6)
    assert eq.grit_roughness(0.5, 1.0, 0.5) == pytest.approx(0.615572, rel=1e-6)


def test_a_harder_grade_holds_its_grains_longer_and_renews_later() -> None:
    assert eq.hardness(1.2, eq.REFERENCE_GRADE) == eq.hardness(4.0, eq.REFERENCE_GRADE_CBN) == 1.0
    assert eq.hardness(2.4, eq.REFERENCE_GRADE) == pytest.approx(2.0, rel=1e-12)
    assert (eq.graded_g_ratio(45.0, 1.0), eq.graded_renewal(0.030, 1.0)) == (45.0, 0.030)
    assert eq.graded_g_ratio(45.0, 4.0) == pytest.approx(90.0, rel=1e-12)
    # 2^1.35
    assert eq.graded_renewal(0.030, 2.0) == pytest.approx(0.030 * 2.549121, rel=1e-6)


# --- energy and heat ----------------------------------------------------------------------------------------


def test_specific_energy_of_a_large_cut_is_the_chip_energy() -> None:
    sharp = cut(1e6, grinder(parameters(power=1e15), A=0.0))
    assert sharp.u_s == pytest.approx(13.8, rel=2e-4)
    # of a 10 um cut, V large: 0.62 sqrt(1.1) of ploughing and 0.4*130.222*0.02 of flats over sqrt(300*0.01025)
    stroke = cut(0.010, grinder(parameters(), A=0.02, V=1e9))
    rubbing = (0.62 * math.sqrt(1.1) + 0.4 * 130.222 * 0.02) * math.sqrt(300.0 * 0.01025)
    assert stroke.u_s == pytest.approx(13.8 + rubbing * 30.0 / 2.0, rel=1e-5)


def test_the_constant_of_the_burn_threshold_is_the_chip_energy_that_enters_the_work() -> None:
    p = parameters()
    # Malkin: 45 % of the chip energy is conducted into the work
    assert p.u0 == pytest.approx(0.45 * p.u_ch, rel=5e-3)


@pytest.mark.parametrize(
    ("de", "ae", "vw", "threshold"),
    [
        # Malkin's threshold on a grid, ae in um and vw in m/min
        (200.0, 5.0, 12.0, 107.81),
        (200.0, 10.0, 6.0, 91.65),
        (200.0, 20.0, 30.0, 28.92),
        (300.0, 5.0, 6.0, 165.23),
        (300.0, 10.0, 20.0, 57.99),
        (300.0, 30.0, 6.0, 47.68),
        # the problem of Wen, Tay and Nee, rough and finish
        (355.0, 50.5, 22.581, 21.2914),
        (355.0, 10.5, 17.549, 61.79703),
    ],
)
def test_burn_threshold(de: float, ae: float, vw: float, threshold: float) -> None:
    p = parameters()
    depth, speed = ae / 1000.0, vw / 0.06
    # for grains that take 12 % of the heat, a sharp alumina wheel; 7.18 is 1.76 (vw in m/min) to three digits
    power = eq.burn_power(depth * speed, math.sqrt(depth * de), speed, 1.0 / 0.88 - 1.0, p.u0, p.Bm)
    assert power / (depth * speed) == pytest.approx(threshold, rel=1e-3)
    assert eq.burn_ratio(0.5 * power, power) == 0.5


def test_work_partition_is_higher_for_alumina_than_for_cbn() -> None:
    def partition(A: float, wheel: str) -> float:
        _, sink = eq.conductances(2.4, 200.0, 11646.0, 1.0, A, 30.0, parameters(wheel=wheel).krw)
        return 1.0 / (1.0 + sink)

    # by hand: 0.97*35/(11646 sqrt(20e-6*30)) = 0.1190; of a B126 grains touch on 20e-6/sqrt(0.25/0.126) = 14.2e-6 m:
    # 0.97*240/(11646 sqrt(14.2e-6*30)) = 0.9685
    assert partition(0.0, "a60j") == pytest.approx(0.8937, rel=1e-3)
    assert partition(0.0, "b126") == pytest.approx(0.5080, rel=1e-3)
    # flats of 8 % have contacts 1 + 20.8*0.08 as wide: 0.1190/sqrt(2.664)
    assert partition(0.08, "a60j") == pytest.approx(0.9320, rel=1e-3)


def test_jaeger_factor_runs_between_its_limits() -> None:
    assert math.sqrt(eq.jaeger_factor(1e-6, 0.025)) == pytest.approx(0.76, abs=5e-4)  # slow and short
    assert math.sqrt(eq.jaeger_factor(10.0, 250.0)) == pytest.approx(1.06, abs=5e-4)  # fast and long
    # Peclet number 2*200/(4*20) = 5
    found = math.sqrt(eq.jaeger_factor(2.0, 200.0 / (4.0 * 20.0)))
    assert found == pytest.approx(0.302 * math.sqrt(2.0 * math.pi + 2.5), rel=1e-4)


def test_chips_carry_their_energy_off_up_to_a_limit() -> None:
    assert eq.retained_heat(85.0, 2.0, 6.0) == pytest.approx(85.0 - 12.0, rel=1e-12)
    assert eq.retained_heat(85.0, 100.0, 6.0) == pytest.approx(0.55 * 85.0, rel=1e-12)


def test_heat_is_shared_between_fluid_grains_and_work() -> None:
    heat, work, film = 73.0, 4e5, 6e5
    wet = eq.temperature(heat, work, film, 0.1, 1e4)
    assert wet * (work + film) == pytest.approx(1e6 * heat, rel=1e-12)
    dry = eq.temperature(heat, work, film, 0.1, -1e4)
    assert dry * (work + 0.1 * film) == pytest.approx(1e6 * heat, rel=1e-12)
    # the film boils off while the wet rise passes 20 K; in the middle the temperature lies in the middle
    assert eq.temperature(heat, work, film, 0.1, wet + 10.001) == wet
    assert eq.temperature(heat, work, film, 0.1, wet - 10.001) == pytest.approx(dry, rel=1e-12)
    assert eq.temperature(heat, work, film, 0.1, wet) == pytest.approx(0.5 * (wet + dry), rel=1e-12)
    # without fluid and grains all of the heat enters the work
    alone = eq.temperature(heat, work, 0.0, 1.0, 1e4)
    assert eq.energy_partition(eq.heat_flow(alone, work), heat) == pytest.approx(1.0, rel=1e-12)
    assert eq.energy_partition(eq.heat_flow(alone, 0.5 * work), heat) == pytest.approx(0.5, rel=1e-12)
    assert eq.energy_partition(0.0, 0.0) == 0.0


def test_work_conductance_is_that_of_a_half_space() -> None:
    # Jaeger's band source at high speed: rise = 1.06 (q/beta) sqrt(lc/vw), here 1.06*1e7/11646*sqrt(2.4/200); 24 W/mm
    work, sink = eq.conductances(2.4, 200.0, 11646.0, 1.06**2, 0.03, 30.0, 0.0)
    assert sink == 0.0  # of grains that conduct nothing
    rise = 1e6 * 24.0 / work
    assert rise == pytest.approx(99.71, rel=1e-3)


def test_film_conductance_is_that_of_a_fluid_that_the_wheel_carries() -> None:
    # Rowe's fluid wheel: h = 1.13 beta_f sqrt(vs/lc), in SI, with 1590 J/(m2 K s^0.5) of water
    def carried(vs: float, lc: float) -> float:
        return 1.13 * 1590.0 * math.sqrt(vs / (lc / 1000.0))

    stated = carried(30.0, 2.4)
    assert stated == pytest.approx(2.0e5, rel=0.01)
    for vs, lc in ((30.0, 2.4), (45.0, 2.4), (30.0, 0.6), (80.0, 5.0)):
        film = eq.film_conductance(lc, vs, 0.0, eq.CARRYING * stated)
        assert film / lc == pytest.approx(carried(vs, lc), rel=1e-12)
    # a face that is full of chips carries half of it
    half, whole = (eq.film_conductance(2.4, 30.0, lam, 1e5) for lam in (1.0, 0.0))
    assert half == pytest.approx(0.5 * whole, rel=1e-12)


# --- heat of the part ---------------------------------------------------------------------------------------


def test_heat_that_enters_the_part_warms_it_as_its_mass_and_specific_heat_say() -> None:
    # 1 kW while the wheel passes over 200 mm at 200 mm/s: 1000 J into 0.6252 kg of 506 J/(kg K)
    mass = 7815e-9 * 200.0 * 20.0 * 20.0
    warmer = eq.part_heating(1000.0, 1.0 / 200.0, 1.0 / (7815e-9 * 506.0 * 20.0 * 20.0))
    assert warmer == pytest.approx(1000.0 / (mass * 506.0), rel=1e-12)
    assert warmer == pytest.approx(3.161, rel=1e-3)
    # the same of a set-up, whose part is 20 mm wide and as high
    assert parameters().per_capacity == pytest.approx(1.0 / (7815e-9 * 506.0 * 20.0 * 20.0), rel=1e-12)


@settings(deadline=None)
@given(dT=st.floats(0.0, 100.0), first=st.floats(0.0, 100.0), then=st.floats(0.0, 100.0), tau=st.floats(1.0, 1e4))
def test_the_part_cools_as_newton_has_it(dT: float, first: float, then: float, tau: float) -> None:
    in_two = eq.cooled(eq.cooled(dT, first, 1.0 / tau), then, 1.0 / tau)
    assert in_two == pytest.approx(eq.cooled(dT, first + then, 1.0 / tau), rel=1e-12)
    assert 0.0 <= in_two <= dT
    # at first by dT/tau in a second
    assert dT - eq.cooled(dT, 1e-6 * tau, 1.0 / tau) == pytest.approx(1e-6 * dT, rel=1e-5, abs=1e-13)


def test_the_part_cools_by_what_the_fluid_takes_off_its_upper_face() -> None:
    p, steel, flood = parameters(), CATALOGUE.material("aisi_52100"), CATALOGUE.fluid("emulsion").part_cooling
    tau = steel.density * steel.specific_heat * 0.020 / flood  # SI, 20 mm high
    assert 1.0 / p.per_tau == pytest.approx(tau, rel=1e-12)
    assert eq.cooled(10.0, tau, p.per_tau) == pytest.approx(10.0 / math.e, rel=1e-12)
    assert eq.cooled(10.0, 1e9, 0.0) == 10.0


def test_a_warm_part_stands_higher() -> None:
    # 20 mm of steel, 10 K warmer: 12e-6*20*10
    assert eq.part_growth(10.0, parameters().swell) == pytest.approx(0.0024, rel=1e-12)


# --- wear ---------------------------------------------------------------------------------------------------


def test_wear_flats_grow_as_in_the_problem_of_wen_tay_and_nee() -> None:
    # their wear-flat area: Ku Vs Lw aw/(Vw sqrt(De ap)), Ku = 3.937e-7 per mm, over aw/ap strokes
    Vs, Vw, Lw, De, ap, aw = 1440.0, 12.0, 300.0, 355.0, 0.0505, 0.101
    area = 3.937e-7 * Vs * Lw * aw / (Vw * math.sqrt(De * ap))
    sliding = eq.grain_sliding(math.sqrt(De * ap), Vs / 60.0, 1.0 / De, eq.turning(Lw, 1000.0 * Vw / 60.0))
    p = parameters()
    growth = eq.wear_flat_growth(sliding, 200.0, 0.0, p.kA, 1.0 / p.Amax)
    assert growth * aw / ap == pytest.approx(area, rel=3e-3)


def test_wear_flats_grow_faster_when_hot_and_not_beyond_their_limit() -> None:
    def growth(T: float, A: float) -> float:
        return eq.wear_flat_growth(100.0, T, A, 1e-6, 1.0 / 0.15)

    assert growth(200.0, 0.0) == pytest.approx(1e-4, rel=1e-12)
    assert growth(0.0, 0.0) == pytest.approx(math.exp(-0.4) * 1e-4, rel=1e-12)
    assert growth(700.0, 0.0) == pytest.approx(math.e * 1e-4, rel=1e-12)
    assert growth(5000.0, 0.0) == pytest.approx(math.e**2 * 1e-4, rel=1e-12)
    assert growth(200.0, 0.075) == pytest.approx(0.5e-4, rel=1e-12)
    assert growth(200.0, 0.15) == 0.0
    # a stroke that would wear more than all of it flat
    assert eq.worn_flat_area(0.14, 0.05, 0.0, 0.006, 0.15) == 0.15


def test_fracture_sets_in_at_its_force_and_then_grows_with_it() -> None:
    # z + sqrt(z^2 + 0.1): without force per grain -1 + sqrt(1.1), at the threshold sqrt(0.1)
    assert eq.fracture(0.0, 1.0 / 1.2, 3.0) == pytest.approx(1.073213, rel=1e-6)
    assert eq.fracture(1.2, 1.0 / 1.2, 3.0) == pytest.approx(1.474342, rel=1e-6)
    # far above the threshold linear in the force: 1 + 3 (fg/fc - 1)
    assert eq.fracture(12.0, 1.0 / 1.2, 3.0) == pytest.approx(28.0, rel=1e-3)


def test_wear_is_a_power_law_of_the_chip_thickness() -> None:
    assert eq.log_chip_wear(0.1, 0.8) == pytest.approx(0.0, abs=1e-12)
    assert eq.log_chip_wear(0.2, 0.8) == pytest.approx(0.8 * math.log(2.0), rel=1e-9)
    assert eq.log_chip_wear(0.2, 0.0) == 0.0
    assert eq.log_chip_wear(0.0, 0.8) == eq.log_chip_wear(0.001, 0.8) == pytest.approx(-0.8 * math.log(100.0), rel=1e-9)
    # 2 mm3/mm at G 40, doubled by fracture and again by the chip: 2*4/(40 pi 300) mm of radius
    wear = eq.steady_wear(2.0, 2.0, math.log(2.0), 1.0 / 40.0, 1.0 / 300.0)
    assert wear == pytest.approx(8.0 / (40.0 * math.pi * 300.0), rel=1e-12)


def test_g_ratio_is_stock_over_the_ring_that_the_wheel_loses() -> None:
    # 2 mm3/mm for 0.1 um of radius on 300 mm
    assert eq.g_ratio(2.0, 1e-4, 300.0) == pytest.approx(2.0 / (math.pi * 300.0 * 1e-4), rel=1e-12)
    assert eq.g_ratio(0.0, 0.0, 300.0) == eq.g_ratio(0.0, 1e-4, 300.0) == 0.0


def test_the_g_ratio_of_an_entry_is_that_of_a_worn_in_wheel_at_the_reference_chip() -> None:
    p = parameters(kf=0.0)
    # 3 mm2/s over 30 m/s
    stroke = cut(0.015, grinder(p, 12.0, V=1e9))
    assert stroke.heq == pytest.approx(0.1, rel=1e-9)
    assert pytest.approx(CATALOGUE.wheel("a60j").g_ratio, rel=1e-9) == stroke.G


def test_a_dress_loosens_grains_as_severe_as_it_was() -> None:
    assert eq.early_loss(3.0, 3.0, 0.0045) == pytest.approx(0.0045, rel=1e-12)
    for severity in (0.1, 1.0, 3.0):
        loss = eq.early_loss(eq.dressed_density(severity, 3.0), 3.0, 0.0045)
        assert loss == pytest.approx(0.0045 * severity, rel=1e-12)


@settings(deadline=None)
@given(volumes=st.lists(st.floats(0.0, 20.0), min_size=1, max_size=30), Vi=st.floats(1.0, 100.0))
def test_strokes_lose_the_same_in_all_however_a_volume_is_divided_among_them(volumes: list[float], Vi: float) -> None:
    worn = V = 0.0
    for volume in volumes:
        wear = eq.early_wear(0.0045, V, volume, 1.0 / Vi)
        assert wear >= 0.0
        worn, V = worn + wear, V + volume
    assert worn == pytest.approx(eq.early_wear(0.0045, 0.0, V, 1.0 / Vi), rel=1e-9, abs=1e-15)
    assert worn <= 0.0045 * (1.0 + 1e-12)


def test_early_wear_dies_away_with_the_volume() -> None:
    def rate(V: float) -> float:
        return eq.early_wear(0.0045, V, 1e-6, 1.0 / 15.0) / 1e-6

    # of what is left, 1/(1 + V/Vi)^2 of the loss: at first by 2/Vi, after Vi by an eighth of that
    assert rate(0.0) == pytest.approx(2.0 * 0.0045 / 15.0, rel=1e-6)
    assert rate(15.0) == pytest.approx(0.25 * 0.0045 / 15.0, rel=1e-6)
    assert eq.early_wear(0.0045, 0.0, 15.0, 1.0 / 15.0) == pytest.approx(0.75 * 0.0045, rel=1e-12)
    assert eq.early_wear(0.0045, 0.0, 1e9, 1.0 / 15.0) == pytest.approx(0.0045, rel=1e-12)
    assert eq.early_wear(0.0045, 0.0, 0.0, 1.0 / 15.0) == 0.0


@pytest.mark.parametrize(("layers", "renewed"), [(0.25, 0.25), (1.0, 1.0), (4.0, 1.0)])
@pytest.mark.parametrize("early", [0.0, 0.0045])
def test_steady_wear_renews_wear_flats_and_loading(layers: float, renewed: float, early: float) -> None:
    p = parameters()
    steady = cut(0.010, grinder(p, A=0.05, lam=0.5, V=1e9)).dw
    # the face of a fresh wheel loses loose grains besides, on whose account none is renewed
    machine = grinder(p._replace(dr=steady / layers, kA=0.0, kL=0.0, wi=early), A=0.05, lam=0.5, V=1e9)
    machine.wheel = machine.wheel._replace(V=0.0, Cd=1.1 * p.Cref)  # of as many grains as one that has ground for long
    machine.Z = 0.0100 + 20.0 * cut(0.010, machine).Fn / p.ke
    wear = machine.stroke().dw
    # after 2 mm3/mm, of a loss that a density of 1.1 stands for
    loose = early / 1.1**4 * (1.0 - (1.0 + 2.0 / p.Vi) ** -2)
    assert wear == pytest.approx(steady + loose, rel=1e-9)
    assert (0.05 - machine.wheel.A) / (0.05 - p.Af) == pytest.approx(renewed, rel=1e-9)
    assert machine.wheel.lam == pytest.approx(0.5 * (1.0 - renewed), rel=1e-9, abs=1e-12)


def test_loading_fills_what_is_still_clean() -> None:
    machine = grinder(parameters("aisi_1045", dr=1e9), lam=0.5)
    removed = machine.stroke(0.030).ae * 200.0
    # 8e-4 of the clean half, per mm3/mm
    assert machine.wheel.lam == pytest.approx(0.5 + 8e-4 * 0.5 * removed, rel=1e-9)


# --- roughness ----------------------------------------------------------------------------------------------


def test_topography_relaxes_from_dressed_to_ground() -> None:
    assert [eq.freshness(V, 1.0 / 40.0) for V in (0.0, 40.0)] == [1.0, pytest.approx(1.0 / math.e, rel=1e-12)]
    assert eq.wheel_roughness(0.8, 1.0, 0.5) == pytest.approx(0.8, rel=1e-12)
    assert eq.wheel_roughness(0.8, 0.5, 0.5) == pytest.approx(0.45 + 0.35 / 2.0, rel=1e-12)
    assert eq.wheel_roughness(0.8, 0.0, 0.5) == pytest.approx(0.45, rel=1e-12)
    assert eq.grain_density(2.0, 1.0, 3.0) == pytest.approx(2.0, rel=1e-12)
    assert eq.grain_density(2.0, 0.0, 3.0) == pytest.approx(3.3, rel=1e-12)


def test_generated_roughness() -> None:
    def roughness(
        Q: float, vs: float = 30.0, lam: float = 0.0, roughened: float = 1.0, scale: float = 1.0, floor: float = 0.4
    ) -> float:
        return eq.generated_roughness(0.5, Q, 1.0 / vs, lam, floor, 0.6, roughened, scale)

    assert roughness(3.0) == pytest.approx(0.5, rel=1e-12)
    assert roughness(0.0) == pytest.approx(0.2, rel=1e-12)
    assert roughness(12.0) == pytest.approx(0.5 * (0.4 + 2.0 * 0.6), rel=1e-12)
    assert roughness(3.0, vs=120.0) == pytest.approx(0.25, rel=1e-12)
    assert roughness(3.0, lam=1.0, scale=1.1) == pytest.approx(0.88, rel=1e-12)
    assert roughness(3.0, roughened=1.7) == pytest.approx(0.85, rel=1e-12)


def test_a_face_that_breaks_away_is_a_rough_one() -> None:
    def factor(breaking: float = 1.0, chips: float = 1.0, g: float = 1.0, nr: float = 0.3) -> float:
        thickness = math.log(chips) if chips > 0.0 else -math.inf
        return eq.roughening(breaking, thickness, math.log(0.5), math.log(g), nr)

    # hardened steel at the reference chip, of a wheel that does not break, is what entries state
    assert factor() == 1.0
    # (1/.22)^.3, and the same of CBN with a tenth; twice the wear by thicker chips, 2^.3
    assert factor(g=0.22) == pytest.approx(1.574973, rel=1e-6)
    assert factor(g=0.22, nr=0.1) == pytest.approx(1.163477, rel=1e-6)
    assert factor(chips=2.0) == pytest.approx(1.231144, rel=1e-6)
    # thinner than the chip at which grains only plough, the face is no smoother
    assert factor(chips=0.5) == factor(chips=0.0) < factor(chips=0.6)
    assert factor(breaking=5.0, chips=3.0, g=0.1, nr=0.0) == 1.0


@pytest.mark.parametrize("nr", [0.1, 0.2, 0.3])
def test_fracture_roughens_nearly_as_the_same_power_of_the_wear(nr: float) -> None:
    """Within 1 % up to twice the wear and within 5.1 % up to four times; less than that power, and ever more so."""
    breakings = [1.0 + 0.05 * step for step in range(200)]
    factors = [eq.roughening(breaking, 0.0, -1.0, 0.0, nr) for breaking in breakings]
    assert all(low < high for low, high in pairwise(factors))
    for breaking, factor in zip(breakings, factors, strict=True):
        off = 1.0 - factor / breaking**nr
        assert -1e-12 < off < (0.01 if breaking <= 2.0 else 0.051 if breaking <= 4.0 else 0.2)


def test_the_roughness_of_an_entry_is_that_of_hardened_steel_at_the_reference_chip() -> None:
    wheel = CATALOGUE.wheel("a60j")
    # 0.9 of the scale, when the dress is forgotten; 3 mm2/s over 30 m/s
    stroke = cut(0.015, grinder(parameters(kf=0.0), V=1e9))
    expected = 0.9 * wheel.roughness * (wheel.roughness_floor + wheel.roughness_rate)
    assert stroke.Rg == pytest.approx(expected, rel=1e-9)


def test_a_pass_replaces_the_texture_as_far_as_it_reaches() -> None:
    # above the face, and on it, it takes nothing
    assert eq.surface_roughness(1.6, 0.4, 0.0, -0.010) == eq.surface_roughness(1.6, 0.4, 0.0, 0.0) == 1.6
    # without depth it takes 0.5 um of peaks off, where it interferes by as much: 0.5/(0.5 + 2*1.6) of the difference
    for u in (0.0005, 0.001, 0.010):
        assert eq.surface_roughness(1.6, 0.4, 0.0, u) == pytest.approx(1.6 - 1.2 * 0.5 / 3.7, rel=1e-12)
    assert eq.surface_roughness(1.6, 0.4, 0.0, 0.0002) == pytest.approx(1.6 - 1.2 * 0.2 / 3.4, rel=1e-12)
    # 2.7 um and those: half
    assert eq.surface_roughness(1.6, 0.4, 0.0027, 0.010) == pytest.approx(1.0, rel=1e-12)
    assert eq.surface_roughness(1.6, 0.4, 1e6, 1e6) == pytest.approx(0.4, rel=1e-6)
    # a wheel may also leave it rougher
    assert eq.surface_roughness(0.2, 0.4, 0.0, 0.0004) == pytest.approx(0.3, rel=1e-12)


def test_a_touch_of_a_nanometre_leaves_the_roughness() -> None:
    machine = grinder(parameters())
    before = machine.Rs
    assert machine.stroke(1e-6).Ra == pytest.approx(before, rel=1e-3)
    assert machine.Rs < before
    # and one at which the wheel hangs above the face to the bit
    assert grinder(parameters()).stroke(-1e-6).Ra == before


# --- dressing -----------------------------------------------------------------------------------------------


def test_dress_width_of_a_published_example() -> None:
    # 0.015 inch tip radius, 0.001 inch deep: half-width 0.137 mm, one overlay at 0.273 mm/rev
    width = eq.dress_width(0.0254, 0.381, 0.0)
    assert width / 2.0 == pytest.approx(0.137, abs=0.0005)
    assert width == pytest.approx(0.273, abs=0.001)
    assert eq.overlap_ratio(width, 0.273) == pytest.approx(1.0, abs=0.004)
    # 2 overlays at 1410 rpm: 192.5 mm/min
    assert eq.overlap_ratio(width, 192.5 / 1410.0) == pytest.approx(2.0, abs=0.01)
    assert eq.dress_width(0.0254, 0.381, 0.1) == pytest.approx(width + 0.1, rel=1e-12)
    # as deep as the tip radius: the whole diameter of the tip
    assert eq.dress_width(0.5, 0.5, 0.0) == pytest.approx(1.0, rel=1e-12)


def test_restored_fraction() -> None:
    # 2 passes of 20 um over a damaged layer of 10 um, which loading and 5 % of flats make three times as deep
    assert eq.restored_fraction(2.0, 0.020, 0.0, 0.0, 0.010) == pytest.approx(1.0 - math.exp(-4.0), rel=1e-9)
    assert eq.restored_fraction(2.0, 0.020, 1.0, 0.05, 0.010) == pytest.approx(1.0 - math.exp(-4.0 / 3.0), rel=1e-9)
    assert eq.restored_fraction(0.0, 0.020, 0.0, 0.02, 0.010) == 0.0


def test_severity_is_malkin_and_murrays_over_that_of_a_medium_dress() -> None:
    def malkin_and_murray(ad: float, fd: float) -> float:
        return 2.0 * ad * math.sqrt(fd / 0.25)

    for ad, fd in ((0.020, 0.10), (0.005, 0.04), (0.030, 0.20)):
        over = malkin_and_murray(ad, fd) / malkin_and_murray(0.020, 0.10)
        assert eq.severity(ad, fd, 1.0, 1.0) == pytest.approx(over, rel=1e-12)
    # a diamond as blunt as it is wide halves it, a dress of no depth keeps the least
    assert eq.severity(0.020, 0.10, eq.blunting(0.3, 0.3), 1.0) == pytest.approx(0.5, rel=1e-12)
    assert eq.severity(0.0, 0.10, 1.0, 1.0) == 0.01


def test_a_rotary_dresser_crushes_at_a_higher_speed_ratio() -> None:
    assert eq.speed_ratio_effect(0.6, 0.38) == 1.0
    assert eq.speed_ratio_effect(0.9, 0.5) == pytest.approx(math.sqrt(1.5), rel=1e-12)
    assert eq.speed_ratio_effect(-0.8, 0.5) == eq.speed_ratio_effect(0.1, 0.5) == pytest.approx(math.sqrt(1.0 / 6.0))
    assert eq.speed_ratio_effect(0.0, 0.0) == 1.0  # a tool that stands


def test_dressed_wheel_over_severity_lead_and_depth() -> None:
    # a quarter of the flats is there however severe the dress; a sixteenth of the severity: 0.25 + 0.75*4
    assert eq.dressed_flat_area(1.0, 0.008, 0.15) == pytest.approx(0.008, rel=1e-12)
    assert eq.dressed_flat_area(1e12, 0.008, 0.15) == pytest.approx(0.002, rel=1e-5)
    assert eq.dressed_flat_area(1.0 / 16.0, 0.008, 0.15) == pytest.approx(0.026, rel=1e-12)
    assert eq.dressed_flat_area(1.0 / 16.0, 0.008, 0.02) == 0.02
    assert eq.dressed_density(1.0, 3.0) == pytest.approx(3.0, rel=1e-12)
    assert eq.dressed_density(16.0, 3.0) == pytest.approx(1.5, rel=1e-12)

    def roughness(fd: float, ad: float, blunt: float = 1.0, qr: float = 1.0) -> float:
        return eq.dressed_roughness(fd, ad, blunt, 0.5, 0.5, 0.25, 0.3, qr)

    assert roughness(0.1, 0.020) == pytest.approx(0.5, rel=1e-12)
    # each exponent by itself: 4^0.5, 16^0.25, 2^-0.3
    assert roughness(0.4, 0.020) == pytest.approx(1.0, rel=1e-12)
    assert roughness(0.1, 0.320) == pytest.approx(1.0, rel=1e-12)
    assert roughness(0.1, 0.020, blunt=2.0) == pytest.approx(0.406126, rel=1e-6)
    assert roughness(0.1, 0.020, qr=1.3) == pytest.approx(0.65, rel=1e-12)


def test_a_dress_mixes_old_and_new_by_the_restored_fraction() -> None:
    p = parameters()
    old = grinder(p, A=0.05, lam=1.0, V=300.0, Rd=0.9, Cd=2.0, W=0.02).wheel
    # half of the surface: np ad/(3 dd) = ln 2
    passes = 3.0 * p.dd * math.log(2.0) / 0.020
    new, removed = dress_wheel(old, passes, 0.1, 0.020, p)
    expected = WheelState(
        ds=300.0 - 2.0 * passes * 0.020,
        A=0.5 * (0.05 + 0.008),
        lam=0.5,
        V=150.0,
        Rd=0.5 * (0.9 + 0.5),
        Cd=0.5 * (2.0 + 2.9952),
        W=0.0,
        wd=1.5e-7 * removed,
    )
    assert new == pytest.approx(expected, rel=1e-12)
    assert removed == pytest.approx(passes * 0.020 * math.pi * 300.0 * 25.0, rel=1e-12)

"""The relations of the process model against analytic limits, independent solutions and published numbers."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import cumulative_trapezoid
from scipy.special import k0e

from grind_env.process import equations as eq
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
    # near the threshold, u minus the deflection is mostly rounding
    assert eq.depth_of_cut(x, sa) == pytest.approx(low, rel=1e-9, abs=1e-13)


def test_a_wheel_only_rubs_below_the_threshold_interference() -> None:
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
    # pressing contact: all of the 0.3 mm, half of it, none
    assert eq.rubbing_length(*at, sd, sa) == pytest.approx(0.3, rel=1e-12)
    assert eq.rubbing_length(*half, sd, sa) == pytest.approx(0.15, rel=1e-12)
    assert eq.rubbing_length(*away, sd, sa) == 0.0


def test_depth_of_cut_matches_a_rigid_machine_and_a_perfectly_sharp_wheel() -> None:
    sd, sa = math.sqrt(300.0), math.sqrt(3e-4)
    rigid = eq.cut_root(0.010, 1e-15, 1.5, 5.0, sd, sa, 92.0, 2.0)
    assert eq.depth_of_cut(rigid, sa) == pytest.approx(0.010, rel=1e-9)
    # without flats and ploughing the force is proportional: 0.010/(1 + 0.001*2*92)
    sharp = eq.cut_root(0.010, 0.001, 0.0, 0.0, sd, sa, 92.0, 2.0)
    assert eq.depth_of_cut(sharp, sa) == pytest.approx(0.010 / 1.184, rel=1e-12)


# --- spindle ------------------------------------------------------------------------------------------------


@settings(deadline=None)
@given(chip=st.floats(0.0, 20_000.0), rubbing=st.floats(1.0, 20_000.0), rs=st.floats(0.2, 0.98))
def test_an_overloaded_spindle_slows_until_its_power_suffices(chip: float, rubbing: float, rs: float) -> None:
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


def test_contact_length_matches_a_rigid_and_a_hertzian_contact() -> None:
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


# --- energy and heat ----------------------------------------------------------------------------------------


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
def test_burn_threshold_matches_published_values(de: float, ae: float, vw: float, threshold: float) -> None:
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


@pytest.mark.parametrize("L", [0.1, 0.3, 1.0, 3.2, 10.0, 31.0])
def test_jaeger_factor_matches_the_peak_temperature_of_a_moving_band(L: float) -> None:
    """The rise at a point is the integral of exp(-u) K0|u| over the band, from u = -r behind it to 2 L - r."""
    r = np.geomspace(1e-9, 2.0 * L, 20_000)
    behind, ahead = (cumulative_trapezoid(k0e(r) * np.exp(-s * r), r, initial=0.0) for s in (0.0, 2.0))
    greatest = np.max(behind + np.interp(2.0 * L - r, r, ahead))
    C = greatest / (math.pi * math.sqrt(L))
    assert eq.jaeger_factor(L, 1.0) == pytest.approx(1.16 / (4.0 / math.pi) * C**2, rel=0.02)


def test_jaeger_factor_matches_rowe_and_stays_positive_without_contact() -> None:
    assert eq.jaeger_factor(14.0, 1.0) == pytest.approx(1.06**2, rel=0.01)
    assert 0.0 < eq.jaeger_factor(0.0, 2.5) < 1e-9


def test_work_conductance_equals_a_half_space() -> None:
    # Jaeger's band source at high speed: rise = 1.06 (q/beta) sqrt(lc/vw), here 1.06*1e7/11646*sqrt(2.4/200); 24 W/mm
    work, sink = eq.conductances(2.4, 200.0, 11646.0, 1.06**2, 0.03, 30.0, 0.0)
    assert sink == 0.0  # grains without conduction
    rise = 1e6 * 24.0 / work
    assert rise == pytest.approx(99.71, rel=1e-3)


def test_film_conductance_equals_rowes_fluid_wheel() -> None:
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


def test_heat_warms_the_part_by_its_mass_and_specific_heat() -> None:
    # 1 kW while the wheel passes over 200 mm at 200 mm/s: 1000 J into 0.6252 kg of 506 J/(kg K)
    mass = 7815e-9 * 200.0 * 20.0 * 20.0
    warmer = eq.part_heating(1000.0, 1.0 / 200.0, 1.0 / (7815e-9 * 506.0 * 20.0 * 20.0))
    assert warmer == pytest.approx(1000.0 / (mass * 506.0), rel=1e-12)
    assert warmer == pytest.approx(3.161, rel=1e-3)
    # parameters of a set-up whose part is 20 mm wide and high
    assert parameters().per_capacity == pytest.approx(1.0 / (7815e-9 * 506.0 * 20.0 * 20.0), rel=1e-12)


@settings(deadline=None)
@given(dT=st.floats(0.0, 100.0), first=st.floats(0.0, 100.0), then=st.floats(0.0, 100.0), tau=st.floats(1.0, 1e4))
def test_a_mode_of_the_part_decays_exponentially(dT: float, first: float, then: float, tau: float) -> None:
    in_two = eq.cooled(eq.cooled(dT, first, 1.0 / tau), then, 1.0 / tau)
    assert in_two == pytest.approx(eq.cooled(dT, first + then, 1.0 / tau), rel=1e-12)
    assert 0.0 <= in_two <= dT
    # at first by dT/tau in a second
    assert dT - eq.cooled(dT, 1e-6 * tau, 1.0 / tau) == pytest.approx(1e-6 * dT, rel=1e-5, abs=1e-13)


# --- wear ---------------------------------------------------------------------------------------------------


def test_wear_flats_grow_as_in_the_problem_of_wen_tay_and_nee() -> None:
    # their wear-flat area: Ku Vs Lw aw/(Vw sqrt(De ap)), Ku = 3.937e-7 per mm, over aw/ap strokes
    Vs, Vw, Lw, De, ap, aw = 1440.0, 12.0, 300.0, 355.0, 0.0505, 0.101
    area = 3.937e-7 * Vs * Lw * aw / (Vw * math.sqrt(De * ap))
    sliding = eq.grain_sliding(math.sqrt(De * ap), Vs / 60.0, 1.0 / De, eq.turning(Lw, 1000.0 * Vw / 60.0))
    p = parameters()
    growth = eq.wear_flat_growth(sliding, 200.0, 0.0, p.kA, 1.0 / p.Amax)
    assert growth * aw / ap == pytest.approx(area, rel=3e-3)


def test_a_worn_in_wheel_has_its_catalogue_g_ratio_at_the_reference_chip() -> None:
    p = parameters(kf=0.0)
    # 3 mm2/s over 30 m/s
    stroke = cut(0.015, grinder(p, 12.0, V=1e9))
    assert stroke.heq == pytest.approx(0.1, rel=1e-9)
    assert pytest.approx(CATALOGUE.wheel("a60j").g_ratio, rel=1e-9) == stroke.G


@settings(deadline=None)
@given(volumes=st.lists(st.floats(0.0, 20.0), min_size=1, max_size=30), Vi=st.floats(1.0, 100.0))
def test_early_wear_does_not_depend_on_how_strokes_divide_a_volume(volumes: list[float], Vi: float) -> None:
    worn = V = 0.0
    for volume in volumes:
        wear = eq.early_wear(0.0045, V, volume, 1.0 / Vi)
        assert wear >= 0.0
        worn, V = worn + wear, V + volume
    assert worn == pytest.approx(eq.early_wear(0.0045, 0.0, V, 1.0 / Vi), rel=1e-9, abs=1e-15)
    assert worn <= 0.0045 * (1.0 + 1e-12)


# --- roughness ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("nr", [0.1, 0.2, 0.3])
def test_fracture_roughens_nearly_by_a_power_of_the_wear(nr: float) -> None:
    """The factor is below the power: by at most 1 % up to twice the wear, and 5.1 % up to four times."""
    breakings = [1.0 + 0.05 * step for step in range(200)]
    factors = [eq.roughening(breaking, 0.0, -1.0, 0.0, nr) for breaking in breakings]
    assert all(low < high for low, high in pairwise(factors))
    for breaking, factor in zip(breakings, factors, strict=True):
        off = 1.0 - factor / breaking**nr
        assert -1e-12 < off < (0.01 if breaking <= 2.0 else 0.051 if breaking <= 4.0 else 0.2)


def test_hardened_steel_has_the_catalogue_roughness_at_the_reference_chip() -> None:
    wheel = CATALOGUE.wheel("a60j")
    # a worn-in topography has 0.9 of the scale; 3 mm2/s over 30 m/s
    stroke = cut(0.015, grinder(parameters(kf=0.0), V=1e9))
    expected = 0.9 * wheel.roughness * (wheel.roughness_floor + wheel.roughness_rate)
    assert stroke.Rg == pytest.approx(expected, rel=1e-9)


def test_a_touch_of_a_nanometre_leaves_the_roughness() -> None:
    machine = grinder(parameters())
    before = machine.Rs
    assert machine.stroke(1e-6).Ra == pytest.approx(before, rel=1e-3)
    assert machine.Rs < before
    # above the face, the roughness stays the same to the bit
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


def test_severity_equals_malkin_and_murray_relative_to_a_medium_dress() -> None:
    def malkin_and_murray(ad: float, fd: float) -> float:
        return 2.0 * ad * math.sqrt(fd / 0.25)

    for ad, fd in ((0.020, 0.10), (0.005, 0.04), (0.030, 0.20)):
        over = malkin_and_murray(ad, fd) / malkin_and_murray(0.020, 0.10)
        assert eq.severity(ad, fd, 1.0, 1.0) == pytest.approx(over, rel=1e-12)
    # a diamond as blunt as it is wide halves it, a dress of no depth keeps the least
    assert eq.severity(0.020, 0.10, eq.blunting(0.3, 0.3), 1.0) == pytest.approx(0.5, rel=1e-12)
    assert eq.severity(0.0, 0.10, 1.0, 1.0) == 0.01

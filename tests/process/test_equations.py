"""The relations of the process model against analytic limits, independent solutions and published numbers."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from grind_env.process import equations as eq
from grind_env.process.state import WheelState
from grind_env.process.stroke import dress_wheel
from tests.process.harness import cut, grinder, parameters

# --- depth of cut -------------------------------------------------------------------------------------------


@settings(deadline=None)  # the first call compiles
@given(
    u=st.floats(-0.01, 0.2),
    b=st.floats(1.0, 60.0),
    p=st.floats(40.0, 600.0),
    Ae=st.floats(0.0, 0.17),
    Fpl=st.floats(0.1, 5.0),
    vw=st.floats(50.0, 670.0),
    ke=st.floats(1e4, 1e6),
)
def test_depth_of_cut_balances_the_loop(
    u: float, b: float, p: float, Ae: float, Fpl: float, vw: float, ke: float
) -> None:
    def unbalance(ae: float) -> float:
        force = 2.0 * (13.8 * ae * vw / 30.0 + Fpl) + p * Ae * math.sqrt(ae * 300.0)
        return u - ae - b * force / ke

    low, high = 0.0, max(u, 0.0)
    for _ in range(100):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if unbalance(middle) > 0.0 else (low, middle)
    found = eq.depth_of_cut(u, b, p, Ae, Fpl, 300.0, vw, 30.0, 13.8, 2.0, ke)
    assert found == pytest.approx(high, rel=1e-9, abs=1e-15)


def test_a_wheel_only_rubs_below_the_interference_that_ploughing_takes_up() -> None:
    # b kc Fpl/ke = 20*2*1/20000 = 2 um
    depths = [
        eq.depth_of_cut(u, 20.0, 120.0, 0.01, 1.0, 300.0, 200.0, 30.0, 13.8, 2.0, 2e4) for u in (0.0019, 0.0020, 0.0021)
    ]
    assert depths[:2] == [0.0, 0.0]
    assert 0.0 < depths[2] < 0.0001
    # half of that interference: half of the force, 1 N/mm normal and 0.5 N/mm tangential
    rubbing, at_threshold, cutting = (
        eq.normal_force(chip, 1.0, 0.0, u, 20.0, 2.0, 2e4) for chip, u in ((0.0, 0.001), (0.0, 0.002), (1e-9, 0.0021))
    )
    assert (rubbing, at_threshold) == (1.0, 2.0)
    assert cutting == pytest.approx(2.0, rel=1e-8)
    assert eq.tangential_force(0.0, 1.0, 0.0, rubbing, 0.4, 2.0) == 0.5


def test_depth_of_cut_of_a_rigid_machine_and_of_a_perfectly_sharp_wheel() -> None:
    rigid = eq.depth_of_cut(0.010, 20.0, 120.0, 0.01, 1.0, 300.0, 200.0, 30.0, 13.8, 2.0, 1e15)
    assert rigid == pytest.approx(0.010, rel=1e-9)
    # without wear flats the force is affine: (0.010 - 0.002)/(1 + 20*2*13.8*(200/30)/20000)
    sharp = eq.depth_of_cut(0.010, 20.0, 120.0, 0.0, 1.0, 300.0, 200.0, 30.0, 13.8, 2.0, 2e4)
    assert sharp == pytest.approx(0.008 / 1.184, rel=1e-12)


def test_stiffness_is_the_slope_of_the_force() -> None:
    def force(ae: float) -> float:
        normal = eq.normal_force(
            eq.chip_force(ae, 200.0, 30.0, 13.8),
            1.0,
            eq.sliding_force(ae, 300.0, 120.0, 0.02),
            1.0,
            20.0,
            2.0,
            2e4,
        )
        return 20.0 * normal

    slope = (force(0.0101) - force(0.0099)) / 0.0002
    stiffness = eq.grinding_stiffness(0.010, 300.0, 20.0, 120.0, 0.02, 200.0, 30.0, 13.8, 2.0)
    assert stiffness == pytest.approx(slope, rel=1e-4)


# --- geometry of the contact --------------------------------------------------------------------------------


def test_wheel_speed() -> None:
    # a dressing example seen on the web: 406 mm at 1410 rpm is 30 m/s
    assert eq.wheel_speed(406.0, 1410.0 / 60.0, 0.0) == pytest.approx(30.0, rel=2e-3)
    assert eq.wheel_speed(406.0, 1410.0 / 60.0, 45.0) == 45.0


def test_contact_length_of_a_rigid_and_of_an_elastic_contact() -> None:
    assert eq.contact_length(0.01, 300.0, 10.0, 5.0, 1e15) == pytest.approx(math.sqrt(3.0), rel=1e-9)
    # smooth and without depth: twice the half-width of Hertz's cylinder on a plane, sqrt(4 F R/(pi E*))
    hertz = 2.0 * math.sqrt(4.0 * 10.0 * 150.0 / (math.pi * 4e4))
    assert eq.contact_length(0.0, 300.0, 10.0, 1.0, 4e4) == pytest.approx(hertz, rel=1e-12)
    both = eq.contact_length(0.01, 300.0, 10.0, 5.0, 4e4)
    assert both == pytest.approx(math.hypot(math.sqrt(3.0), 5.0 * hertz), rel=1e-12)


def test_wear_flat_pressure_is_linear_in_the_curvature_difference() -> None:
    # 4*200/(300*30000) = 8.889e-5 per mm; 60 + 7e5*8.889e-5 = 122.2 N/mm2
    delta = eq.curvature_difference(200.0, 30.0, 300.0)
    assert delta == pytest.approx(8.8889e-5, rel=1e-4)
    assert eq.wear_flat_pressure(delta, 1.0, 60.0, 7e5) == pytest.approx(122.222, rel=1e-5)
    assert eq.wear_flat_pressure(delta, 1.2, 60.0, 7e5) == pytest.approx(1.2 * 122.222, rel=1e-5)


def test_dense_and_loaded_wheels_plough_more() -> None:
    assert eq.ploughing_force(3.0, 0.0, 1.6, 3.0) == pytest.approx(1.6, rel=1e-12)
    assert eq.ploughing_force(12.0, 0.0, 1.6, 3.0) == pytest.approx(3.2, rel=1e-12)
    assert eq.ploughing_force(3.0, 1.0, 1.6, 3.0) == pytest.approx(2.4, rel=1e-12)
    assert eq.flat_area(0.01, 0.5, 0.02) == pytest.approx(0.02, rel=1e-12)


def test_force_per_grain() -> None:
    # 6 N/mm over 2.4 mm of contact with 3 grains per mm2
    assert eq.force_per_grain(6.0, 3.0, 2.4) == pytest.approx(0.83333, rel=1e-5)


# --- energy and heat ----------------------------------------------------------------------------------------


def test_specific_energy_of_a_large_cut_is_the_chip_energy() -> None:
    sharp = cut(1000.0, grinder(parameters(), A=0.0))
    assert sharp.u_s == pytest.approx(13.8, rel=1e-4)
    # chip, ploughing and sliding energy of a 10 um cut, V large: C = 1.1 Cref, so that Fpl = sqrt(1.1) N/mm
    stroke = cut(0.010, grinder(parameters(), A=0.02, V=1e9))
    ploughing = math.sqrt(1.1) * 30.0 / 2.0
    sliding = 0.4 * 122.222 * 0.02 * math.sqrt(3.0) * 30.0 / 2.0
    assert stroke.u_s == pytest.approx(13.8 + ploughing + sliding, rel=1e-5)


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
    # for the partition of a sharp alumina wheel on steel; 7.18 is 1.76 (vw in m/min) to three digits
    found = eq.burn_threshold(ae / 1000.0, de, vw / 0.06, 0.88, p.u0, p.Bm)
    assert found == pytest.approx(threshold, rel=1e-3)


def test_work_partition_is_higher_for_alumina_than_for_cbn() -> None:
    alumina, cbn = parameters(), parameters(wheel="b126")
    # by hand: 0.97*35/(11646 sqrt(15e-6*30)) = 0.1374 and 0.97*240/(same) = 0.9423
    assert eq.work_partition(0.0, 30.0, alumina.kg, alumina.beta) == pytest.approx(0.8792, rel=1e-3)
    assert eq.work_partition(0.0, 30.0, cbn.kg, cbn.beta) == pytest.approx(0.5148, rel=1e-3)
    # flats of 8 % have grain contacts of 40 um: 0.1374*sqrt(15/40); and they grow no further
    assert eq.work_partition(0.08, 30.0, alumina.kg, alumina.beta) == pytest.approx(0.9224, rel=1e-3)
    assert eq.work_partition(0.15, 30.0, alumina.kg, alumina.beta) == pytest.approx(0.9224, rel=1e-3)


def test_jaeger_factor_runs_between_its_limits() -> None:
    assert eq.jaeger_factor(1e-6, 1.0, 10.0) == 0.76  # slow and short
    assert eq.jaeger_factor(10.0, 1000.0, 1.0) == 1.06  # fast and long
    # Peclet number 2*200/(4*20) = 5
    assert eq.jaeger_factor(2.0, 200.0, 20.0) == pytest.approx(0.302 * math.sqrt(2.0 * math.pi + 2.5), rel=1e-9)


def test_heat_is_shared_between_chips_fluid_grains_and_work() -> None:
    power, Q, lc, hw, Rws, hf = 85.0, 2.0, 2.4, 3.3e5, 0.85, 1.5e5
    flux, chips = 1e6 * power / lc, 1e6 * 6.0 * Q / lc
    wet = eq.temperature(power, Q, lc, hw, Rws, 0.0, hf, 1e4)
    assert chips + wet * (hw / Rws + hf) == pytest.approx(flux, rel=1e-9)
    boiled = eq.temperature(power, Q, lc, hw, Rws, 0.0, hf, -1e4)
    assert chips + boiled * (hw / Rws + 0.1 * hf) == pytest.approx(flux, rel=1e-9)
    # a loaded wheel keeps half of the fluid out
    loaded = eq.temperature(power, Q, lc, hw, Rws, 1.0, hf, 1e4)
    assert chips + loaded * (hw / Rws + 0.5 * hf) == pytest.approx(flux, rel=1e-9)
    # without fluid and with chips that carry their limit, 45 %
    dry = eq.temperature(power, 100.0, lc, hw, Rws, 0.0, 0.0, 110.0)
    assert dry * hw / flux == pytest.approx(0.55 * Rws, rel=1e-9)
    # in the middle of the step the temperature lies between
    assert wet < eq.temperature(power, Q, lc, hw, Rws, 0.0, hf, wet) == pytest.approx(0.5 * (wet + boiled))


def test_work_conductance_is_that_of_a_half_space() -> None:
    # Jaeger's band source at high speed: rise = 1.06 (q/beta) sqrt(lc/vw), here 1.06*1e7/11646*sqrt(2.4/200)
    rise = 1e7 / eq.work_conductance(2.4, 200.0, 11646.0, 1.06)
    assert rise == pytest.approx(99.71, rel=1e-3)


# --- wear ---------------------------------------------------------------------------------------------------


def test_wear_flats_grow_as_in_the_problem_of_wen_tay_and_nee() -> None:
    # their wear-flat area: Ku Vs Lw aw/(Vw sqrt(De ap)), Ku = 3.937e-7 per mm, over aw/ap strokes
    Vs, Vw, Lw, De, ap, aw = 1440.0, 12.0, 300.0, 355.0, 0.0505, 0.101
    area = 3.937e-7 * Vs * Lw * aw / (Vw * math.sqrt(De * ap))
    sliding = eq.grain_sliding(ap, De, Vs / 60.0, 1000.0 * Vw / 60.0, Lw, De)
    p = parameters()
    growth = eq.wear_flat_growth(sliding, 200.0, 0.0, p.kA, p.ka, p.Amax)
    assert growth * aw / ap == pytest.approx(area, rel=3e-3)


def test_wear_flats_grow_faster_when_hot_and_not_beyond_their_limit() -> None:
    def growth(T: float, A: float) -> float:
        return eq.wear_flat_growth(100.0, T, A, 1e-6, 1.0, 0.15)

    assert growth(200.0, 0.0) == pytest.approx(1e-4, rel=1e-12)
    assert growth(0.0, 0.0) == pytest.approx(math.exp(-0.4) * 1e-4, rel=1e-12)
    assert growth(700.0, 0.0) == pytest.approx(math.e * 1e-4, rel=1e-12)
    assert growth(5000.0, 0.0) == pytest.approx(math.e**2 * 1e-4, rel=1e-12)
    assert growth(200.0, 0.075) == pytest.approx(0.5e-4, rel=1e-12)
    assert growth(200.0, 0.15) == 0.0


def test_g_ratio_at_its_reference_and_its_limits() -> None:
    def ratio(heq: float, fg: float = 0.0, V: float = 1e6) -> float:
        return eq.g_ratio(heq, fg, V, 40.0, 1.0, 0.8, 0.1, 1.2, 3.0, 1.5, 40.0)

    # at no force per grain 1 + 3 ln(1 + e^-4)/4, at the threshold 1 + 3 ln(2)/4
    assert ratio(0.1) == pytest.approx(40.0 / 1.013612, rel=1e-6)
    assert ratio(0.1, fg=1.2) == pytest.approx(40.0 / 1.519860, rel=1e-6)
    assert ratio(0.2) / ratio(0.1) == pytest.approx(2.0**-0.8, rel=1e-9)
    assert ratio(0.1) / ratio(0.1, V=0.0) == pytest.approx(2.5, rel=1e-9)
    # far above the threshold the fracture factor is linear in the force: 1 + 3 (fg/fc - 1)
    assert ratio(0.1, fg=12.0) == pytest.approx(40.0 / 28.0, rel=1e-9)


def test_waviness_grows_between_its_bounds() -> None:
    def grown(amplitude: float, stiffness: float) -> float:
        return eq.waviness(amplitude, 600.0, stiffness, 2e4, 600.0, 0.15, 0.45, 0.03)

    assert grown(0.1, 0.45 * 2e4) == pytest.approx(0.1 * math.e, rel=1e-9)
    assert grown(0.1, 0.15 * 2e4) == pytest.approx(0.1, rel=1e-12)
    assert grown(0.1, 0.0) == pytest.approx(0.1 * math.exp(-0.2), rel=1e-9)
    assert grown(0.1, 2e5) == pytest.approx(0.1 * math.exp(3.0), rel=1e-9)
    assert grown(0.03, 0.0) == 0.03
    assert grown(1.0, 2e5) == 3.0


@pytest.mark.parametrize(("layers", "renewed"), [(0.25, 0.25), (1.0, 1.0), (4.0, 1.0)])
def test_wear_renews_wear_flats_and_loading(layers: float, renewed: float) -> None:
    p = parameters()
    machine = grinder(p, A=0.05, lam=0.5)
    wear = cut(0.010, machine).dw
    machine.p = p._replace(dr=wear / layers, kA=0.0, kL=0.0)
    machine.Z = 0.0100 + 20.0 * cut(0.010, machine).Fn / p.ke
    assert machine.stroke().dw == pytest.approx(wear, rel=1e-9)
    assert (0.05 - machine.wheel.A) / (0.05 - p.Af) == pytest.approx(renewed, rel=1e-9)
    assert machine.wheel.lam == pytest.approx(0.5 * (1.0 - renewed), rel=1e-9, abs=1e-12)


def test_loading_fills_what_is_still_clean() -> None:
    machine = grinder(parameters("aisi_1020", dr=1e9), lam=0.5)
    removed = machine.stroke(0.030).ae * 200.0
    # 8e-4 of the clean half, per mm3/mm
    assert machine.wheel.lam == pytest.approx(0.5 + 8e-4 * 0.5 * removed, rel=1e-9)


# --- roughness ----------------------------------------------------------------------------------------------


def test_roughness_relaxes_from_dressed_to_ground() -> None:
    assert eq.wheel_roughness(0.8, 0.0, 0.5, 40.0) == pytest.approx(0.8, rel=1e-12)
    assert eq.wheel_roughness(0.8, 40.0, 0.5, 40.0) == pytest.approx(0.45 + 0.35 / math.e, rel=1e-9)
    assert eq.wheel_roughness(0.8, 1e5, 0.5, 40.0) == pytest.approx(0.45, rel=1e-12)
    assert eq.grain_density(2.0, 0.0, 3.0, 40.0) == pytest.approx(2.0, rel=1e-12)
    assert eq.grain_density(2.0, 1e5, 3.0, 40.0) == pytest.approx(3.3, rel=1e-12)


def test_generated_roughness() -> None:
    assert eq.generated_roughness(0.5, 0.1, 0.0, 0.0, 0.3, 0.25, 1.0) == pytest.approx(0.5, rel=1e-12)
    assert eq.generated_roughness(0.5, 0.1, 1.0, 0.0, 0.3, 0.25, 1.1) == pytest.approx(0.88, rel=1e-12)
    # 3 um of waviness, of which a quarter passes, in quadrature: sqrt(0.4^2 + 0.75^2)
    assert eq.generated_roughness(0.4, 0.1, 0.0, 3.0, 0.3, 0.25, 1.0) == pytest.approx(0.85, rel=1e-12)
    finest = eq.generated_roughness(0.5, 0.01, 0.0, 0.0, 0.3, 0.25, 1.0)
    assert eq.generated_roughness(0.5, 0.0, 0.0, 0.0, 0.3, 0.25, 1.0) == finest == pytest.approx(0.250594, rel=1e-5)


def test_a_pass_cannot_erase_a_texture_deeper_than_itself() -> None:
    assert eq.surface_roughness(1.6, 0.4, 0.0) == 1.6
    assert eq.surface_roughness(1.6, 0.4, 1.0) == pytest.approx(0.4, rel=1e-12)
    # 8 um over a peak-to-valley height of 5*1.6 um
    assert eq.surface_roughness(1.6, 0.4, 0.008) == pytest.approx(0.4 + 1.2 / math.e, rel=1e-9)


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


def test_dressed_wheel_at_the_reference_dress() -> None:
    assert eq.dressed_roughness(0.1, 0.020, 3.0, 0.5) == pytest.approx(0.5, rel=1e-12)
    assert eq.dressed_density(3.0, 3.0) == pytest.approx(3.0, rel=1e-12)
    assert eq.dressed_flat_area(3.0, 0.003, 0.0022) == pytest.approx(0.0096, rel=1e-12)
    # each exponent by itself: 4^0.5, 16^0.25, 2^-0.15, 2^0.35
    assert eq.dressed_roughness(0.4, 0.020, 3.0, 0.5) == pytest.approx(1.0, rel=1e-12)
    assert eq.dressed_roughness(0.1, 0.320, 3.0, 0.5) == pytest.approx(1.0, rel=1e-12)
    assert eq.dressed_roughness(0.1, 0.020, 6.0, 0.5) == pytest.approx(0.4506, rel=1e-4)
    assert eq.dressed_density(6.0, 3.0) == pytest.approx(3.8237, rel=1e-4)


def test_a_dress_mixes_old_and_new_by_the_restored_fraction() -> None:
    p = parameters()
    old = grinder(p, A=0.05, lam=1.0, V=300.0, Rd=0.9, Cd=2.0, alw=1.03, W=0.02).wheel
    # half of the surface: np ad/(3 dd) = ln 2, and Ud = 3 with the wear flat that makes bd = 0.3 mm
    depth = 0.020
    old = old._replace(wd=0.3 - eq.dress_width(depth, p.rd, 0.0))
    passes = 3.0 * p.dd * math.log(2.0) / depth
    new, removed = dress_wheel(old, passes, 0.1, depth, p)
    expected = WheelState(
        ds=300.0 - 2.0 * passes * depth,
        A=0.5 * (0.05 + 0.0096),
        lam=0.5,
        V=150.0,
        Rd=0.5 * (0.9 + 0.5),
        Cd=0.5 * (2.0 + 3.0),
        alw=0.53,
        W=0.0,
        wd=old.wd + 1.5e-7 * removed,
    )
    assert new == pytest.approx(expected, rel=1e-12)
    assert removed == pytest.approx(passes * depth * math.pi * 300.0 * 25.0, rel=1e-12)


# --- form ---------------------------------------------------------------------------------------------------------


def test_a_plate_bows_under_a_temperature_difference() -> None:
    # 2 K over 200 x 30 mm of steel
    assert eq.thermal_bow(12e-6, 2.0, 200.0, 30.0) == pytest.approx(0.004, rel=1e-9)

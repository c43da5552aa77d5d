"""Strokes of machines with textbook laws: conservation, exponents by regression, limits, and sets of machines."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grind_env.plants import FAMILIES, Plant, find_plant, find_plants
from grind_env.plants.family import HELD_OUT, PUBLIC
from grind_env.plants.plant import mixed
from grind_env.plants.textbook import DEPTH, SPEED, TEXTBOOK
from tests.plants.test_plant_names import differing
from tests.plants.test_processes import bare, first
from tests.plants.written import Shop, written

OURS = Plant(name="ours")
EXPONENTS = ("a", "s", "n", "m", "q", "e")
LAWS = {"force": 1.0, "a": 0.2, "s": 1.2, "heat": 0.4, "n": 0.6, "m": 0.25, "q": 0.3, "e": 0.35}
DEPTHS = (0.004, 0.007, 0.012, 0.02)


def textbook(**numbers: float) -> Plant:
    named = {f"textbook_{name}": number for name, number in (LAWS | numbers).items()}
    return mixed("textbook", (TEXTBOOK,), named)


def slope(xs: list[float], ys: list[float]) -> float:
    """Return the exponent of y over x, by least squares."""
    return float(np.polyfit(np.log(xs), np.log(ys), 1)[0])


@pytest.mark.parametrize("factor", [0.6, 1.7])
def test_textbook_factors_scale_force_roughness_and_wear_at_the_nominal_point(factor: float) -> None:
    ours, theirs = first(OURS), first(textbook(force=factor, ra=factor, wear=factor))
    assert theirs.ae == pytest.approx(DEPTH, rel=1e-6)
    assert theirs.Ft / ours.Ft == pytest.approx(factor, rel=1e-4)
    assert theirs.Rg / ours.Rg == pytest.approx(factor, rel=1e-4)
    assert theirs.dw / ours.dw == pytest.approx(factor, rel=1e-4)


@pytest.mark.parametrize("name", ["textbook:1", "laws:2", "held-out-laws:3"])
def test_strokes_conserve_energy_and_volume(name: str) -> None:
    shop = Shop(find_plant(name))
    for downfeed in (0.01, 0.015, 0.01, 0.0, 0.0):
        before, warm = shop.wheel, shop.own
        done = shop.stroke(downfeed)
        assert done.power == pytest.approx(shop.width * done.Ft * done.vs)
        assert done.power == pytest.approx(shop.width * done.u_s * done.Q)
        assert done.heat == pytest.approx(done.eps * done.power)
        assert done.eps == pytest.approx(shop.own.textbook_heat)
        heating = done.heat * shop.length / shop.table_speed * 0.06 * shop.p.per_capacity / shop.length
        assert shop.own.dT_1 == pytest.approx((warm.dT_1 + shop.p.w_1 * heating) * math.exp(-2.0 * shop.p.r_1))
        assert done.ae * shop.length == pytest.approx(shop.wheel.V - before.V)
        assert done.G * done.worn == pytest.approx(done.ae * shop.length * shop.width)
        assert before.ds - shop.wheel.ds == pytest.approx(2.0 * done.dw)


def test_the_machine_deflects_under_the_force_of_the_law() -> None:
    shop, nominal = Shop(textbook(a=0.45)), first(OURS)
    for downfeed in (0.01, 0.01, 0.002, 0.0, 0.0):
        u, A = shop.Z + downfeed - shop.wheel.W - shop.S, shop.wheel.A
        done = shop.stroke(downfeed)
        assert u - done.ae == pytest.approx(shop.width * done.Fn / shop.p.ke, rel=1e-6)
        chips = 0.5 * nominal.Ft * (done.heq / nominal.heq) * (max(done.heq, 0.005) / nominal.heq) ** -0.45
        contact = math.sqrt((done.ae + shop.p.a0) / (DEPTH + shop.p.a0))
        assert done.Ft == pytest.approx(chips + 0.5 * nominal.Ft * (A / 0.008) ** 1.2 * contact, rel=1e-3)


def test_force_roughness_and_wear_are_powers_of_the_chip_thickness() -> None:
    for change in (lambda x: (x, SPEED), lambda x: (0.01, SPEED * x / 0.01)):
        cuts = [first(textbook(slides=0.0, fresh=0.0, loose=1.0), *change(depth)) for depth in DEPTHS]
        thickness = [cut.heq for cut in cuts]
        assert slope(thickness, [cut.u_s for cut in cuts]) == pytest.approx(-0.2, abs=1e-3)
        assert slope(thickness, [cut.G for cut in cuts]) == pytest.approx(-0.3, abs=1e-3)
        assert slope(thickness, [cut.Rg for cut in cuts]) == pytest.approx(0.35, abs=1e-3)


def test_sliding_power_follows_power_laws_of_flats_and_depth() -> None:
    flats = [0.005, 0.01, 0.02, 0.04]
    cuts = [first(textbook(slides=1.0), A=A) for A in flats]
    assert slope(flats, [cut.power for cut in cuts]) == pytest.approx(1.2, abs=1e-3)
    deep = [first(textbook(slides=1.0), depth) for depth in DEPTHS]
    assert slope([depth + 0.00025 for depth in DEPTHS], [cut.power for cut in deep]) == pytest.approx(0.5, abs=1e-3)


def flat_growth(A: float, depth: float = DEPTH, plant: Plant | None = None) -> float:
    """Return the growth of the flats per sliding length of a grain, 1/mm."""
    shop = Shop(plant or textbook(slides=0.0), bare())
    shop.wheel = shop.wheel._replace(A=A)
    done = shop.stroke(depth)
    slid = shop.length / SPEED / (math.pi * 300.0 / (1000.0 * done.vs)) * done.lc
    return (shop.wheel.A - A) / slid


def test_large_flats_and_thick_chips_slow_the_growth_of_flats() -> None:
    flats = [0.006, 0.012, 0.025, 0.05]
    assert slope(flats, [flat_growth(A) for A in flats]) == pytest.approx(-0.6, abs=0.01)
    cuts = [first(textbook(slides=0.0), depth) for depth in DEPTHS]
    assert slope([cut.heq for cut in cuts], [flat_growth(0.05, depth) for depth in DEPTHS]) == pytest.approx(
        -0.25, abs=0.01
    )
    assert flat_growth(0.008, plant=textbook(slides=0.0, n=0.0, m=0.0)) == pytest.approx(bare().kA, rel=1e-6)


def test_flats_after_many_strokes_match_the_closed_form_of_their_law() -> None:
    shop, slid = Shop(textbook(slides=0.0, m=0.0), bare(Amax=1e9)), 0.0
    A = shop.wheel.A
    for _ in range(300):
        done = shop.stroke(DEPTH)
        slid += shop.length / SPEED / (math.pi * shop.wheel.ds / (1000.0 * done.vs)) * done.lc
    law = 0.008 * ((A / 0.008) ** 1.6 + 1.6 * bare().kA * slid / 0.008) ** (1.0 / 1.6)
    assert law > 2.0 * A and law == pytest.approx(shop.wheel.A, rel=1e-3)


def test_roughness_falls_after_a_dress_and_rises_with_the_volume() -> None:
    plant = textbook(fresh=0.3, fades=20.0, roughens=1000.0)
    fresh, settled, worn = (first(plant, V=V).Rg for V in (0.0, 100.0, 1500.0))
    assert settled / fresh == pytest.approx((0.7 + 0.3 * math.exp(-5.0)) * 1.1, rel=1e-6)
    assert worn / fresh == pytest.approx(0.7 * 2.5, rel=1e-6)


def test_a_freshly_dressed_wheel_wears_faster() -> None:
    plant = textbook(loose=4.0, settles=10.0)
    fresh, half, settled = (first(plant, V=V).dw for V in (0.0, 10.0, 1e6))
    assert (fresh / settled, half / settled) == (pytest.approx(4.0, rel=1e-4), pytest.approx(2.5, rel=1e-4))


def test_temperature_is_proportional_to_the_heat_share() -> None:
    half, whole = (first(textbook(heat=share)) for share in (0.3, 0.6))
    assert (whole.T, whole.heat) == (pytest.approx(2.0 * half.T), pytest.approx(2.0 * half.heat))
    assert whole.power == half.power
    early = first(textbook(heat=0.3, burns=0.5))
    assert (early.T, early.heat) == (pytest.approx(2.0 * half.T), pytest.approx(half.heat))
    # a moving band source (Jaeger) without fluid: 1.06 q sqrt(lc/vw)/beta, within the band of its factor
    q = whole.heat / 20.0 / whole.lc
    law = 1.06e6 * q * math.sqrt(whole.lc / SPEED) / bare().beta
    assert law == pytest.approx(whole.T, rel=0.15)


@pytest.mark.bits
def test_compiled_strokes_equal_plain_python_strokes_bit_for_bit() -> None:
    plant = find_plant("laws:7")
    grind, plain = plant.process.stroke, written(plant.process.stroke)
    shop = Shop(plant)
    k = written(plant.process.constants)(shop.p, 200.0, 200.0)
    for Z in (0.004, 0.013, 0.013, -1.0):
        given = shop.wheel, shop.own, shop.S, shop.Rs, Z, shop.width, k, 2.0
        compiled, expected = grind(*given), plain(*given)
        assert [np.array(each).tobytes() for each in compiled] == [np.array(each).tobytes() for each in expected]
        shop.wheel, shop.own, done = expected
        shop.S += done.ae


# --- sets of machines


@given(seed=st.integers(0, 2**32 - 1), name=st.sampled_from(["laws", "held-out-laws"]))
def test_machines_of_the_laws_sets_mix_textbook_laws_with_other_families(seed: int, name: str) -> None:
    plant = find_plant(f"{name}:{seed}")
    families = differing(plant)
    assert plant == find_plant(f"{name}:{seed}")
    assert "textbook" in families and 2 <= len(families) <= 4 and not {"foreign", "bursts"} & families
    assert (plant.process, plant.gauge) == (find_plant("training:0").process, find_plant("training:0").gauge)
    numbers = dict(zip(plant.remembers._fields, plant.own, strict=True))
    drawn = TEXTBOOK.drawn(seed, PUBLIC if name == "laws" else HELD_OUT)
    assert {field: numbers[field] for field in drawn} == drawn


def test_training_machines_come_from_the_public_and_laws_sets() -> None:
    found = []
    for seed in range(60):
        plant = find_plant(f"training:{seed}")
        numbers = dict(zip(plant.remembers._fields, plant.own, strict=True))
        kind = "laws" if numbers["textbook_force"] > 0.0 else "public"
        other = find_plant(f"{kind}:{seed}")
        assert all(numbers[field] == value for field, value in zip(other.remembers._fields, other.own, strict=True))
        found.append(kind)
    assert 20 < found.count("laws") < 40
    assert not find_plants("training").one and find_plant("laws:3").name == "laws:3"


def test_held_out_exponents_lie_outside_the_public_ranges() -> None:
    ranges = {each.field.removeprefix("textbook_"): each for each in TEXTBOOK.ranges}
    for name in EXPONENTS:
        low, high = ranges[name].ends(HELD_OUT)
        assert low > ranges[name].high or high < ranges[name].low
    for field in (f"textbook_{name}" for name in EXPONENTS):
        drawn = [[TEXTBOOK.drawn(seed, stream)[field] for seed in range(100)] for stream in (PUBLIC, HELD_OUT)]
        assert max(drawn[0]) < min(drawn[1]) or max(drawn[1]) < min(drawn[0])
    others = [each for family in FAMILIES if family is not TEXTBOOK for each in family.ranges]
    assert all(each.held_out is None for each in others)

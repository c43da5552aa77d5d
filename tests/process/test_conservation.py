"""Conservation of energy, volumes and positions over ten thousand random strokes and dresses."""

import math
import random
from typing import NamedTuple

import numpy as np
import pytest

from grind_env.process import kinematic_numbers
from grind_env.process.process_interface import whole_ms
from grind_env.process.stroke_types import StrokeParameters, StrokeResult, WheelState
from tests.examples import nightly
from tests.process.harness import CATALOGUE, INSULATED, cut, grinder, parameters, warm_grinder

STROKES = 10_000
POWER = 3000.0  #: power limit, W, low enough to overload the spindle often


class Event(NamedTuple):
    """Stroke, or dress that removed `removed` mm3 in `passes` of `depth` mm."""

    before: WheelState
    after: WheelState
    Z: float
    S_before: float
    S_after: float
    speed: float
    width: float
    length: float
    stroke: StrokeResult | None
    passes: float = 0.0
    depth: float = 0.0
    removed: float = 0.0


def random_history(p: StrokeParameters, seed: int) -> list[Event]:
    """Return strokes of random feeds (zero and upward, too), speeds and sizes, with new parts and dresses between."""
    draw = random.Random(seed)
    machine = grinder(p)
    history = []
    for _ in range(STROKES):
        # a dress moves the wheel forward by W; a new part begins before this cut exceeds the model
        if machine.wheel.W > 0.05 or draw.random() < 0.02:
            machine.new_part()
        before, S = machine.wheel, machine.S
        if draw.random() < 0.02:
            passes, depth = float(draw.randint(1, 6)), draw.uniform(0.002, 0.010)
            removed = machine.dress(passes, draw.uniform(0.02, 0.30), depth)
            place = (machine.Z, S, S, machine.speed, machine.width, machine.length)
            history.append(Event(before, machine.wheel, *place, None, passes, depth, removed))
            before = machine.wheel
        if draw.random() < 0.05:
            machine.table_speed = draw.uniform(3.0, 40.0)
            machine.width, machine.length = draw.uniform(5.0, 25.0), draw.uniform(20.0, 300.0)
        downfeed = draw.choice([0.0, draw.uniform(0.0, 0.005), draw.uniform(0.001, 0.040), -0.005])
        stroke = machine.stroke(downfeed)
        place = (machine.Z, S, machine.S, machine.speed, machine.width, machine.length)
        history.append(Event(before, machine.wheel, *place, stroke))
    return history


@pytest.fixture(
    scope="module", params=["aisi_52100 a60j 1", nightly("inconel_718 a60j 2"), nightly("aisi_1045 b126 3")]
)
def history(request: pytest.FixtureRequest) -> list[Event]:
    material, wheel, seed = request.param.split()
    return random_history(parameters(material, wheel, power=POWER), int(seed))


def strokes(history: list[Event]) -> list[tuple[Event, StrokeResult]]:
    return [(event, event.stroke) for event in history if event.stroke is not None]


def set_speed(event: Event) -> float:
    return math.pi * event.before.ds * parameters().n / 1000.0


def slowed(event: Event, stroke: StrokeResult) -> bool:
    """Return whether the spindle has slowed by more than rounding of the set speed."""
    return stroke.vs < 0.999999 * set_speed(event)


def test_histories_cut_rub_lift_dress_and_overload(history: list[Event]) -> None:
    clearances = [event.Z - event.before.W - event.S_before for event in history]
    assert sum(stroke.ae > 0.001 for _, stroke in strokes(history)) > 1000
    assert sum(stroke.ae == 0.0 and stroke.Fn > 0.0 for _, stroke in strokes(history)) > 50
    assert sum(clearance < 0.0 for clearance in clearances) > 50
    assert sum(event.stroke is None for event in history) > 100
    assert sum(slowed(event, stroke) for event, stroke in strokes(history)) > 50


def test_position_is_wear_stock_and_deflection(history: list[Event]) -> None:
    """The balance is exact at the set speed.

    Where the spindle slows, the depth still holds for the set speed, but thicker chips press harder. The next stroke
    takes up this further deflection.
    """
    ke = parameters().ke
    for event, stroke in strokes(history):
        left = event.Z - event.before.W - event.S_after
        deflection = event.width * stroke.Fn / ke
        if slowed(event, stroke):
            assert deflection > left
        elif stroke.Fn > 0.0:
            # deflection of the machine; Z and S are about 1 mm, with roundings of 1e-16 mm
            assert deflection == pytest.approx(left, rel=1e-9, abs=1e-14)
        else:
            assert left <= 0.0
            assert stroke.ae == stroke.Ft == stroke.power == 0.0


def test_lost_diameter_is_wear_plus_dressing(history: list[Event]) -> None:
    worn = math.fsum(2.0 * stroke.dw for _, stroke in strokes(history))
    dressed = math.fsum(2.0 * event.passes * event.depth for event in history)
    lost = history[0].before.ds - history[-1].after.ds
    # ten thousand roundings of 300 mm, by at most 2.9e-14 mm each
    assert lost == pytest.approx(worn + dressed, abs=3e-10)
    assert worn > 0.005
    assert dressed > 1.0


def test_volume_counts_from_the_dress(history: list[Event]) -> None:
    volumes = [history[0].before.V]
    for event in history:
        if event.stroke is None:
            assert 0.0 <= event.after.V <= event.before.V
            volumes = [event.after.V]
        else:
            volumes.append(event.stroke.ae * event.length)
            assert math.isclose(event.after.V, math.fsum(volumes), rel_tol=1e-12)


def test_wear_counts_from_the_last_measurement_of_the_wheel_face(history: list[Event]) -> None:
    wear = [0.0]
    for event in history:
        if event.stroke is None:
            assert event.after.W == 0.0
        else:
            wear = [event.before.W] if event.before.W == 0.0 else wear
            wear.append(event.stroke.dw)
            assert math.isclose(event.after.W, math.fsum(wear), rel_tol=1e-12)


def test_worn_and_dressed_volumes_equal_the_missing_rings(history: list[Event]) -> None:
    p = parameters()
    for event in history:
        before, after = event.before, event.after
        section = math.pi / 4.0 * (before.ds - after.ds) * (before.ds + after.ds)
        # the model neglects that the circumference shrinks within the ring
        thickness = 0.5 * (before.ds - after.ds)
        section /= 1.0 - thickness / before.ds
        if event.stroke is None:
            assert event.removed == pytest.approx(p.bs * section, rel=1e-9)
        else:
            # abs: a rounding of the diameter, 3e-14 mm, times circumference and width
            assert event.stroke.worn == pytest.approx(event.width * section, rel=1e-9, abs=2e-9)


def test_a_rubbing_wheel_dulls_in_proportion_to_its_pressing_force() -> None:
    def dulling(share: float) -> float:
        machine = grinder(parameters())
        threshold = cut(1e-12, machine).Fn * machine.width / machine.p.ke
        before = machine.wheel.A
        stroke = machine.stroke(share * threshold)
        assert stroke.ae == 0.0
        return machine.wheel.A - before

    # the hotter wheel dulls slightly faster
    assert dulling(0.25) == pytest.approx(0.5 * dulling(0.5), rel=0.02)


@pytest.mark.parametrize("material", ["aisi_52100", "inconel_718"])
def test_an_uncooled_part_stores_all_heat_and_a_new_part_is_cold(material: str) -> None:
    """Heat into an uncooled part equals mass times specific heat times rise, over strokes of any kind."""
    work, draw = CATALOGUE.material(material), random.Random(4)
    machine = warm_grinder(parameters(material, power=POWER, **INSULATED))
    mass = 1e-9 * work.density * machine.length * machine.width * 20.0  # kg
    heat = [0.0]
    for _ in range(500):
        machine.table_speed = draw.uniform(3.0, 40.0)
        stroke = machine.stroke(draw.choice([0.0, 0.002, 0.010, -0.004]), draw.uniform(0.3, 6.0))
        passing = machine.length / machine.speed  # s
        assert stroke.heat == pytest.approx(stroke.eps * stroke.Ft * stroke.vs * machine.width, rel=1e-12)
        heat.append(stroke.heat * passing)
        if draw.random() < 0.1:
            machine.wait(draw.uniform(0.0, 100.0))
    assert sum(machine.own) * mass * work.specific_heat == pytest.approx(math.fsum(heat), rel=1e-9)
    assert sum(machine.own) > 50.0
    machine.load()
    assert sum(machine.own) == machine.grown == 0.0


def test_a_stroke_in_the_air_and_a_wait_cool_the_part_alike() -> None:
    in_air, waits = (warm_grinder(parameters()) for _ in range(2))
    for machine in (in_air, waits):
        machine.strokes(10, 0.010)
    hot = waits.own
    in_air.stroke(-1.0, 5.0)
    waits.wait(2.0)
    waits.wait(3.0)
    assert in_air.own == pytest.approx(waits.own, rel=1e-12)
    assert waits.own.dT_1 == pytest.approx(hot.dT_1 * math.exp(-5.0 * waits.p.r_1), rel=1e-12)
    assert waits.own.dT_4 == pytest.approx(hot.dT_4 * math.exp(-5.0 * waits.p.r_4), rel=1e-12)
    assert in_air.wheel == waits.wheel


@pytest.mark.parametrize("downfeed", [0.001, 0.003, 0.010, 0.030])
def test_early_wear_of_a_dressed_wheel_is_independent_of_the_downfeed(downfeed: float) -> None:
    machine = grinder(parameters(Gref=1e12, wi=0.0045))  # steady wear is negligible
    while machine.wheel.V < 60.0:
        machine.stroke(downfeed)
    left = (1.0 + machine.wheel.V / machine.p.Vi) ** -2
    assert pytest.approx(0.0045 * (1.0 - left), rel=1e-6) == machine.wheel.W


def test_rounding_to_ms_gives_one_duration_at_any_clock_time() -> None:
    # an infeed of 10 um at F30 with 1 m/s2 takes 20.5 ms, which a clock shows as a little less or more
    infeed = 0.01 / 0.5 + 0.5 / 1000.0
    began = [k * 4.0 / 3.0 for k in range(1000)]
    assert {whole_ms((time + infeed) - time) for time in began} == {0.021}


def test_speed_ratio_and_aggressiveness_match_values_by_hand() -> None:
    # 0.01 mm deep at 12 m/min, wheel of 400 mm at 32 m/s; then a fourth as deep
    ae, vw, vs, ds = np.array([0.01, 0.0025]), np.full(2, 200.0), np.full(2, 32.0), np.full(2, 400.0)
    assert kinematic_numbers.speed_ratio(vs, vw) == pytest.approx([160.0, 160.0])
    # 10^6/160 times 1/200, and half of that
    assert kinematic_numbers.aggressiveness(vw, vs, ae, ds) == pytest.approx([31.25, 15.625])

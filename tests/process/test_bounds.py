"""Nothing is NaN, negative or out of its bounds, whatever the state (model.md, section 12, trend 10)."""

import math

from hypothesis import given, settings
from hypothesis import strategies as st

from grind_env.process.state import StrokeParameters, WheelState
from grind_env.process.stroke import dress_wheel, grind_stroke
from tests.process.harness import grinder, parameters

SETUPS = [
    parameters(material, wheel)._replace(ke=ke)
    for material in ("aisi_52100", "aisi_1020", "inconel_718")
    for wheel in ("a60j", "b126")
    for ke in (1e4, 2e4, 5e4)
]


@st.composite
def wheels(draw: st.DrawFn) -> WheelState:
    """Any wheel, up to its limits and down to just above the scrap diameter."""
    return WheelState(
        ds=draw(st.sampled_from([200.0 + 1e-9, 300.0]) | st.floats(201.0, 400.0)),
        A=draw(st.sampled_from([1e-9, 0.15 - 1e-9]) | st.floats(1e-6, 0.149)),
        lam=draw(st.sampled_from([0.0, 1.0]) | st.floats(0.0, 1.0)),
        V=draw(st.just(0.0) | st.floats(0.0, 1e5)),
        Rd=draw(st.floats(0.1, 2.0)),
        Cd=draw(st.floats(1.0, 12.0)),
        alw=draw(st.sampled_from([0.03, 3.0]) | st.floats(0.03, 3.0)),
        W=draw(st.floats(0.0, 0.05)),
        wd=draw(st.floats(0.0, 0.5)),
    )


def assert_within_bounds(wheel: WheelState, p: StrokeParameters) -> None:
    assert all(math.isfinite(value) and value >= 0.0 for value in wheel)
    assert 0.0 < wheel.A < p.Amax
    assert wheel.lam <= 1.0
    assert p.alw0 <= wheel.alw <= 3.0


@settings(deadline=None, max_examples=300)
@given(
    p=st.sampled_from(SETUPS),
    wheel=wheels(),
    clearance=st.floats(-0.02, 0.08),
    tiny=st.sampled_from([1.0, 0.0, 1e-9]),
    speed=st.floats(50.0, 670.0),
    width=st.floats(1.0, 60.0),
    length=st.floats(5.0, 400.0),
    roughness=st.floats(0.05, 3.0),
)
def test_a_stroke_from_any_state_stays_finite_and_within_bounds(
    p: StrokeParameters,
    wheel: WheelState,
    clearance: float,
    tiny: float,
    speed: float,
    width: float,
    length: float,
    roughness: float,
) -> None:
    Z = wheel.W + 1.0 + tiny * clearance
    after, stroke = grind_stroke(wheel, 1.0, roughness, Z, speed, width, length, p)
    assert_within_bounds(after, p)
    assert all(math.isfinite(value) and value >= 0.0 for value in stroke)
    assert stroke.ae <= max(tiny * clearance, 0.0) + 1e-15
    assert stroke.eps <= 1.0


@settings(deadline=None, max_examples=200)
@given(
    p=st.sampled_from(SETUPS),
    wheel=wheels(),
    passes=st.integers(1, 6),
    lead=st.floats(0.02, 0.30),
    depth=st.floats(0.005, 0.040),
)
def test_a_dress_from_any_state_stays_within_bounds(
    p: StrokeParameters, wheel: WheelState, passes: int, lead: float, depth: float
) -> None:
    after, removed = dress_wheel(wheel, float(passes), lead, depth, p)
    assert_within_bounds(after, p)
    assert removed > 0.0
    assert after.lam <= wheel.lam
    assert after.V <= wheel.V
    assert after.alw <= wheel.alw


@settings(deadline=None, max_examples=50)
@given(
    p=st.sampled_from(SETUPS),
    events=st.lists(
        st.floats(0.0, 0.040) | st.tuples(st.integers(1, 6), st.floats(0.02, 0.30), st.floats(0.005, 0.040)),
        min_size=20,
        max_size=100,
    ),
)
def test_wear_flats_stay_within_their_limit_whatever_is_ground_and_dressed(
    p: StrokeParameters, events: list[float | tuple[int, float, float]]
) -> None:
    machine = grinder(p)
    for event in events:
        if isinstance(event, tuple):
            passes, lead, depth = event
            machine.new_part()
            machine.dress(float(passes), lead, depth)
        else:
            machine.stroke(event)
        assert_within_bounds(machine.wheel, p)

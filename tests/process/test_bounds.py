"""Strokes and dresses from any state stay finite, non-negative and in bounds (model.md, section 12, trend 10)."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from grind_env.process.stroke_and_dress import dress_wheel, grind_stroke, stroke_constants
from grind_env.process.stroke_types import StrokeParameters, WheelState
from tests.examples import examples
from tests.process.harness import CATALOGUE, grinder, parameters

SETUPS = [
    parameters(material, wheel, fluid=fluid, dresser=dresser)._replace(ke=ke)
    for material in CATALOGUE.materials
    for wheel in CATALOGUE.wheels
    for fluid in CATALOGUE.fluids
    for dresser, ke in (("single_point", 1e4), ("blade", 2e4), ("rotary", 2e5))
]


@st.composite
def wheels(draw: st.DrawFn) -> WheelState:
    """Draw any wheel, up to its limits and down to the least diameter."""
    return WheelState(
        ds=draw(st.sampled_from([20.0, 200.0, 300.0]) | st.floats(20.0, 400.0)),
        A=draw(st.sampled_from([0.0, 1e-9, 0.15]) | st.floats(1e-6, 0.15)),
        lam=draw(st.sampled_from([0.0, 1.0]) | st.floats(0.0, 1.0)),
        V=draw(st.just(0.0) | st.floats(0.0, 1e5)),
        Rd=draw(st.floats(0.02, 5.0)),
        Cd=draw(st.floats(0.3, 60.0)),
        W=draw(st.floats(0.0, 0.05)),
        wd=draw(st.floats(0.0, 2.0)),
    )


ROUNDING = 1.0 + 1e-15  #: rounding of a shallow dress, which mixes old and dressed values


def assert_within_bounds(wheel: WheelState, p: StrokeParameters) -> None:
    assert all(math.isfinite(value) and value >= 0.0 for value in wheel)
    assert wheel.ds >= 20.0
    assert p.Amax * ROUNDING >= wheel.A
    assert wheel.lam <= 1.0


@examples(1000)
@given(
    p=st.sampled_from(SETUPS),
    wheel=wheels(),
    u=st.sampled_from([0.0, 1e-9, 1e-300]) | st.floats(-0.02, 0.01) | st.floats(0.0, 0.3),
    speed=st.floats(50.0, 670.0),
    width=st.floats(1.0, 300.0),
    length=st.floats(5.0, 400.0),
    roughness=st.sampled_from([0.0]) | st.floats(0.05, 3.0),
)
def test_a_stroke_from_any_state_stays_finite_and_within_bounds(
    p: StrokeParameters, wheel: WheelState, u: float, speed: float, width: float, length: float, roughness: float
) -> None:
    constants = stroke_constants(p, speed, length)
    after, stroke = grind_stroke(wheel._replace(W=0.0), 0.0, roughness, u, width, constants)
    assert_within_bounds(after, p)
    assert all(math.isfinite(value) and value >= 0.0 for value in stroke)
    assert stroke.ae <= max(u, 0.0)
    assert stroke.power <= p.power
    assert stroke.eps <= 1.0 + 1e-12
    assert stroke.vs <= 1e-3 * math.pi * wheel.ds * p.n * (1.0 + 1e-12)
    assert min(roughness, stroke.Rg) - 1e-12 <= stroke.Ra <= max(roughness, stroke.Rg) + 1e-12
    assert min(wheel.A, p.Af) <= after.A


@pytest.mark.parametrize("setup", [("ti_6al_4v", "dry"), ("inconel_718", "dry")], ids="-".join)
def test_a_heavily_clogging_stroke_stays_within_bounds(setup: tuple[str, str]) -> None:
    material, fluid = setup
    p = parameters(material, fluid=fluid, ke=2e5, dr=1e9)
    wheel = grinder(p).wheel
    for u, length in ((0.040, 400.0), (0.3, 400.0)):
        after, _ = grind_stroke(wheel, 0.0, 1.6, u, 1.0, stroke_constants(p, 50.0, length))
        assert_within_bounds(after, p)


@examples(200)
@given(
    p=st.sampled_from(SETUPS),
    wheel=wheels(),
    passes=st.integers(0, 20),
    lead=st.floats(0.001, 2.0),
    depth=st.sampled_from([0.0, 1e-9]) | st.floats(0.0, 0.5),
)
def test_a_dress_from_any_state_stays_within_bounds(
    p: StrokeParameters, wheel: WheelState, passes: int, lead: float, depth: float
) -> None:
    after, removed = dress_wheel(wheel, float(passes), lead, depth, p)
    assert_within_bounds(after, p)
    assert removed == pytest.approx(passes * depth * math.pi * wheel.ds * 25.0, rel=1e-12)
    assert after.lam <= wheel.lam
    assert after.V <= wheel.V


def test_a_dress_without_passes_or_depth_leaves_the_wheel_unchanged() -> None:
    p = parameters()
    wheel = grinder(p, A=0.05, lam=0.3, V=300.0).wheel
    for passes, depth in ((0.0, 0.020), (2.0, 0.0)):
        after, removed = dress_wheel(wheel, passes, 0.1, depth, p)
        assert after == pytest.approx(wheel, rel=1e-12)
        assert removed == 0.0

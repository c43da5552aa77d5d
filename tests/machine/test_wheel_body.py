"""The wheel as a body, compared with circles sampled point by point."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grind_env.control import Motion, Position, Rapid, Source
from grind_env.machine.dress.wheel_geometry import over_diamond
from grind_env.machine.job import PartConditions
from grind_env.machine.part.part import PartRun
from grind_env.machine.warnings.clearance import CRASH, into_part
from tests.machine.harness import job

RADIUS, WIDTH = 150.0, 25.0
PART = (0.0, 200.0)
ACROSS = (0.0, 20.0)


def move(start: Position, end: Position) -> Motion:
    return Rapid(start=start, end=end, begin=0.0, seconds=1.0, block=1, line=1, source=Source.PROGRAM, inch=False)


def underside(x: float, face: float, at: Any) -> Any:
    """Return the height of the rim of a wheel at x, at coordinates along the table; infinite beside the wheel."""
    distance = np.abs(np.asarray(at) - x)
    return np.where(distance < RADIUS, face + RADIUS - np.sqrt(np.maximum(RADIUS**2 - distance**2, 0.0)), np.inf)


def into(x: float, z: float, face: float) -> float:
    """Return the depth of the wheel in an unground part by points along the part, mm."""
    if not ACROSS[0] - WIDTH < z < ACROSS[1]:
        return 0.0
    return max(-float(underside(x, face, np.linspace(*PART, 200_001)).min()), 0.0)


def assert_into_part(way: Motion, expected: float) -> None:
    found = into_part(PartRun(1, job(), PartConditions(), 0.0), way, 0, RADIUS)
    if max(found, expected) > CRASH:
        assert found == pytest.approx(expected, rel=1e-6, abs=1e-4)


@given(x=st.floats(-200.0, 400.0), z=st.floats(-30.0, 25.0), face=st.floats(-60.0, 1.0))
def test_a_plunge_goes_as_deep_into_the_part_as_the_sampled_wheel(x: float, z: float, face: float) -> None:
    assert_into_part(move((x, 20.0, z), (x, face, z)), into(x, z, face))


@given(
    x=st.tuples(st.floats(-200.0, 400.0), st.floats(-200.0, 400.0)).filter(lambda ends: abs(ends[1] - ends[0]) > 1e-3),
    z=st.floats(-24.0, 19.0),
    face=st.floats(-60, 1),
)
def test_a_move_along_the_table_counts_at_its_deepest_point(x: tuple[float, float], z: float, face: float) -> None:
    nearest = min(max(100.0, min(x)), max(x))  # to the middle of the part
    assert_into_part(move((x[0], face, z), (x[1], face, z)), into(nearest, z, face))


@given(
    x=st.floats(-160.0, 160.0), face=st.floats(-3.0, 3.0), z=st.tuples(st.floats(-60.0, 60.0), st.floats(-60.0, 60.0))
)
def test_a_pass_over_the_diamond_matches_the_sampled_wheel(x: float, face: float, z: tuple[float, float]) -> None:
    depth, passed = over_diamond((0.0, 0.0, 0.0), move((x, face, z[0]), (x, face, z[1])), 0, RADIUS, WIDTH)
    low, high = max(min(z), -WIDTH), min(max(z), 0.0)
    if high - low < 1e-6:
        assert passed == 0.0 or abs(high - low) < 1e-6 or z[0] == z[1]
        return
    assert passed == pytest.approx(high - low)
    assert depth == pytest.approx(-float(underside(x, face, 0.0)), abs=1e-9) or depth == -math.inf


def test_an_oblique_pass_over_the_diamond_is_deepest_between_its_ends() -> None:
    depth, passed = over_diamond((0.0, 0.0, 0.0), move((-40.0, -1.0, -20.0), (40.0, -1.0, -5.0)), 0, RADIUS, WIDTH)
    assert (depth, passed) == (pytest.approx(1.0), pytest.approx(15.0))
    beside, _ = over_diamond((0.0, 0.0, 0.0), move((-40.0, -1.0, 1.0), (40.0, -1.0, 1.0)), 0, RADIUS, WIDTH)
    assert beside == -math.inf

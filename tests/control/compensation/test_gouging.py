"""Gouging: elements that are not neighbours and leave no room for the wheel."""

import math

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from grind_env.control import Control, ControlError, Motion, Source, execute, read

Point = tuple[float, float]


def contour(points: list[Point], side: str = "G41", arcs: dict[int, str] | None = None) -> str:
    """Return a program along some points, with an entry and an exit along the first and last element."""
    (x0, y0), (x1, y1), (xe, ye), (xd, yd) = points[0], points[1], points[-1], points[-2]
    lines = [
        f"G00 X{2 * x0 - x1 - 3 * (y1 - y0):.3f} Y{2 * y0 - y1 + 3 * (x1 - x0):.3f}",
        f"{side} G01 X{x0:.3f} Y{y0:.3f}",
    ]
    lines += [f"N{10 * k} {(arcs or {}).get(k, 'G01')} X{x:.3f} Y{y:.3f}" for k, (x, y) in enumerate(points[1:], 1)]
    lines.append(f"G40 G01 X{2 * xe - xd - (yd - ye):.3f} Y{2 * ye - yd + (xd - xe):.3f}")
    return "G71 G90 G94 G17 F500. T1\n" + "\n".join(lines) + "\nM30"


def turned(points: list[Point], degrees: float, mirrored: bool) -> list[Point]:
    """Return the points, first mirrored if asked and then turned about the origin."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return [(c * x - s * y, s * x + c * y) for x, y in ((-x if mirrored else x, y) for x, y in points)]


def neck(width: float, depth: float, left: float, right: float, bottom: float) -> list[Point]:
    """Return a pocket behind a neck: over the left lip, down the neck, round the pocket, up the neck again."""
    return [
        (-40.0, 0.0),
        (0.0, 0.0),
        (0.0, -depth),
        (-left, -depth),
        (-left, -depth - bottom),
        (width + right, -depth - bottom),
        (width + right, -depth),
        (width, -depth),
        (width, 0.0),
        (width + 40.0, 0.0),
    ]


def refused(text: str, radius: float) -> ControlError | None:
    try:
        for _ in execute(read(text), Control(radius=radius)):
            pass
    except ControlError as error:
        return error
    return None


@given(
    st.floats(3.0, 12.0),
    st.floats(2.0, 20.0),
    st.floats(15.0, 40.0),
    st.floats(15.0, 40.0),
    st.floats(0.3, 6.9),
    st.floats(0.0, 360.0),
    st.booleans(),
)
def test_a_wheel_wider_than_a_neck_is_refused(
    width: float, depth: float, left: float, right: float, radius: float, degrees: float, mirrored: bool
) -> None:
    assume(abs(width - 2.0 * radius) > 0.01)
    points = turned(neck(width, depth, left, right, 30.0), degrees, mirrored)
    error = refused(contour(points, "G42" if mirrored else "G41"), radius)
    if width > 2.0 * radius:
        assert error is None
    else:
        assert error is not None and error.name == "interference"
        assert "there is no room for a wheel" in error.message and "in line" in error.message


def test_a_gouging_error_names_both_blocks() -> None:
    error = refused(contour(neck(4.0, 10.0, 20.0, 20.0, 30.0)), 3.0)
    assert error is not None
    assert (error.block, error.line) == (70, 10)
    assert "between block 70 and block 20 in line 5 there is no room for a wheel of radius 3.0000 mm" in error.message


def test_a_wheel_wider_than_the_neck_of_a_round_pocket_is_refused() -> None:
    """A round pocket behind a neck: the arc of 300 degrees about (0, -30)."""
    reach = 20.0 * math.sin(math.radians(30.0))
    top = -30.0 + 20.0 * math.cos(math.radians(30.0))
    points = [(-40.0, 0.0), (-reach, 0.0), (-reach, top), (reach, top), (reach, 0.0), (40.0, 0.0)]
    text = contour(points, arcs={3: "G03 R-20. "})
    assert refused(text, 9.5) is None
    error = refused(text, 10.5)
    assert error is not None and error.name in ("interference", "backwards-motion")


@pytest.mark.parametrize(
    "text",
    [
        contour(neck(4.0, 10.0, 20.0, 20.0, 30.0)).replace("G17", "G17 M800"),
        # three laps around a square, the third further in: each lap lies beside the one before
        "G17 F500. T1\nG00 X-20.\nG42 G01 X0 Y0\n"
        + "X40.\nY40.\nX0\nY0\n" * 2
        + "X2. Y2.\nX38.\nY38.\nX2.\nY2.\nG40 X-20. Y-20.",
        # along both sides of a thin wall
        "G17 F500. T1\nG00 X-20. Y-9.\nG42 G01 X0 Y0\nX40.\nY1.\nX0\nY20.\nG40 X-20. Y30.",
        # the same neck at another height
        "G17 F500. T1\nG00 X-20.\nG41 G01 X0 Y0\nX10.\nX20. Z-5.\nX20. Y-20.\nX5.\nY20.\nG40 X-20. Y30.",
    ],
)
def test_contours_without_gouging_or_without_detection_are_accepted(text: str) -> None:
    assert refused(text, 3.0) is None


def test_the_motions_before_a_gouge_are_made() -> None:
    events = []
    with pytest.raises(ControlError):
        for event in execute(read(contour(neck(4.0, 10.0, 20.0, 20.0, 30.0))), Control(radius=3.0)):
            events.append(event)
    made = [event for event in events if isinstance(event, Motion) and event.source is Source.PROGRAM]
    assert [motion.line for motion in made] == [2, 3, 4, 5, 6, 7, 8, 9]

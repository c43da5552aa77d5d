"""Rules of the radius compensation beyond the worked examples: entry, exit and generated blocks."""

import math

import pytest

from grind_env.control import Arc, Motion, Source
from tests.control.harness import motions, path

RADIUS = 2.0


def moved(text: str, **settings: object) -> list[Motion]:
    return motions(text, **{"radius": RADIUS, **settings})


def test_example_15_3_entry_after_blocks_without_motion() -> None:
    idle = "".join(f"N{number} M08\n" for number in range(3, 999))
    found = path(
        f"N1 G01 X0 Z0 F60.\nN2 G41 T1\n{idle}N999 X1. Z1.\nN1000 Z20.\nG40 X9.", radii={1: RADIUS}, radius=0.0
    )
    assert found[0] == pytest.approx((1.0, 1.0 + RADIUS))


def test_a_move_out_of_the_plane_is_no_entry() -> None:
    text = "G41 G01 F60. Y5.\nZ10.\nZ30.\nG40 X9."
    ends = [move.end for move in moved(text)]
    assert ends[0] == (0.0, 5.0, 0.0)
    assert ends[1] == pytest.approx((RADIUS, 5.0, 10.0))


def test_moves_out_of_the_plane_count_as_blocks_without_motion() -> None:
    text = "G41 G01 F60. Z1.\nZ10.\n{}X10.\nZ20.\nG40 Z30."
    two, three = ("".join(f"Y{step}.\n" for step in range(1, count + 1)) for count in (2, 3))
    assert path(text.format(two))[1] == pytest.approx((10.0 - RADIUS, RADIUS))
    assert path(text.format(three))[1] == pytest.approx((10.0, RADIUS))


@pytest.mark.parametrize("degrees", range(-170, 180, 20))
@pytest.mark.parametrize(("code", "side"), [("G41", 1.0), ("G42", -1.0)])
def test_type_a_exit_is_the_same_for_every_angle(degrees: int, code: str, side: float) -> None:
    z, x = 30.0 + 20.0 * math.cos(math.radians(degrees)), 20.0 * math.sin(math.radians(degrees))
    found = path(f"{code} G01 Z10. F60.\nZ30.\nG40 Z{z:.3f} X{x:.3f}")
    assert found[1:] == [pytest.approx((30.0, side * RADIUS)), pytest.approx((z, x), abs=1e-3)]


@pytest.mark.parametrize(
    "words", ["{t} G41 G01 Z10. X5. F60.", "{t}\nG41 G01 Z10. X5. F60.", "G41\n{t}\nG01 Z10. X5. F60."]
)
def test_t_may_stand_before_in_or_after_the_g41_block(words: str) -> None:
    text = words.format(t="T0101") + "\nZ30.\nG40 X9."
    assert path(text, radius=9.0, radii={1: RADIUS})[0] == pytest.approx((10.0, 5.0 + RADIUS))


@pytest.mark.parametrize(("code", "rotation"), [("G41", -1.0), ("G42", 1.0)])
@pytest.mark.parametrize("degrees", [30, 60, 89, 91, 120, 150, 175])
def test_blocks_are_generated_for_turns_beyond_90_degrees_outside(code: str, rotation: float, degrees: int) -> None:
    for sense, outside in ((rotation, True), (-rotation, False)):
        angle = math.radians(sense * degrees)
        z, x = 60.0 + 50.0 * math.cos(angle), 50.0 * math.sin(angle)
        moves = moved(f"{code} G01 Z10. F60.\nZ60.\nZ{z:.3f} X{x:.3f}\nG40 Z{z + 9:.3f}")
        generated = [move for move in moves if move.source is Source.COMPENSATION]
        assert bool(generated) == (outside and degrees > 90)


@pytest.mark.parametrize("corner", ["G39", "G39.1"])
def test_types_a_and_b_differ_in_entry_and_exit_only(corner: str) -> None:
    text = f"{corner} G42 G01 Z10. F60.\nZ40.\nX20.\nZ30. X-30.\nG02 Z20. X-20. R14.\nG01 Z-30.\nG40 X-60. Z-30."
    a, b = ([(move.source, move.end, move.block) for move in moved(text, compensation_type=kind)] for kind in "AB")
    contour = [part for part in a if part[2] in (2, 3, 4, 5)]
    assert len(contour) > 4
    assert [part for part in b if part[2] in (2, 3, 4, 5)] == contour
    assert a[-2:] != b[-2:]


def test_the_feed_on_a_generated_arc_is_f() -> None:
    moves = moved("G39.1 G42 G01 Z10. F60.\nZ40.\nX20.\nZ30. X-30.\nG40 X-50.")
    (arc,) = (move for move in moves if move.source is Source.COMPENSATION)
    assert isinstance(arc, Arc) and arc.feed == 60.0

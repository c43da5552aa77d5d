"""G76 and G77 within a program: their motions, feeds and modes (lathe manual 23-4, 23-7)."""

import pytest

from tests.control.harness import ends, refusal

START = "G00 X25. Z-10.\n"


def test_the_default_retract_is_a_round_number_in_mm_and_in_inches() -> None:
    # grooving-g77.md, 3(b): 0.5 mm, or 0.02 in = 0.508 mm; the depths are multiples of 1 mm and of 0.1 in
    assert ends(START + "G77 X20. I2. D0 F1.")[2][0] == 23.5
    inch = "G70 G00 X1. Z-1.\nG77 X.8 I.1 D0 F1."
    assert [end[0] for end in ends(inch)] == pytest.approx([25.4, 22.86, 23.368, 20.32, 25.4], abs=1e-9)
    assert ends(inch, groove_retract=0.25)[2][0] == pytest.approx(23.11, abs=1e-9)
    assert ends("G70\nG71\n" + START + "G77 X20. I2. D0 F1.")[2][0] == 23.5
    # a step of 0.02 in is no larger than the retract, one of 0.0201 in is
    error = refusal("G70 G00 X1. Z-1.\nG77 X.8 I.02 D0 F1.")
    assert (error.name, "the retract of 0.508 mm" in error.message) == ("groove-retract", True)
    assert ends("G70 G00 X1. Z-1.\nG77 X.95 I.0201 D0 F1.")[1][0] == pytest.approx(25.4 * 0.9799, abs=1e-9)


def test_g76_takes_only_x_as_a_diameter() -> None:
    # X18 radius and X36 diameter are one place; I4 and D.3 are radius values in both modes
    radius = ends("G07 G00 X10. Z2.\nG76 X18. Z-4. I4. K2.5 D.3 F7.")
    diameter = ends("G08 G00 X20. Z2.\nG76 X36. Z-4. I4. K2.5 D.3 F7.")
    assert diameter == radius
    assert sorted({end[0] for end in radius}) == [10.0, 10.3, 14.0, 14.3, 18.0, 18.3]

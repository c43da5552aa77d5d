"""Colours differ for every colour vision, by the model of Machado, Oliveira & Fernandes (2009), severity 1."""

from itertools import combinations, pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grind_env.render import palette

EYES = {
    "normal": np.eye(3),
    "protanopia": np.array(
        [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]]
    ),
    "deuteranopia": np.array(
        [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]]
    ),
    "tritanopia": np.array(
        [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]]
    ),
}
XYZ = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
WHITE = XYZ.sum(axis=1)


def seen(colour: palette.Colour, eye: str) -> np.ndarray:
    """Return the colour in CIE L*a*b* (D65) as the eye sees it."""
    encoded = np.array(colour) / 255.0
    linear = np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)
    t = XYZ @ np.clip(EYES[eye] @ linear, 0.0, 1.0) / WHITE
    f = np.where(t > (6 / 29) ** 3, np.cbrt(t), t / (3 * (6 / 29) ** 2) + 4 / 29)
    return np.array([116.0 * f[1] - 16.0, 500.0 * (f[0] - f[1]), 200.0 * (f[1] - f[2])])


@pytest.mark.parametrize("eye", EYES)
def test_colours_with_a_meaning_differ(eye: str) -> None:
    groups = [
        (palette.TEAL, palette.BRICK, palette.EDGE),
        (palette.BLUE, palette.BRICK, palette.DRESSED),
        (palette.STEEL, palette.TEMPER[0]),
        (palette.STEEL, palette.TEMPER[1]),
        palette.WEAR,
    ]
    for group in groups:
        for first, second in combinations(group, 2):
            assert np.linalg.norm(seen(first, eye) - seen(second, eye)) > 15.0, (first, second)


TEXT = ["INK", "GREY", "BLUE", "BRICK", "ORANGE_TEXT", "TEAL_TEXT"]
GROUNDS = {"PANEL": TEXT, "PAPER": TEXT, "STRIP": ["INK", "GREY", "BLUE", "ORANGE_TEXT"], "WHEEL": ["GREY"]}


@pytest.mark.parametrize(("ground", "text"), [(ground, text) for ground, texts in GROUNDS.items() for text in texts])
def test_text_has_the_contrast_of_the_accessibility_guideline(ground: str, text: str) -> None:
    """WCAG 2 asks for a contrast of 4.5 to 1 for text of this size."""

    def luminance(rgb: palette.Colour) -> float:
        encoded = np.array(rgb) / 255.0
        linear = np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)
        return float(XYZ[1] @ linear)

    assert (luminance(getattr(palette, ground)) + 0.05) / (luminance(getattr(palette, text)) + 0.05) >= 4.5


@given(st.floats(0.0, 0.15), st.floats(0.0, 0.15))
def test_a_duller_wheel_is_never_shown_sharper(first: float, second: float) -> None:
    duller, sharper = max(first, second), min(first, second)
    assert 0.0 <= palette.dullness(sharper) <= palette.dullness(duller) < 1.0


def test_ramps_pass_through_their_colours() -> None:
    assert [palette.ramp(palette.WEAR, share) for share in (0.0, 0.5, 1.0)] == list(palette.WEAR)
    assert palette.burn_colour(1.0) == palette.TEMPER[0]
    assert palette.burn_colour(5.0) == palette.burn_colour(palette.BLUE_RATIO) == palette.TEMPER[-1]
    assert palette.dullness(palette.HALF_DULL) == pytest.approx(0.5)
    reds = [palette.ramp(palette.WEAR, k / 20)[0] for k in range(21)]
    assert all(a <= b for a, b in pairwise(reds))

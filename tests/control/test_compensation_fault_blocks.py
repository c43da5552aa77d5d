"""Blocks at which compensated contours are refused, compared with LinuxCNC's rs274 2.9.

An impossible offset path is found only when the next block is read, so both controls name the next block.
An arc that is too small and a circular exit are refused in their own block.
"""

import pytest

from tests.control.harness import refusal

LEAD_IN = "N10 G71 G17 G90 G40 G94\nN20 G00 X-40.0 Y0.0\nN30 {} G01 X-20.0 F100.0\n"
BACKWARDS = "backwards-motion"
TOO_SMALL = "circular-departure-too-small"


@pytest.mark.parametrize(
    ("side", "radius", "blocks", "name", "block"),
    [
        ("G41", 2.0, "N40 X0.0\nN50 Y1.0\nN60 X-20.0\nN70 G40 X-30.0", BACKWARDS, 60),
        ("G41", 2.0, "N40 X0.0\nN50 Y3.0\nN60 X-15.0\nN70 G40 X-30.0", BACKWARDS, 60),
        ("G41", 2.0, "N40 X-19.0\nN50 Y10.0\nN60 G40 Y20.0", BACKWARDS, 50),
        ("G41", 2.0, "N40 X0.0\nN50 Y1.0\nN60 G40 Y20.0", BACKWARDS, 60),
        ("G41", 2.0, "N40 X0.0\nN50 X-5.0 Y1.0\nN60 G40 X-10.0 Y2.0", BACKWARDS, 50),
        ("G42", 2.0, "N40 X0.0\nN50 Y-3.0\nN60 X-15.0\nN70 G40 X-30.0", BACKWARDS, 60),
        ("G41", 3.0, "N40 X0.0\nN50 Y10.0\nN60 G03 X-2.0 Y12.0 I-2.0\nN70 G01 X-10.0\nN80 G40 X-20.0", TOO_SMALL, 60),
        ("G41", 2.0, "N40 X0.0\nN50 G03 X2.0 Y2.0 J2.0\nN60 G01 Y20.0\nN70 G40 Y40.0", TOO_SMALL, 50),
        ("G41", 3.0, "N40 G03 X-18.0 Y2.0 J2.0\nN50 G01 Y20.0\nN60 G40 Y40.0", TOO_SMALL, 40),
        (
            "G41",
            12.0,
            "N40 X0.0\nN50 G02 X10.0 Y-10.0 J-10.0\nN60 G03 X20.0 Y-20.0 I10.0\nN70 G40 G01 X30.0",
            TOO_SMALL,
            60,
        ),
        ("G41", 2.0, "N40 X0.0\nN50 G40\nN60 G02 X10.0 Y-10.0 J-10.0", "block-format", 60),
        ("G41", 2.0, "N40 X0.0\nN50 G40 G03 X10.0 R10.0", "block-format", 50),
        ("G41", 2.0, "N40 X0.0\nN50 G18 G01 X10.0 Z10.0\nN60 G40 X20.0", "block-format", 50),
    ],
)
def test_contours_are_refused_as_in_linuxcnc(side: str, radius: float, blocks: str, name: str, block: int) -> None:
    error = refusal(LEAD_IN.format(side) + blocks, radius=radius)
    assert (error.name, error.block) == (name, block)

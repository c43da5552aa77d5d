"""Helpers of the picture tests: hand-made views and pixel counts."""

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grind_env.process.cost import Limits
from grind_env.process.stroke_types import WheelState
from grind_env.render.picture_data import EpisodePicture, Extent, GroundBlock, PictureInstant, Workpiece

LIMITS = Limits(rise=500.0, power=8000.0, roughness=1.0, size=10.0)
WHEEL = WheelState(ds=300.0, A=0.01, lam=0.0, V=0.0, Rd=1.0, Cd=1.0, W=0.0, wd=0.05)
GOOD = GroundBlock(
    speed=9000.0,
    executions=0,
    power=4000.0,
    torque=0.3,
    rise=250.0,
    roughness=0.5,
    size_error=3.0,
    limits=LIMITS,
    cost=2.5,
    finished=True,
    good=1.0,
)
EXTENT = Extent(
    title="A job",
    blocks=20,
    parts=20,
    new_diameter=300.0,
    lowest_speed=3000.0,
    highest_speed=30000.0,
    most_executions=3,
    longest=300.0,
    thickest=0.5,
)
VIEW = EpisodePicture(
    extent=EXTENT,
    ground=(GOOD,),
    wheel=WHEEL,
    part=Workpiece(name="plate", length=300.0, stock=0.3, left=0.003),
    text="G82 X330. I-30. Y-.3 J-.02 L2 F60. E9000. P9100 D0",
)
INSTANT = PictureInstant(table=0.0, spin=0.1, dressing=False, speed=9000.0, executions=0)

MACHINE = (slice(90, 340), slice(16, 474))  #: rows and columns of the machine in the wide picture, without its labels
CHARTS = (slice(50, 482), slice(486, 944))
TRAY = (slice(458, 481), slice(14, 410))


def with_wheel(view: EpisodePicture = VIEW, **changes: float) -> EpisodePicture:
    return replace(view, wheel=view.wheel._replace(**changes))


def with_last(view: EpisodePicture = VIEW, **changes: Any) -> EpisodePicture:
    return replace(view, ground=(*view.ground[:-1], replace(view.ground[-1], **changes)))


def near(picture: NDArray[np.uint8], colour: tuple[int, int, int], tolerance: int = 6) -> NDArray[np.bool_]:
    """Return the mask of the pixels with the given colour, shape (height, width)."""
    difference = np.abs(picture.astype(np.int64) - np.array(colour))
    mask: NDArray[np.bool_] = difference.max(axis=2) <= tolerance
    return mask


def runs(row: NDArray[np.bool_]) -> int:
    """Count the separate stretches of True in a row."""
    return int(np.count_nonzero(row & ~np.concatenate([[False], row[:-1]])))

"""A canvas: shapes are drawn large and reduced for smooth edges, with text on top.

The only module that draws with Pillow; it is imported with the first picture.
"""

import functools
import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from grind_env.render.palette import INK, PAPER, Colour
from grind_env.render.picture_data import RenderError

FINENESS = 3  #: drawn pixels per pixel of the picture, in either direction

Point = tuple[float, float]

EMPHASIS = 0.3  #: outline that makes text semi-bold, px; the font has one weight


class Box(NamedTuple):
    """A rectangle, px from the upper left corner of the picture."""

    left: float
    top: float
    right: float
    bottom: float

    @property
    def width(self) -> float:
        return self.right - self.left

    @property
    def height(self) -> float:
        return self.bottom - self.top

    def inside(self, left: float, top: float, right: float, bottom: float) -> "Box":
        return Box(self.left + left, self.top + top, self.right - right, self.bottom - bottom)


class Canvas:
    """Shapes and text in pixels of the finished picture, y downwards."""

    def __init__(self, width: int, height: int) -> None:
        self.image = Image.new("RGB", (FINENESS * width, FINENESS * height), PAPER)
        self.shapes = ImageDraw.Draw(self.image)
        # arguments of `text`, which is written when the shapes are done
        self.texts: list[tuple[Point, str, int, Colour, str, bool]] = []

    def rectangle(self, box: Box, colour: Colour, *, outline: Colour | None = None, radius: float = 0.0) -> None:
        """Draw a filled rectangle, at least one drawn pixel wide and high; nothing if it has no area."""
        if box.width <= 0.0 or box.height <= 0.0:
            return
        left, top, right, bottom = (FINENESS * value for value in box)
        # Pillow includes the last pixel
        corners = (left, top, max(right - 1.0, left), max(bottom - 1.0, top))
        width = FINENESS if outline else 0
        if radius > 0.0:
            self.shapes.rounded_rectangle(corners, FINENESS * radius, colour, outline, width)
        else:
            self.shapes.rectangle(corners, colour, outline, width)

    def disc(self, centre: Point, radius: float, colour: Colour) -> None:
        self.shapes.circle(_fine(centre), FINENESS * radius, colour)

    def arc(self, centre: Point, radius: float, width: float, span: tuple[float, float], colour: Colour) -> None:
        """Draw a ring sector of `width` inside `radius`; `span` in degrees, clockwise from 3 o'clock."""
        (x, y), r = _fine(centre), FINENESS * radius
        self.shapes.arc((x - r, y - r, x + r, y + r), *span, colour, round(FINENESS * width))

    def polygon(self, points: list[Point], colour: Colour) -> None:
        self.shapes.polygon([_fine(point) for point in points], colour)

    def line(self, points: list[Point], colour: Colour, width: float = 1.0) -> None:
        self.shapes.line([_fine(point) for point in points], colour, round(FINENESS * width), joint="curve")

    def dashes(self, first: Point, last: Point, colour: Colour, dash: float = 4.0) -> None:
        """Draw a dashed line, 1 px wide."""
        length = math.dist(first, last)
        direction = ((last[0] - first[0]) / length, (last[1] - first[1]) / length) if length > 0.0 else (0.0, 0.0)
        for k in range(math.ceil(length / (2.0 * dash))):
            start, end = 2.0 * dash * k, min(2.0 * dash * k + dash, length)
            ends = [(first[0] + s * direction[0], first[1] + s * direction[1]) for s in (start, end)]
            self.line(ends, colour)

    def text(
        self, at: Point, text: str, size: int = 12, colour: Colour = INK, anchor: str = "ls", strong: bool = False
    ) -> None:
        """Write text on a base line; `at` is its left end if `anchor` is `ls`, its right end if `rs`."""
        self.texts.append((at, text, size, colour, anchor, strong))

    def pixels(self) -> NDArray[np.uint8]:
        """Return the finished picture, shape (height, width, 3)."""
        picture = self.image.reduce(FINENESS)
        for (x, y), text, size, colour, anchor, strong in self.texts:
            mask, (left, top) = _mask(text, size, anchor, strong)
            picture.paste(colour, (round(x) + left, round(y) + top), mask)
        return np.array(picture)


def text_width(text: str, size: int, strong: bool = False) -> float:
    """Return the width of a line of text, px."""
    return _font(size).getlength(_plain(text)) + (2.0 * EMPHASIS if strong else 0.0)


@functools.cache
def _font(size: int) -> ImageFont.FreeTypeFont:
    font = ImageFont.load_default(size)
    if not isinstance(font, ImageFont.FreeTypeFont):
        raise RenderError("pictures need a Pillow with FreeType: install Pillow from its wheels")
    return font


@functools.lru_cache(2048)
def _mask(text: str, size: int, anchor: str, strong: bool) -> tuple[Image.Image, tuple[int, int]]:
    """Return text as a mask, and its upper left corner from the anchor, px; cached, because drawing is slow."""
    plain, font = _plain(text), _font(size)
    room = 2 * size
    width = math.ceil(font.getlength(plain))
    image = Image.new("L", (width + 2 * room, 2 * room))
    writer = ImageDraw.Draw(image)
    start = {"l": 0, "r": width}[anchor[0]]
    writer.text((room + start, room), plain, 255, font, anchor, stroke_width=EMPHASIS if strong else 0.0)
    # Pillow's own font has no micro sign: a u with a tail
    for k, letter in enumerate(text):
        if letter == "µ":
            stem = room + font.getlength(plain[:k]) + 0.1 * size
            writer.line((stem, room - 2, stem, room + 0.2 * size), 255, max(size // 11, 1))
    box = image.getbbox() or (0, 0, 1, 1)
    return image.crop(box), (box[0] - room - start, box[1] - room)


def _plain(text: str) -> str:
    return text.replace("µ", "u")


def _fine(point: Point) -> Point:
    return FINENESS * point[0], FINENESS * point[1]

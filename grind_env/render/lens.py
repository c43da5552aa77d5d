"""The wheel's face under a lens: grains with their wear flats and the chips between them; and the tray of parts."""

import math

from grind_env.process.cost import SCRAP_BELOW
from grind_env.render import palette as ink
from grind_env.render.canvas import Box, Canvas
from grind_env.render.view import EpisodePicture

GRAINS = 9
LOADED = 0.7
"""Share of the height of the grains to which a fully loaded wheel is filled."""


def draw_lens(canvas: Canvas, panel: Box, view: EpisodePicture) -> None:
    """Grains whose tips flatten as the wear-flat area grows, pores that fill as the wheel loads, and the scale."""
    canvas.rectangle(panel, ink.PANEL, outline=ink.EDGE, radius=6.0)
    face = Box(panel.left + 10.0, panel.top + 8.0, panel.left + 0.60 * panel.width, panel.bottom - 8.0)
    _draw_face(canvas, face, view)
    _draw_scale(canvas, Box(face.right + 22.0, panel.top, panel.right - 12.0, panel.bottom), view)


def _draw_face(canvas: Canvas, face: Box, view: EpisodePicture) -> None:
    wheel = view.wheel
    bond = face.bottom - max(0.36 * face.height, 17.0)
    pitch = face.width / GRAINS
    cut, colour = ink.dullness(wheel.A), ink.wear_colour(wheel.A)
    tallest = bond - face.top - 2.0
    canvas.rectangle(Box(face.left, bond - LOADED * wheel.lam * tallest, face.right, bond), ink.FLANGE)
    for k in range(GRAINS):
        x = face.left + (k + 0.5) * pitch
        # a grain is a pyramid whose tip has been worn to a flat: the lower it stands, the wider the flat
        top = bond - tallest * (0.94 + 0.06 * math.sin(2.3 * k)) * (1.0 - 0.5 * cut)
        lean = 0.08 * pitch * math.sin(5.1 * k)
        flat, foot = pitch * (0.05 + 0.27 * cut), pitch * 0.43
        canvas.polygon(
            [(x - foot, bond), (x + lean - flat, top), (x + lean + flat, top), (x + foot, bond)],
            ink.GRAIN if k % 2 else ink.mix(ink.GRAIN, ink.WHEEL, 0.3),
        )
        canvas.line([(x + lean - flat - 0.5, top), (x + lean + flat + 0.5, top)], colour, 3.0)
    canvas.rectangle(Box(face.left, bond, face.right, face.bottom), ink.WHEEL, radius=2.0)
    canvas.text((face.left + 8.0, face.bottom - 5.0), "wheel face, enlarged", 11, ink.GREY)


def _draw_scale(canvas: Canvas, box: Box, view: EpisodePicture) -> None:
    wheel = view.wheel
    y = box.top + 0.30 * box.height
    canvas.text((box.left, y), "wear-flat area", 11, ink.GREY)
    canvas.text((box.right, y), f"{100.0 * wheel.A:.2f} %", 12, anchor="rs", strong=True)
    bar = Box(box.left, y + 0.12 * box.height, box.right, y + 0.12 * box.height + 7.0)
    steps = 40
    for k in range(steps):
        left = bar.left + bar.width * k / steps
        canvas.rectangle(
            Box(left, bar.top, left + bar.width / steps + 0.5, bar.bottom), ink.ramp(ink.WEAR, (k + 0.5) / steps)
        )
    x = bar.left + bar.width * ink.dullness(wheel.A)
    canvas.polygon([(x, bar.bottom - 1.0), (x - 5.0, bar.bottom + 7.0), (x + 5.0, bar.bottom + 7.0)], ink.INK)
    canvas.text((box.left, box.bottom - 0.13 * box.height), "loading", 11, ink.GREY)
    canvas.text((box.right, box.bottom - 0.13 * box.height), f"{100.0 * wheel.lam:.0f} %", 12, anchor="rs", strong=True)


def draw_tray(canvas: Canvas, box: Box, view: EpisodePicture) -> None:
    """One cell per part: full height and struck out for scrap, lower and plain for a good one, a line if to come."""
    parts = [block for block in view.ground if block.finished]
    canvas.text(
        (box.right, box.bottom),
        f"{view.scrapped} scrap",
        12,
        ink.BRICK if view.scrapped else ink.TEAL_TEXT,
        "rs",
        strong=True,
    )
    pitch = (box.width - 62.0) / view.extent.parts
    cell = min(pitch - min(2.0, 0.25 * pitch), 14.0)
    for k in range(view.extent.parts):
        left = box.left + pitch * k
        if k >= len(parts):
            canvas.rectangle(Box(left, box.bottom - 3.0, left + cell, box.bottom), ink.EDGE)
        elif parts[k].good < SCRAP_BELOW:
            canvas.rectangle(Box(left, box.top, left + cell, box.bottom), ink.BRICK)
            canvas.line([(left + 1.0, box.bottom - 1.0), (left + cell - 1.0, box.top + 1.0)], ink.PANEL, 1.0)
        else:
            canvas.rectangle(Box(left, box.bottom - 0.6 * box.height, left + cell, box.bottom), ink.TEAL)

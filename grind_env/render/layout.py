"""The two arrangements of a picture, and the text around its panels."""

from grind_env.render import palette as ink
from grind_env.render.canvas import Box, Canvas, text_width
from grind_env.render.machine_drawing import draw_lens, draw_machine, draw_tray
from grind_env.render.picture_data import EpisodePicture
from grind_env.render.strip_charts import draw_charts

MARGIN = 14.0
GAP = 8.0
TITLE_SIZES = (17, 15, 13)


def draw_wide(view: EpisodePicture, width: int, height: int) -> Canvas:
    """Return a canvas with machine, wheel face and parts on the left, charts on the right."""
    canvas = Canvas(width, height)
    middle = 0.5 * width
    right, bottom = width - MARGIN, height - MARGIN
    _draw_heading(canvas, Box(MARGIN, 0.0, right, 48.0), view)
    draw_machine(canvas, Box(MARGIN, 48.0, middle - 4.0, 370.0), view)
    draw_lens(canvas, Box(MARGIN, 370.0 + GAP, middle - 4.0, 452.0), view)
    draw_tray(canvas, Box(MARGIN + 2.0, 463.0, middle - 6.0, 479.0), view)
    draw_charts(canvas, Box(middle + 4.0, 48.0, right, 483.0), view)
    _draw_block(canvas, Box(MARGIN, 493.0, right, bottom), view, 15)
    return canvas


def draw_tall(view: EpisodePicture, width: int, height: int) -> Canvas:
    """Return a canvas with all panels one below the other."""
    canvas = Canvas(width, height)
    right = width - MARGIN
    _draw_heading(canvas, Box(MARGIN, 0.0, right, 48.0), view)
    draw_machine(canvas, Box(MARGIN, 48.0, right, 266.0), view)
    draw_lens(canvas, Box(MARGIN, 266.0 + GAP, right, 334.0), view)
    draw_tray(canvas, Box(MARGIN + 2.0, 343.0, right - 2.0, 357.0), view)
    draw_charts(canvas, Box(MARGIN, 365.0, right, height - 44.0), view)
    _draw_block(canvas, Box(MARGIN, height - 37.0, right, height - 10.0), view, 12)
    return canvas


def _draw_heading(canvas: Canvas, box: Box, view: EpisodePicture) -> None:
    base, room = box.top + 31.0, box.width
    if view.ground:
        amount, _, unit = view.price.partition(" ")
        right = box.right - text_width(unit, 12) - 6.0
        canvas.text((box.right, base), unit, 12, ink.GREY, "rs")
        canvas.text((right, base), amount, 20, anchor="rs", strong=True)
        room = right - text_width(amount, 20, strong=True) - 12.0 - box.left
    title, size = _fitted(view.extent.title, room)
    canvas.text((box.left, base), title, size, strong=True)


def _fitted(title: str, room: float) -> tuple[str, int]:
    """Return a title and its font size; both are reduced, if necessary, so that it is at most `room` px wide."""
    size = next((size for size in TITLE_SIZES if text_width(title, size, strong=True) <= room), TITLE_SIZES[-1])
    shown = title
    while len(shown) > 1 and text_width(shown, size, strong=True) > room:
        shown = shown.removesuffix("…")[:-1] + "…"
    return shown, size


def _draw_block(canvas: Canvas, box: Box, view: EpisodePicture, size: int) -> None:
    canvas.rectangle(box, ink.STRIP, radius=4.0)
    x, base = box.left + 12.0, 0.5 * (box.top + box.bottom) + 0.36 * size
    counter = f"block {view.number} of {view.extent.blocks}"
    end = box.right - text_width(counter, 12) - 24.0
    if not view.text:
        canvas.text((x, base), "no block run yet", size, ink.GREY)
    for word in view.text.split():
        chosen = {"E": ink.BLUE, "D": ink.ORANGE_TEXT} if word[1:2].isdigit() else {}
        colour = chosen.get(word[0], ink.INK)
        strong = colour != ink.INK
        if x + text_width(word, size, strong) + size > end:  # room for three dots
            canvas.text((x, base), "...", size, ink.GREY)
            break
        canvas.text((x, base), word, size, colour, strong=strong)
        x += text_width(word, size, strong) + 0.5 * size
    canvas.text((box.right - 12.0, base), counter, 12, ink.GREY, "rs")

"""A sheet as a picture: a line for every quantity, with a bar."""

from grind_env.render import palette as ink
from grind_env.render.canvas import Box, Canvas
from grind_env.render.sheet import Sheet

MARGIN, HEADING, FOOT = 28.0, 64.0, 48.0
TALLEST = 44.0
"""Height of a line at most, px."""


def draw_sheet(sheet: Sheet, width: int, height: int) -> Canvas:
    """Title, table and verdict, one below the other."""
    canvas = Canvas(width, height)
    right = width - MARGIN
    canvas.text((MARGIN, 40.0), sheet.title, 17, strong=True)
    panel = Box(MARGIN, HEADING, right, height - FOOT)
    canvas.rectangle(panel, ink.PANEL, outline=ink.EDGE, radius=6.0)
    pitch = min((panel.height - 16.0) / max(len(sheet.entries), 1), TALLEST)
    bar_left, bar_right = panel.left + 0.28 * panel.width, panel.left + 0.72 * panel.width
    for k, entry in enumerate(sheet.entries):
        base = panel.top + 8.0 + pitch * (k + 0.65)
        colour = ink.BRICK if entry.beyond else ink.BLUE
        canvas.text((panel.left + 16.0, base), entry.name, 13)
        canvas.rectangle(Box(bar_left, base - 9.0, bar_right, base), ink.STRIP)
        canvas.rectangle(Box(bar_left, base - 9.0, bar_left + entry.share * (bar_right - bar_left), base), colour)
        text = ink.BRICK if entry.beyond else ink.INK
        canvas.text((panel.right - 16.0, base), entry.text, 13, text, "rs", strong=entry.beyond)
    canvas.text((MARGIN, height - 18.0), sheet.verdict, 14)
    return canvas

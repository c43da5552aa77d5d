"""The strip charts: power, temperature, Ra, E and D over the blocks of the episode."""

from grind_env.render import palette as ink
from grind_env.render.canvas import Box, Canvas
from grind_env.render.picture_data import EpisodePicture
from grind_env.render.strip_chart_data import Strip, strips_of

LABEL = 19.0  #: height of the line of text above a strip, px
WIDEST_BAR = 8.0  #: widest bar of a dress, px


def draw_charts(canvas: Canvas, panel: Box, view: EpisodePicture) -> None:
    """Draw the strips, one below the other, and the dresses below and behind them."""
    canvas.rectangle(panel, ink.PANEL, outline=ink.EDGE, radius=6.0)
    strips = strips_of(view)
    inner = panel.inside(12.0, 4.0, 12.0, 0.0)
    foot = 0.06 * panel.height + LABEL + 7.0
    height = (inner.height - foot) / len(strips)
    plots = [
        Box(inner.left, inner.top + height * k, inner.right, inner.top + height * (k + 1)) for k in range(len(strips))
    ]
    areas = [plot.inside(0.0, LABEL, 0.0, 4.0) for plot in plots]
    _draw_dresses(canvas, Box(inner.left, inner.bottom - foot, inner.right, inner.bottom), areas, view)
    for strip, plot, area in zip(strips, plots, areas, strict=True):
        _draw_strip(canvas, area, strip, view.extent.blocks)
        _label_strip(canvas, plot, strip)


def _middle(box: Box, k: int, blocks: int) -> float:
    return box.left + box.width * (k + 0.5) / blocks


def _draw_dresses(canvas: Canvas, box: Box, areas: list[Box], view: EpisodePicture) -> None:
    """Draw a bar for the dresses of each block, and a band behind the curves."""
    blocks, most = view.extent.blocks, view.extent.most_executions
    base = box.bottom - 7.0
    half = 0.5 * min(0.85 * box.width / blocks, WIDEST_BAR)
    for k, block in enumerate(view.ground):
        if block.executions > 0:
            x = _middle(box, k, blocks)
            for area in areas:
                canvas.rectangle(Box(x - half, area.top, x + half, area.bottom), ink.DRESSED)
            height = (base - box.top - LABEL) * block.executions / most
            canvas.rectangle(Box(x - half, base - height, x + half, base), ink.ORANGE)
    canvas.line([(box.left, base), (box.right, base)], ink.EDGE)
    canvas.text((box.left, box.top + 14.0), f"dresses D (0 to {most})", 11, ink.GREY)
    count = sum(block.executions for block in view.ground)
    canvas.text((box.right, box.top + 14.0), f"{count} so far", 12, ink.ORANGE_TEXT, "rs", strong=True)


def _draw_strip(canvas: Canvas, area: Box, strip: Strip, blocks: int) -> None:
    def height(value: float) -> float:
        return area.bottom - area.height * strip.height(value)

    canvas.line([(area.left, area.bottom), (area.right, area.bottom)], ink.EDGE)
    for k, limit in enumerate(strip.limits):
        if limit > 0.0:
            left = area.left + area.width * k / blocks
            # the last limit runs on to the end of the chart
            right = area.right if k == len(strip.limits) - 1 else area.left + area.width * (k + 1) / blocks
            canvas.dashes((left, height(limit)), (right, height(limit)), ink.GREY)
    points = [(_middle(area, k, blocks), height(value)) for k, value in enumerate(strip.values)]
    if len(points) > 1:
        canvas.line(points, ink.mix(ink.BLUE, ink.PANEL, 0.45), 1.0)
    for k, point in enumerate(points):
        exceeds = strip.exceeds_limit(k)
        canvas.disc(point, 3.0 if exceeds else 1.8, ink.BRICK if exceeds else ink.BLUE)


def _label_strip(canvas: Canvas, plot: Box, strip: Strip) -> None:
    base = plot.top + 14.0
    scale = f" (log scale, {strip.bottom:g} to {strip.top:g})" if strip.bottom > 0.0 else ""
    canvas.text((plot.left, base), f"{strip.name}, {strip.unit}{scale}", 11, ink.GREY)
    colour = ink.BRICK if strip.values and strip.exceeds_limit(-1) else ink.INK
    canvas.text((plot.right, base), strip.latest, 12, colour, "rs", strong=True)

"""The strokes of a run: what `grind run --plot` draws, as wide as a page."""

from typing import TYPE_CHECKING

from grind_env.machine.record import GrindingRecord
from grind_env.render.curves import picture
from grind_env.render.figures import new_figure
from grind_env.render.plots import draw_panels
from grind_env.render.style import FONT, PAGE, paper_style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PANEL = 0.95
"""Height of a panel, in."""


def cycle_figure(record: GrindingRecord) -> "Figure":
    """Depth, power, heat, wheel, roughness and size of a run, stroke by stroke, a panel each.

    Raises:
        MissingExtra: matplotlib is not installed.
    """
    shown = picture(record, record.job)
    with paper_style():
        figure = new_figure(PAGE, 0.5 + PANEL * len(shown.curves))
        draw_panels(shown, figure, FONT)
    return figure

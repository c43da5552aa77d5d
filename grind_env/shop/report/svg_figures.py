"""matplotlib figures as SVG: text stays text, and colours follow the page, light, dark or printed."""

import io
import re
import warnings
from typing import Any

from grind_env.message_text import printable
from grind_env.render.curve_data import BLUE, GREEN, GREY, GRID, INK, ORANGE, PAPER, RED, SHADE, Picture
from grind_env.render.figures import new_figure
from grind_env.render.record_plots import draw_panels
from grind_env.render.series_graphs import Graph, draw_graph

DPI = 96.0  #: resolution of pages, px per inch
WIDTH = 864.0 / DPI  #: width of a figure, in; on A4, letters of `FONT` are then 7 pt high
PANEL, EDGES = 1.2, 0.7  #: height of a panel of a run, and of the edges above and below all panels, in
MARGINS = 1.0, 0.1, 0.4, 0.65  #: margins left, right, above and below the panels of a run, in
FONT = 9.0  #: font size, pt
COLOURS = {"blue": BLUE, "orange": ORANGE, "green": GREEN, "red": RED, "grey": GREY, "ink": INK, "grid": GRID}
#: variables of templates/page.css by colour
VARIABLES = {colour: f"var(--{name})" for name, colour in (COLOURS | {"paper": PAPER, "shade": SHADE}).items()}
UNSAID = {"Creator": None, "Date": None, "Format": None, "Type": None}

_TAG = re.compile(r"<[^>]*>")  # texts and attributes contain no tags, because they are escaped
_COLOUR = re.compile(r"(?<=: )#[0-9a-f]{6}\b")
_LEFT_OUT = re.compile(
    r'(?<=<g) id="[^"]*"| transform="rotate\(-0 [^)]*\)"|(?<=\.\d\d)\d+|\n| font-family: [^"]*?(?=;|")'
)


def drawn(shown: Picture | Graph) -> str:
    """Return the <svg> element of a figure, in which texts are escaped."""
    figure = new_figure(WIDTH, EDGES + PANEL * len(shown.curves) if isinstance(shown, Picture) else shown.height / DPI)
    from matplotlib import rc_context

    inked = ("text.color", "axes.edgecolor", "axes.labelcolor", "xtick.color", "ytick.color")
    settings: Any = {"font.size": FONT, "legend.fontsize": FONT, "axes.linewidth": 0.6, **dict.fromkeys(inked, INK)}
    settings |= {"text.parse_math": False, "svg.fonttype": "none", "svg.hashsalt": "grind_env"}
    with rc_context(settings), warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Glyph")  # the browser has the letters that matplotlib's font lacks
        if isinstance(shown, Picture):
            draw_panels(shown, figure)
            width, height = figure.get_size_inches()
            figure.set_layout_engine(None)  # the layout engine of the figure draws everything twice
            sides = {"left": MARGINS[0] / width, "right": 1.0 - MARGINS[1] / width}
            figure.subplots_adjust(**sides, top=1.0 - MARGINS[2] / height, bottom=MARGINS[3] / height, hspace=0.15)
        else:
            draw_graph(figure.subplots(), shown)
        written = io.StringIO()
        figure.savefig(written, format="svg", transparent=True, metadata=UNSAID)
    svg = written.getvalue().partition("<svg ")
    body = re.sub(r"<defs>\s*<style.*?</style>\s*</defs>", "", svg[2], count=1, flags=re.DOTALL)
    return printable(_TAG.sub(_slim, svg[1] + re.sub(r">\s+<", "><", body)))


def _slim(tag: re.Match[str]) -> str:
    """Return a tag in the colours of the page, without unused attributes and digits that nobody sees."""
    return _LEFT_OUT.sub("", _COLOUR.sub(lambda found: VARIABLES.get(found[0], found[0]), tag[0]))

"""Styles of figures for papers: journal column widths, 8 pt fonts, and marks that are distinct in grey."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from grind_env.optional_libraries import needing

COLUMN, PAGE = 85.0 / 25.4, 170.0 / 25.4  #: widths of a column and of a page of two columns, in

FONT = 8.0  #: font size, pt

#: colours of Okabe and Ito, distinct with any colour vision
COLOURS = ("#000000", "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00")
DASHES = ("-", "--", "-.", ":", "-", "--")  #: line styles beside the colours, for grey prints
MARKS = ("o", "s", "^", "D", "v", "P")


@contextmanager
def paper_style() -> Iterator[None]:
    """Return a context in which figures have the style of papers.

    Raises:
        MissingExtra: matplotlib is not installed.
    """
    with needing("plot", "plots need"):
        from matplotlib import rc_context
    settings: Any = {
        **dict.fromkeys(("font.size", "axes.labelsize", "axes.titlesize", "figure.titlesize"), FONT),
        **dict.fromkeys(("xtick.labelsize", "ytick.labelsize", "legend.fontsize"), FONT),
        "legend.frameon": False,
        "axes.linewidth": 0.6,
        "axes.spines.top": False,
        "axes.spines.right": False,
        "lines.linewidth": 1.1,
        "lines.markersize": 3.5,
        "xtick.major.width": 0.6,
        "ytick.major.width": 0.6,
        "grid.linewidth": 0.4,
        "grid.color": "#d9d9d9",
        "axes.axisbelow": True,
    }
    with rc_context(settings):
        yield

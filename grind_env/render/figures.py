"""matplotlib figures for notebooks and files."""

from pathlib import Path
from typing import TYPE_CHECKING

from grind_env.errors import GrindError
from grind_env.files import check_target, write_atomically
from grind_env.optional_libraries import needing

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: metadata that are left out of a file, by its suffix
UNDATED: dict[str, dict[str, None]] = {
    ".png": {"Software": None},
    ".svg": {"Date": None},
    ".pdf": {"CreationDate": None},
}
FORMATS = tuple(UNDATED)


class PlotError(GrindError):
    """A picture that cannot be drawn."""


def check_format(path: str | Path) -> None:
    """Check the file name for a figure.

    Raises:
        PlotError: its suffix is none of `FORMATS`.
    """
    if Path(path).suffix not in FORMATS:
        raise PlotError(f"{path}: a plot is written as {', '.join(FORMATS)}; name such a file")


def prepare_figure(path: Path) -> None:
    """Check, before long work for a figure, whether it can be drawn and written."""
    check_format(path)
    check_target(path)
    new_figure(1.0, 1.0)


def new_figure(width: float, height: float) -> "Figure":
    """Return an empty figure, width and height in inches.

    Raises:
        MissingExtra: matplotlib is not installed.
    """
    with needing("plot", "plots need"):
        from grind_env.render.notebook_figure import ShownFigure
    return ShownFigure(width, height)


def write_figure(figure: "Figure", path: str | Path) -> None:
    """Write a figure to a .png, .svg or .pdf file; the same figure gives the same bytes.

    Raises:
        PlotError: another suffix.
        FileError: the folder does not exist or cannot be written to.
    """
    from matplotlib import rc_context

    from grind_env.render.notebook_figure import DPI

    check_format(path)
    path = Path(path)
    with rc_context({"svg.hashsalt": "grind_env", "pdf.fonttype": 42}):  # journals want TrueType
        write_atomically(path, lambda name: figure.savefig(name, dpi=DPI, metadata=UNDATED[path.suffix]))

"""The picture of the validation page: measured exponents beside those of the model."""

from collections.abc import Sequence
from pathlib import Path

from grind_env.files import write_atomically
from grind_env.validation import Evidence, Row

BLUE, RED, GREY = "#1f5f8b", "#b5322b", "#8a8a8a"
MEASURED, PASSED, FAILED = "measured, and its band", "model, within the band", "model, outside"


def plot_exponents(rows: Sequence[Row], path: Path) -> None:
    """Draw the rows that set an exponent of the model beside a measured one; needs matplotlib."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    exponents = [row for row in rows if row.check.what.startswith("exponent")]
    beside = [(row, row.check.reference) for row in exponents if row.check.basis.evidence is Evidence.MEASURED]
    drawn = [(row, measured) for row, measured in beside if measured is not None]
    figure = Figure(figsize=(9, 1.2 + 0.36 * len(drawn)), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots()
    for place, (row, measured) in enumerate(drawn):
        band, colour = row.check.band, BLUE if row.passed else RED
        axes.plot([band.low, band.high], [place, place], color=GREY, lw=5, alpha=0.35, solid_capstyle="butt")
        axes.plot(measured, place, "|", color=GREY, ms=12, mew=2.5, label=MEASURED)
        mark = "o" if row.passed else "X"
        axes.plot(row.value, place, mark, color=colour, ms=7, label=PASSED if row.passed else FAILED)
    axes.set_yticks(range(len(drawn)), [row.check.what.removeprefix("exponent of ") for row, _ in drawn])
    axes.invert_yaxis()
    axes.axvline(0.0, color=GREY, lw=0.8)
    axes.set_xlabel("exponent")
    axes.grid(axis="x", color=GREY, alpha=0.2)
    axes.spines[["top", "right", "left"]].set_visible(False)
    axes.tick_params(axis="y", length=0)
    handles, labels = axes.get_legend_handles_labels()
    known = dict(zip(labels, handles, strict=True))
    figure.legend(known.values(), known, loc="outside upper center", ncols=3, frameon=False)
    write_atomically(path, lambda temporary: figure.savefig(temporary, dpi=130))

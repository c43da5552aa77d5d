"""The picture of an optimisation: cost of a part over its time, with the program as it was and the one chosen."""

from pathlib import Path
from typing import TYPE_CHECKING

from grind_env.render.figures import check_format, new_figure, write_figure
from grind_env.render.plots import BLUE, GREEN, GREY
from grind_env.shop.optimise.outcome import Optimised, Verdict

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def plot_optimised(found: Optimised, path: Path) -> None:
    """Draw an optimisation into a .png, .svg or .pdf file.

    Raises:
        PlotError: another suffix.
        MissingExtra: matplotlib is not installed.
        FileError: the folder does not exist or cannot be written to.
    """
    check_format(path)
    write_figure(draw_optimised(found), path)


def draw_optimised(found: Optimised) -> "Figure":
    """Draw cost over time: the cheapest programs tried, and the two in question.

    Raises:
        MissingExtra: matplotlib is not installed.
    """
    figure = new_figure(6.4, 4.6)
    axes = figure.subplots()
    figure.suptitle(f"{found.program}: cost over time, batches of {found.parts} runs")
    before, chosen = found.chosen
    seconds, costs = [each.seconds for each in found.cheapest], [each.cost for each in found.cheapest]
    axes.plot(seconds, costs, "-o", color=BLUE, ms=3, lw=1.3, label="cheapest tried that keeps the limits")
    axes.plot(before.seconds, before.cost, "s", color=GREY, ms=8, label="the program as it was")
    name = "chosen" if found.verdict is Verdict.BETTER else "best one tried"
    axes.plot(chosen.seconds, chosen.cost, "*", color=GREEN, ms=15, label=f"{name}: {chosen.seconds:.1f} s")
    for wish in found.wishes:
        line = axes.axvline if wish.name == "seconds" else axes.axhline
        line(wish.most, color="black", ls="--", lw=1.2, label=f"asked: {wish.most:g} {wish.unit}")
    axes.set(xlabel="time of a part, s", ylabel="$ a part, on the lots of the search")
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8)
    return figure

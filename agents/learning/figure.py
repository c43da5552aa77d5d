"""Learning curves as a figure for papers."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from agents.learning.curve import Point, curve_path, read_curve
from grind_env.errors import GrindError
from grind_env.policies.learned.saved import SUFFIX
from grind_env.render.figures import new_figure
from grind_env.render.style import COLOURS, COLUMN, DASHES, MARKS, paper_style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

HEIGHT = 2.5
"""in."""
LOWEST = -100.0
"""Score below which curves are not told apart: what lies far below the best fixed plan."""


def read_curves(files: Sequence[Path]) -> dict[str, list[Point]]:
    """The curves of agents by their names, those of one kind in the order of their seeds.

    Args:
        files: agents (.safetensors), or the curves (.csv) beside them.

    Raises:
        GrindError: a file is no curve or one without points, or two have the same name.
    """
    found: dict[str, list[Point]] = {}
    for file in files:
        name = "-".join(file.stem.split("-")[:2])  # kind and seed; then comes the hash of the settings
        if name in found:
            name = file.stem
        if name in found:
            raise GrindError(f"{file}: there is another curve of {name}; name each once")
        found[name] = read_curve(curve_path(file) if file.suffix == SUFFIX else file)
        if not found[name]:
            raise GrindError(f"{file}: the learning curve has no point; wait for the first validation of the training")
    return found


def curves_figure(curves: dict[str, list[Point]]) -> "Figure":
    """Validation score over environment steps, a line for each training.

    Raises:
        MissingExtra: matplotlib is not installed.
    """
    with paper_style():
        figure = new_figure(COLUMN, HEIGHT)
        axes = figure.subplots()
        for k, (name, points) in enumerate(curves.items()):
            steps, scores = np.array([(0.001 * point.steps, point.score) for point in points]).T
            axes.plot(
                steps,
                scores,
                color=COLOURS[k % len(COLOURS)],
                ls=DASHES[k % len(DASHES)],
                marker=MARKS[k % len(MARKS)],
                markevery=max(len(points) // 8, 1),
                mfc="white",
                label=name,
            )
        low = max(min(point.score for points in curves.values() for point in points), LOWEST)
        axes.set_ylim(low - 5.0, 105.0)
        axes.axhline(0.0, color=COLOURS[0], lw=0.6)
        axes.set(xlabel="environment steps, thousand", ylabel="validation score")
        axes.grid(True)
        axes.legend(loc="lower right")
    return figure

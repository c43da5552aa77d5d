"""Figures of the benchmark: `iqm` and `curves`, PNG files."""

import io
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from agents.benchmark.aggregate import MEASURES, aggregates, all_runs, scored_tasks
from agents.benchmark.results import Result
from agents.benchmark.summary import tasks_of
from grind_env.files import write_atomically
from grind_env.policies.score_statistics import CLIP, ScoredRuns

WIDTH = 9.0  #: width of the figures, inches; at `DPI` a little wider than a page of a repository
DPI = 110

#: colours of Okabe and Ito, which differ for any colour vision
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
DASHES = ("-", "--", ":", "-.")  #: line styles in addition to the colours, for grey prints
GREY = "#8a8a8a"
#: colour of the information that a policy sees
SEES = {"measurements": "#0072B2", "state": "#D55E00", "future": "#000000"}
MARKS = {"scripted": "o", "planner": "s", "learned": "D"}


def write_figures(results: Sequence[Result], folder: Path) -> list[Path]:
    """Draw the figures that the results allow, in `folder`; return the written files."""
    folder.mkdir(parents=True, exist_ok=True)
    runs, tasks = all_runs(results), len(scored_tasks(results))
    draw = {
        "iqm": lambda: aggregate_figure(results, runs, tasks),
        "curves": lambda: curve_figure(results),
    }
    paths = {name: folder / f"{name}.png" for name in figure_names(results, scored=bool(runs))}
    for name, path in paths.items():
        write_figure(draw[name](), path)
    return list(paths.values())


def figure_names(results: Sequence[Result], *, scored: bool) -> list[str]:
    """Return the names of the figures that can be drawn; `scored` if policies have scores in all tasks."""
    return ["iqm"] * scored + ["curves"] * any(len(each.curve_steps) for each in results)


def write_figure(figure: Figure, path: Path) -> None:
    """Write a PNG file in one atomic step; equal figures give equal bytes."""
    picture = io.BytesIO()
    FigureCanvasAgg(figure)
    figure.savefig(picture, format="png", metadata={"Software": None})
    write_atomically(path, lambda partial: partial.write_bytes(picture.getvalue()))


def aggregate_figure(results: Sequence[Result], runs: dict[str, ScoredRuns], tasks: int) -> Figure:
    """Draw the interquartile mean and the mean of every policy."""
    found = aggregates(runs)
    names = list(found)
    figure = Figure(figsize=(WIDTH, 1.0 + 0.24 * len(names)), dpi=DPI, layout="constrained")
    of = {each.policy: each for each in results}
    for panel, measure in zip(figure.subplots(1, len(MEASURES), sharey=True), MEASURES, strict=True):
        for k, name in enumerate(names):
            one, colour = found[name][measure], SEES[of[name].sees]
            panel.plot([one.low, one.high], [-k, -k], color=colour, lw=2.2, alpha=0.55, solid_capstyle="butt")
            panel.plot([one.value], [-k], MARKS[of[name].kind], color=colour, ms=4.5)
        panel.set_title(measure, fontsize=9)
        panel.set_yticks([-k for k in range(len(names))], names, fontsize=8)
        panel.tick_params(axis="x", labelsize=8)
        plain(panel, "x")
    figure.supxlabel(f"normalised score over {tasks} tasks, clipped at {CLIP:g}; 95 % intervals", fontsize=9)
    _legend(figure, results)
    return figure


def curve_figure(results: Sequence[Result]) -> Figure:
    """Draw the mean score on validation seeds over training steps, a panel per task; bands are from least to most."""
    with_curve = [each for each in results if len(each.curve_steps)]
    tasks, kinds = tasks_of(with_curve), list(dict.fromkeys(each.policy for each in with_curve))
    columns = min(4, len(tasks))
    rows = -(-len(tasks) // columns)
    figure = Figure(figsize=(WIDTH, 0.6 + 2.0 * rows), dpi=DPI, layout="constrained")
    panels = figure.subplots(rows, columns, sharex=True, squeeze=False).ravel()
    for panel, task in zip(panels, tasks, strict=False):
        for k, kind in enumerate(kinds):
            runs = [each for each in with_curve if (each.task, each.policy) == (task, kind)]
            if not runs:
                continue
            steps, scores = runs[0].curve_steps, np.array([each.curve_score for each in runs])
            look: dict[str, Any] = {"color": COLOURS[k % len(COLOURS)]}
            panel.plot(steps, scores.mean(axis=0), ls=DASHES[k % len(DASHES)], lw=1.4, **look)
            panel.fill_between(steps, scores.min(axis=0), scores.max(axis=0), alpha=0.12, lw=0, **look)
        # what an agent scores after its first sixteenth says little
        least = np.array([each.curve_score[1:].min() for each in with_curve if each.task == task])
        panel.set_ylim(max(0.0, float(least.min()) - 5.0), 100.0)
        panel.set(title=task, xscale="log")
        panel.title.set_fontsize(9)
        panel.tick_params(labelsize=8)
        plain(panel, "both")
    for panel in panels[len(tasks) :]:
        panel.set_visible(False)
    figure.supxlabel("environment steps", fontsize=9)
    figure.supylabel("score on validation seeds", fontsize=9)
    handles = [
        panels[0].plot([], [], color=COLOURS[k % len(COLOURS)], ls=DASHES[k % len(DASHES)], label=kind)[0]
        for k, kind in enumerate(kinds)
    ]
    figure.legend(handles=handles, loc="outside upper center", ncols=len(handles), fontsize=8, frameon=False)
    return figure


def plain(panel: Axes, axis: str) -> None:
    """Give a panel a faint grid and no box."""
    panel.grid(True, axis="x" if axis == "x" else "both", color="#dddddd", lw=0.6)
    panel.set_axisbelow(True)
    panel.spines[["top", "right"]].set_visible(False)


def _legend(figure: Figure, results: Sequence[Result]) -> None:
    panel = figure.axes[0]
    kinds = dict.fromkeys(each.kind for each in results)
    handles = [panel.plot([], [], "o", color=colour, ms=5, label=f"sees {sees}")[0] for sees, colour in SEES.items()]
    handles += [panel.plot([], [], MARKS[kind], color=GREY, ms=5, label=kind)[0] for kind in kinds]
    figure.legend(handles=handles, loc="outside upper center", ncols=len(handles), fontsize=8, frameon=False)

"""The figures of the benchmark: `profiles`, `iqm`, `improvement` and `cost`, PNG files."""

import io
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from agents.benchmark.aggregate import MEASURES, aggregates, all_runs, improvements, profile, scored_tasks
from agents.benchmark.plan import AT
from agents.benchmark.results import Result
from agents.benchmark.summary import KNOWLEDGE, PolicySummary, summaries, tasks_of
from grind_env.files import write_atomically
from grind_env.policies.registry import FIXED_PLANS, REFERENCE
from grind_env.policies.statistics import CLIP, Interval, ScoredRuns

WIDTH = 9.0
"""Inches; at `DPI` a little wider than a page of a repository shows."""
DPI = 110

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
"""Of Okabe and Ito: told apart with any colour vision."""
DASHES, LINE_MARKS = ("-", "--", ":", "-."), "os^DvPX"
"""Beside them, for grey prints: of these numbers none is a multiple of the other."""
GREY = "#8a8a8a"
SEES = {"measurements": "#0072B2", "state": "#D55E00", "future": "#000000"}
"""Colours of what a policy sees."""
MARKS = {"scripted": "o", "planner": "s", "learned": "D"}
OVER = "adaptive_rule"
"""The policy that others are compared with."""
PROFILED = 3
"""Tasks from which on a profile says more than their scores."""
LEAST, MOST = 40.0, 160.0
"""Ends of the axis of costs, %."""
LEVELS, EACH = np.linspace(0.0, 100.0, 101), 20
"""Of profiles, and how many of them lie between two marks of a line."""


def write_figures(results: Sequence[Result], folder: Path) -> list[Path]:
    """Draw what the results allow, below `folder`; the files that were written."""
    folder.mkdir(parents=True, exist_ok=True)
    runs, tasks = all_runs(results), len(scored_tasks(results))
    draw = {
        "cost": lambda: cost_figure(results),
        "iqm": lambda: aggregate_figure(results, runs, tasks),
        "profiles": lambda: profile_figure(results, runs, tasks),
        "improvement": lambda: improvement_figure(results, runs, tasks),
    }
    paths = {name: folder / f"{name}.png" for name in figure_names(runs)}
    for name, path in paths.items():
        write_figure(draw[name](), path)
    return list(paths.values())


def figure_names(runs: dict[str, ScoredRuns]) -> list[str]:
    """Names of the figures that can be drawn of policies with these scores."""
    compared = ["improvement"] if OVER in runs and len(runs) > 1 else []
    tasks = max((of.scores.shape[1] for of in runs.values()), default=0)
    profiles = ["profiles"] if tasks >= PROFILED else []
    return ["cost", *(["iqm"] if runs else []), *profiles, *compared]


def write_figure(figure: Figure, path: Path) -> None:
    """Write a PNG file, whole or not at all; the same figure gives the same bytes."""
    picture = io.BytesIO()
    FigureCanvasAgg(figure)
    figure.savefig(picture, format="png", metadata={"Software": None})
    write_atomically(path, lambda partial: partial.write_bytes(picture.getvalue()))


def cost_figure(results: Sequence[Result]) -> Figure:
    """Cost per good part of every policy over that of the best fixed plan, a panel a task."""
    tasks = tasks_of(results)
    costs = {task: relative_costs(summaries(results, task)) for task in tasks}
    sees = {each.policy: each.sees for each in results}
    found: dict[str, list[float]] = {}
    for task in tasks:
        for name, cost in ((name, cost) for name, cost in costs[task].items() if AT not in name):
            found.setdefault(name, []).append(min(cost.value, MOST))
    shown = [name for name, values in found.items() if min(values) < MOST]
    policies = sorted(shown, key=lambda name: (KNOWLEDGE.index(sees[name]), -float(np.mean(found[name]))))
    columns = min(4, len(tasks))
    rows = -(-len(tasks) // columns)
    figure = Figure(figsize=(WIDTH, rows * (0.7 + 0.21 * len(policies))), dpi=DPI, layout="constrained")
    panels = np.atleast_1d(figure.subplots(rows, columns, sharey=True, squeeze=False)).ravel()
    places = {name: -k for k, name in enumerate(policies)}
    kinds = {each.policy: each.kind for each in results}
    for panel, task in zip(panels, tasks, strict=False):
        for name in [name for name in policies if name in costs[task]]:
            _dot(panel, costs[task][name], places[name], SEES[sees[name]], MARKS[kinds[name]])
        panel.axvline(100.0, color=GREY, lw=0.8, zorder=0)
        panel.set_title(task, fontsize=9)
        panel.set_xlim(LEAST, MOST)
        panel.set_yticks(list(places.values()), list(places), fontsize=8)
    for panel in panels[len(tasks) :]:
        panel.set_visible(False)
    for panel in panels[: len(tasks)]:
        plain(panel, "x")
        panel.tick_params(axis="x", labelsize=8)
    figure.supxlabel(f"cost per good part, % of the best fixed plan; beyond {MOST:g} % not shown", fontsize=9)
    _legend(figure, results)
    return figure


def relative_costs(lines: Sequence[PolicySummary]) -> dict[str, Interval]:
    """Cost per good part of every policy of a task, % of that of the best fixed plan; empty if none was run."""
    plans = [line.cost.value for line in lines if line.policy in FIXED_PLANS]
    return {line.policy: Interval(*(100.0 * each / min(plans) for each in line.cost)) for line in lines if plans}


def aggregate_figure(results: Sequence[Result], runs: dict[str, ScoredRuns], tasks: int) -> Figure:
    """Interquartile mean, median, mean and optimality gap of every policy."""
    found = aggregates(runs)
    names = list(found)
    figure = Figure(figsize=(WIDTH, 1.0 + 0.24 * len(names)), dpi=DPI, layout="constrained")
    of = {each.policy: each for each in results}
    for panel, measure in zip(figure.subplots(1, len(MEASURES), sharey=True), MEASURES, strict=True):
        for k, name in enumerate(names):
            _dot(panel, found[name][measure], -k, SEES[of[name].sees], MARKS[of[name].kind])
        panel.set_title(measure, fontsize=9)
        panel.set_yticks([-k for k in range(len(names))], names, fontsize=8)
        panel.tick_params(axis="x", labelsize=8)
        plain(panel, "x")
    figure.supxlabel(f"normalised score over {tasks} tasks, clipped at {CLIP:g}; 95 % intervals", fontsize=9)
    _legend(figure, results)
    return figure


def improvement_figure(results: Sequence[Result], runs: dict[str, ScoredRuns], tasks: int) -> Figure:
    """Probability that a run of each policy beats the rule that is set by hand."""
    found = dict(sorted(improvements(runs, OVER).items(), key=lambda item: -item[1].value))
    figure = Figure(figsize=(WIDTH, 1.0 + 0.24 * len(found)), dpi=DPI, layout="constrained")
    panel = figure.subplots()
    of = {each.policy: each for each in results}
    for k, (name, interval) in enumerate(found.items()):
        _dot(panel, interval, -k, SEES[of[name].sees], MARKS[of[name].kind])
    panel.axvline(0.5, color=GREY, lw=0.8, zorder=0)
    panel.set_xlim(-0.03, 1.03)
    panel.set_yticks([-k for k in range(len(found))], list(found), fontsize=8)
    panel.set_xlabel(f"probability that a run scores above {OVER}, mean over {tasks} tasks; 95 % intervals", fontsize=9)
    plain(panel, "x")
    _legend(figure, results)
    return figure


def profile_figure(results: Sequence[Result], runs: dict[str, ScoredRuns], tasks: int) -> Figure:
    """Share of the runs that score above a level, over the level."""
    figure = Figure(figsize=(WIDTH, 4.2), dpi=DPI, layout="constrained")
    panel = figure.subplots()
    for k, name in enumerate(profiled(results, runs)):
        colour, dashes = COLOURS[k % len(COLOURS)], DASHES[k % len(DASHES)]
        share, low, high = profile(runs[name], LEVELS)
        panel.plot(
            LEVELS,
            share,
            color=colour,
            ls=dashes,
            lw=1.6,
            label=name,
            drawstyle="steps-post",
            marker=LINE_MARKS[k % len(LINE_MARKS)],
            markevery=(3 * k % EACH, EACH),
            ms=4,
        )
        panel.fill_between(LEVELS, low, high, color=colour, alpha=0.10, lw=0, step="post")
    panel.set_xlim(LEVELS[0], LEVELS[-1])
    panel.set_ylim(-0.02, 1.02)
    panel.set_xlabel(f"normalised score, {tasks} tasks; 0: best fixed plan, 100: {REFERENCE}", fontsize=9)
    panel.set_ylabel("share of the runs above it", fontsize=9)
    panel.tick_params(labelsize=8)
    plain(panel, "both")
    figure.legend(*panel.get_legend_handles_labels(), loc="outside right upper", fontsize=8, frameon=False)
    return figure


def profiled(results: Sequence[Result], runs: dict[str, ScoredRuns]) -> list[str]:
    """Policies of which profiles are drawn, the best first: agents, and what they are to be held against."""
    kinds = {each.policy: (each.kind, each.sees) for each in results}
    names = list(aggregates(runs))
    rules = [name for name in names if kinds[name] == ("scripted", "measurements")]
    beside = {OVER, "mpc", *rules[:1]}
    return [name for name in names if kinds[name][0] == "learned" or name in beside]


def _dot(panel: Axes, interval: Interval, place: float, colour: str, mark: str) -> None:
    """An estimate with its interval, on a line of its own."""
    panel.plot([interval.low, interval.high], [place, place], color=colour, lw=2.2, alpha=0.55, solid_capstyle="butt")
    panel.plot([interval.value], [place], mark, color=colour, ms=4.5)


def plain(panel: Axes, axis: str) -> None:
    """A faint grid and no box."""
    panel.grid(True, axis="x" if axis == "x" else "both", color="#dddddd", lw=0.6)
    panel.set_axisbelow(True)
    panel.spines[["top", "right"]].set_visible(False)


def _legend(figure: Figure, results: Sequence[Result]) -> None:
    """What colours and marks mean."""
    panel = figure.axes[0]
    kinds = dict.fromkeys(each.kind for each in results)
    handles = [panel.plot([], [], "o", color=colour, ms=5, label=f"sees {sees}")[0] for sees, colour in SEES.items()]
    handles += [panel.plot([], [], MARKS[kind], color=GREY, ms=5, label=kind)[0] for kind in kinds]
    figure.legend(handles=handles, loc="outside upper center", ncols=len(handles), fontsize=8, frameon=False)

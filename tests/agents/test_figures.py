from dataclasses import replace

import numpy as np
from PIL import Image

from agents.benchmark import figures
from agents.benchmark.aggregate import MEASURES, aggregates, all_runs
from agents.benchmark.plan import BenchmarkCell
from agents.benchmark.results import result_of
from grind_env.policies.problem_lookup import find_problem
from tests.agents.asking import evaluation

COSTS = {"constant": 8.0, "interval": 6.0, "adaptive_rule": 4.0, "hindsight": 2.0}


def results(tasks):
    rng = np.random.default_rng(2)
    rows = []
    for task in map(find_problem, tasks):
        cells = [(BenchmarkCell(task, name), cost) for name, cost in COSTS.items()]
        cells += [(BenchmarkCell(task, "ppo", seed), 3.0 + 0.3 * seed) for seed in range(3)]
        noise = rng.exponential(0.5, 30)
        for cell, cost in cells:
            sees = "future" if cell.policy == "hindsight" else "measurements"
            rows.append(result_of(cell, sees, evaluation(*(cost + noise))))
    return rows


ROWS = results(["power_limited", "rush", "slot"])


def dots(panel):
    """Return the points of a panel as (x, y), without intervals and rules."""
    lines = [line for line in panel.get_lines() if line.get_marker() not in ("", "None") and len(line.get_xdata())]
    return {(float(line.get_xdata()[0]), float(line.get_ydata()[0])) for line in lines}


def test_the_figures_are_small_and_fit_a_page(tmp_path):
    curve = {"curve_steps": np.array([5e5, 1e6]), "curve_score": np.array([40.0, 60.0])}
    rows = [replace(each, **curve) if each.kind == "learned" else each for each in ROWS]
    paths = figures.write_figures(rows, tmp_path / "figures")
    assert [path.name for path in paths] == ["iqm.png", "curves.png"]
    for path in paths:
        assert path.stat().st_size < 150_000
        assert 800 <= Image.open(path).width <= 1200
    assert [path.read_bytes() for path in figures.write_figures(rows, tmp_path / "again")] == [
        p.read_bytes() for p in paths
    ]


def test_without_a_scored_task_nothing_is_drawn(tmp_path):
    assert figures.write_figures(results(["slot"]), tmp_path) == []


def test_a_learning_curve_shows_the_mean_and_the_range_of_its_runs():
    scores = {0: [10.0, 40.0, 60.0], 1: [10.0, 50.0, 80.0], 2: [10.0, 45.0, 70.0]}
    steps = np.array([1e5, 5e5, 1e6])
    rows = [
        replace(each, curve_steps=steps, curve_score=np.array(scores[each.seed])) if each.kind == "learned" else each
        for each in ROWS
    ]
    panels = [each for each in figures.curve_figure(rows).axes if each.get_visible()]
    assert [each.get_title() for each in panels] == ["power_limited", "rush", "slot"]
    for panel in panels:
        line = panel.get_lines()[0]
        assert line.get_xdata().tolist() == steps.tolist() and line.get_ydata().tolist() == [10.0, 45.0, 70.0]
        (band,) = panel.collections
        assert {y for x, y in band.get_paths()[0].vertices if x == 1e6} == {60.0, 80.0}


def test_dots_stand_at_the_aggregates():
    runs = all_runs(ROWS)
    found = aggregates(runs)
    figure = figures.aggregate_figure(ROWS, runs, 2)
    for panel, measure in zip(figure.axes, MEASURES, strict=True):
        assert panel.get_title() == measure
        assert dots(panel) == {(of[measure].value, -k) for k, of in enumerate(found.values())}
    assert [label.get_text() for label in figure.axes[0].get_yticklabels()] == list(found)

import numpy as np
import pytest
from PIL import Image

from agents.benchmark import figures
from agents.benchmark.aggregate import MEASURES, aggregates, all_runs, improvements
from agents.benchmark.plan import BenchmarkCell
from agents.benchmark.results import result_of
from grind_env.policies.problem import find_problem
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
    """Points of a panel as (x, y), without intervals and rules."""
    lines = [line for line in panel.get_lines() if line.get_marker() not in ("", "None") and len(line.get_xdata())]
    return {(float(line.get_xdata()[0]), float(line.get_ydata()[0])) for line in lines}


def test_the_figures_are_small_and_fit_a_page(tmp_path):
    rows = [*ROWS, *results(["blades"])]
    paths = figures.write_figures(rows, tmp_path / "figures")
    assert [path.name for path in paths] == ["cost.png", "iqm.png", "profiles.png", "improvement.png"]
    for path in paths:
        assert path.stat().st_size < 150_000
        assert 800 <= Image.open(path).width <= 1200
    assert [path.read_bytes() for path in figures.write_figures(rows, tmp_path / "again")] == [
        p.read_bytes() for p in paths
    ]


def test_profiles_are_drawn_from_three_scored_tasks_on(tmp_path):
    assert [path.name for path in figures.write_figures(ROWS, tmp_path)] == ["cost.png", "iqm.png", "improvement.png"]


def test_without_a_scored_task_only_costs_are_drawn(tmp_path):
    assert [path.name for path in figures.write_figures(results(["slot"]), tmp_path)] == ["cost.png"]


def test_dots_stand_at_the_aggregates():
    runs = all_runs(ROWS)
    found = aggregates(runs)
    figure = figures.aggregate_figure(ROWS, runs, 2)
    for panel, measure in zip(figure.axes, MEASURES, strict=True):
        assert panel.get_title() == measure
        assert dots(panel) == {(of[measure].value, -k) for k, of in enumerate(found.values())}
    assert [label.get_text() for label in figure.axes[0].get_yticklabels()] == list(found)


def test_dots_stand_at_the_probabilities():
    runs = all_runs(ROWS)
    (panel,) = figures.improvement_figure(ROWS, runs, 2).axes
    values = sorted((each.value for each in improvements(runs, figures.OVER).values()), reverse=True)
    assert dots(panel) == {(value, -k) for k, value in enumerate(values)}


def test_costs_are_in_percent_of_the_best_fixed_plan():
    figure = figures.cost_figure(ROWS)
    panels = [panel for panel in figure.axes if panel.get_visible()]
    assert [panel.get_title() for panel in panels] == ["power_limited", "rush", "slot"]
    names = [text.get_text() for text in panels[0].get_yticklabels()]
    for panel in panels:
        places = dict(zip(names, panel.get_yticks(), strict=True))
        at = {y: x for x, y in dots(panel)}
        assert at[places["interval"]] == pytest.approx(100.0)
        assert at[places["hindsight"]] < at[places["ppo"]] < at[places["adaptive_rule"]] < 100.0


def test_profiles_fall_from_one():
    figure = figures.profile_figure(ROWS, all_runs(ROWS), 2)
    (panel,) = figure.axes
    curves = {line.get_label(): line for line in panel.get_lines()}
    assert list(curves) == ["ppo", "adaptive_rule"]
    assert curves["ppo"].get_ydata()[0] == 1.0
    assert (np.diff(curves["ppo"].get_ydata()) <= 0.0).all()
    assert curves["adaptive_rule"].get_ydata()[-1] == 0.0
    assert len(curves["ppo"].get_xdata()) == len(figures.LEVELS)
    assert len({(line.get_color(), line.get_linestyle()) for line in curves.values()}) == len(curves)
    assert {line.get_color() for line in curves.values()} <= set(figures.COLOURS)

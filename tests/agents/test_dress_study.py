from dataclasses import replace

import numpy as np
import pytest

from agents.benchmark.figures import write_figure
from agents.dressing import findings as studies
from agents.dressing import trials
from agents.dressing.figure import dress_figure
from agents.dressing.findings import DressFinding, best_plan, csv_text, new_overlap
from agents.dressing.trials import study
from grind_env.policies.evaluation import episode_seeds, run_seeds
from grind_env.policies.problem_lookup import find_problem
from grind_env.policies.scripted.rules import Fixed
from tests.agents.asking import in_process, study_options
from tests.policies.harness import changed

PROBLEM = find_problem("oracle6")
ORACLE = PROBLEM.simulation()
TASK = ORACLE.task


def test_overlap_of_a_round_diamond_by_hand():
    # tip radius 0.5 mm, 0.02 mm deep: chord 2 sqrt(2 * 0.5 * 0.02 - 0.02^2) = 0.28 mm; lead 0.1 mm
    assert TASK.dresser.tip_radius == 0.5
    for lead, overlap in ((0.1, 2.8), (0.05, 5.6)):
        dressed = changed(PROBLEM, dress=replace(TASK.dress, depth=0.02, lead=lead)).simulation()
        assert new_overlap(dressed) == pytest.approx(overlap, rel=1e-3)


def test_the_best_plan_is_the_cheapest_of_all():
    plan = best_plan(ORACLE, (1, 2, 3))
    least = min(
        float(run_seeds(Fixed(E, 1, every), ORACLE, [0]).cost[0])
        for E in TASK.action.speed_levels
        for every in (1, 2, 3)
    )
    assert float(run_seeds(plan, ORACLE, [0]).cost[0]) == least


def test_the_best_plan_is_near_the_minimum_of_a_fine_grid(monkeypatch):
    simulation, seeds = find_problem("power_limited").simulation(), episode_seeds("training", 2)
    monkeypatch.setattr(studies, "TRAINING", len(seeds))
    plan = best_plan(simulation, (1, 2))
    low, high = simulation.task.action.speed_ends
    grid = [Fixed(E, 1, every) for E in np.geomspace(low, high, 30) for every in (1, 2)]
    near = [Fixed(plan.E * factor, 1, plan.every) for factor in (0.98, 1.0, 1.02)]
    least, *costs = (float(run_seeds(each, simulation, seeds).cost.mean()) for each in (plan, *near, *grid))
    assert least <= min(costs[:3])
    # a grid as fine as this may find a dip that the search missed
    assert least <= 1.01 * min(costs)


def findings(folder, problem, episodes, monkeypatch, *questions):
    """Return the findings of a study of a problem for some or all questions."""
    in_process(monkeypatch)
    made = study(study_options(folder, problem, episodes=episodes))
    made = replace(made, trials=[each for each in made.trials if each.question in questions or not questions])
    return [DressFinding(**each) for each in made.found(study_options(folder).options).values()]


def test_a_study_answers_all_questions_and_resumes_from_its_cache(tmp_path, monkeypatch):
    monkeypatch.setattr(studies, "TRAINING", 4)
    monkeypatch.setattr(trials, "deciding", lambda problem: ["handbook"])
    found = findings(tmp_path, PROBLEM, 2, monkeypatch)
    assert {each.question for each in found} == {"interval", "plan", "dresser", "passes", "decision"}
    own_dress = (TASK.dress.lead, TASK.dress.depth, TASK.dress.passes)
    own = [each for each in found if (each.lead, each.depth, each.passes) == own_dress]
    # the usual dresser with its best interval is one of the answers to the first question
    dresser, passes, plan = (
        next(each for each in own if each.question == name) for name in ("dresser", "passes", "plan")
    )
    assert dresser.cost == passes.cost == plan.cost == min(each.cost for each in own if each.question == "interval")
    write_figure(dress_figure(found, "Oracle"), tmp_path / "oracle.png")
    assert (tmp_path / "oracle.png").read_bytes().startswith(b"\x89PNG")
    assert len(csv_text(found, range(2)).splitlines()) == len(found) + 1

    monkeypatch.setattr(studies, "plan_cost", None)
    monkeypatch.setattr(trials, "run_seeds", None)
    assert findings(tmp_path, PROBLEM, 2, monkeypatch) == found

import csv
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

from agents.safety.page import page
from agents.safety.trials import LAGRANGIAN, RULES, UNCONSTRAINED, SafetyRow, SafetyTrial, budget_of, judge, violations
from grind_env.policies.evaluation import episode_seeds, run_seeds, start_episodes
from grind_env.policies.problem_lookup import find_problem
from grind_env.policies.registry import make_policy
from grind_env.policies.scripted.rules import Fixed
from tests.agents.asking import in_process, status

PLATES = find_problem("power_limited")


def test_violations_agree_with_the_evaluation_and_the_machine_record():
    simulation, seeds = PLATES.simulation(), episode_seeds("validation", 4)
    plan = Fixed(E=12_000.0, D=0, name="plan")
    totals, found = violations(plan, simulation, seeds)
    run = run_seeds(plan, simulation, seeds)
    assert totals == pytest.approx(np.stack([run.cost, run.finished, run.good], axis=1))
    # the record of the program of the first episode has the same violations
    episodes = start_episodes(simulation, seeds[:1])
    blocks = []
    for _ in range(simulation.task.blocks):
        blocks.append(simulation.writer.block(episodes, 0, 12_000.0, 0.0))
        simulation.step(episodes, np.array([12_000.0]), np.zeros(1))
    record = simulation.writer.record(start_episodes(simulation, seeds[:1]), 0, blocks)
    power, *condemning = found[0]
    (kind,) = simulation.task.kinds
    limits, parts = simulation.task.limits(kind), record.parts
    assert condemning == [
        np.sum(parts["peak_torque"] >= 1.0),
        np.sum(np.abs(parts["size_error"]) > limits.size),
        np.sum(parts["Ra"] > limits.roughness),
        np.sum(parts["rise"] > limits.rise),
    ]
    assert power >= condemning[0]
    assert sum(condemning) > 10


def test_the_scrap_budget_lies_between_mpc_and_look_ahead():
    blind, knowing = (
        run_seeds(make_policy(name, PLATES.simulation()), PLATES.simulation(), range(500_000, 500_128)).scrap
        for name in ("look_ahead", "mpc")
    )
    assert knowing < budget_of(PLATES) < blind
    assert budget_of(PLATES) ** 2 == pytest.approx(blind * knowing, rel=0.02)


def test_a_constraint_changes_the_training(tmp_path: Path):
    found = {
        who: SafetyRow(**judge(SafetyTrial(PLATES, who, 0, 8000, 2, tmp_path))) for who in (UNCONSTRAINED, LAGRANGIAN)
    }
    assert found[UNCONSTRAINED].scrap != found[LAGRANGIAN].scrap
    assert "| power_limited, budget 0." in page(list(found.values()))


def test_the_page_counts_agents_within_budget_and_states_their_cost():
    def judged(task: str, who: str, scrap: float, earned: float) -> SafetyRow:
        same = {each.name: 0.0 for each in fields(SafetyRow)} | {"budget": 0.01, "episodes": 8}
        return SafetyRow(
            **same | {"task": task, "who": who, "scrap": scrap, "scrap_high": 1.5 * scrap, "episode_return": earned}
        )

    found = [
        *(judged("a", UNCONSTRAINED, scrap, -40.0) for scrap in (0.02, 0.01)),
        *(judged("a", LAGRANGIAN, scrap, -42.0) for scrap in (0.01, 0.002)),
        *(judged("b", UNCONSTRAINED, scrap, -10.0) for scrap in (0.02, 0.03)),
        *(judged("b", LAGRANGIAN, scrap, -9.9) for scrap in (0.02, 0.003)),
    ]
    text = page(found)
    assert "`plain_gru` 1 (0) of 4, `plain_gru, Lagrangian` 3 (2) of 4." in text
    assert "by -1.0 to +5.0 %" in text
    assert "on all tasks" not in page(found[:4])


@pytest.mark.nightly
def test_the_command_writes_its_table(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    in_process(monkeypatch)
    words = ("safety", "--task", "power_limited", "--seeds", 1, "--steps", 1, "--episodes", 2)
    assert status(monkeypatch, *words, "--cache", tmp_path, "--results", tmp_path / "results") == 0
    rows = list(csv.DictReader((tmp_path / "results" / "safety.csv").open()))
    assert [row["who"] for row in rows] == [UNCONSTRAINED, LAGRANGIAN, *RULES]

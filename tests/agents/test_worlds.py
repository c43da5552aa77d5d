"""`python -m agents worlds`: the guard of an agent on machines with another constant."""

from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

from agents import worlds
from agents.__main__ import main
from agents.worlds import (
    GUARDED,
    NOMINAL,
    RETUNED,
    RULE,
    SHIPPED,
    WHO,
    WORLDS,
    Found,
    machine_of,
    page,
    promises,
    run_worlds,
)
from grind_env.envs.simulation import Simulation
from grind_env.envs.tables import Outcome
from grind_env.policies.problem import find_problem

PLATES = find_problem("power_limited")


def first_block(simulation: Simulation) -> dict[str, float]:
    """What the first block comes to at 4 m/min, undressed."""
    outcomes, _ = simulation.step(simulation.start([np.random.default_rng(1)]), np.array([4000.0]), np.zeros(1))
    return dict(zip(Outcome._fields, outcomes[0].tolist(), strict=True))


def test_each_machine_differs_from_the_model_as_its_name_says() -> None:
    model = PLATES.simulation()
    ground = {world: first_block(machine_of(model, factors)) for world, factors in WORLDS.items()}
    nominal = ground.pop(NOMINAL)
    assert nominal == first_block(model)
    power = {world: each["power_ratio"] / nominal["power_ratio"] for world, each in ground.items()}
    assert power["forces x 1.35"] == pytest.approx(1.35, rel=0.1) and power["forces x 0.75"] == pytest.approx(
        0.75, rel=0.1
    )
    assert ground["roughness x 1.3"]["roughness_ratio"] == pytest.approx(1.3 * nominal["roughness_ratio"], rel=0.05)
    assert ground["coolant x 0.4"]["rise"] > 1.1 * nominal["rise"]
    assert ground["stiffness / 4"]["size_error"] > nominal["size_error"]
    assert power["dulling x 3"] > 1.0


def test_the_guard_is_held_against_the_cheaper_one_of_agent_and_rule() -> None:
    costs = {RETUNED: 4.0, RULE: 2.0, SHIPPED: 3.0, GUARDED: 2.2}
    found: dict[tuple[str, str], Found] = {
        (world, who): {"cost": costs.get(who, 9.0), "low": 1.0, "high": 9.0, "scrap": 0.01}
        for world in WORLDS
        for who in WHO
    }
    (_, worst, most), (_, nominal, least) = promises(found)
    assert (worst, most, nominal, least) == (pytest.approx(1.1), 1.15, pytest.approx(2.2 / 3.0), 1.03)
    assert page(found, "power_limited", 8).count("yes") == 2
    found["stiffness / 4", GUARDED] = {**found["stiffness / 4", GUARDED], "cost": 2.5}
    assert promises(found)[0][1] == pytest.approx(1.25) and "NO" in page(found, "power_limited", 8)


def test_what_was_found_is_kept_and_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(worlds, "WORLDS", {NOMINAL: {}})
    monkeypatch.setattr(worlds, "WHO", (RULE, SHIPPED, GUARDED))
    first = run_worlds(PLATES, 2, jobs=1, console=Console(quiet=True), runs=tmp_path / "runs", results=tmp_path)
    words = ["agents", "worlds", "--episodes", "2", "--jobs", "1", "--runs", str(tmp_path / "runs")]
    monkeypatch.setattr("sys.argv", [*words, "--results", str(tmp_path)])
    written = {path: path.stat().st_mtime_ns for path in (tmp_path / "runs").rglob("*.json")}
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code in (0, None) and "guarded over the agent, nominal" in capsys.readouterr().out
    assert len(written) == 3 and all(path.stat().st_mtime_ns == time for path, time in written.items())
    assert set(first) == {(NOMINAL, who) for who in (RULE, SHIPPED, GUARDED)}
    rows = (tmp_path / "worlds.csv").read_text().splitlines()
    assert rows[0].startswith("world,who,cost,low,high,scrap,") and len(rows) == 4

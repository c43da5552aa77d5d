"""The command that runs the training recipe of the docs."""

import csv
import json
import re
import sys
from pathlib import Path

import pytest
from rich.console import Console

from agents import recipe as recipes
from agents.__main__ import main
from agents.cells import RESULTS
from agents.provenance import ROOT
from agents.recipe import (
    CSV,
    PAGE,
    SOURCE,
    STEPS,
    WAYS,
    Cell,
    Request,
    Trained,
    recipe,
    run_recipe,
    train,
    variant,
)
from grind_env.errors import GrindError
from grind_env.policies.problem import find_problem

PLATES = find_problem("power_limited")
TEXT = recipe(SOURCE.read_text(encoding="utf-8"))


def test_a_variant_is_the_very_lines_but_for_seed_belief_and_steps() -> None:
    assert variant(TEXT, Cell(PLATES, "belief", 0)) == TEXT
    elsewhere = variant(TEXT, Cell(find_problem("rush"), "belief", 0))
    assert elsewhere.replace("grind/Rush-v0", "grind/PowerLimited-v0") == TEXT != elsewhere
    lines, other = TEXT.splitlines(), variant(TEXT, Cell(PLATES, "measurements", 3), 256).splitlines()
    (belief,) = [line for line in lines if line.startswith("envs = VectorBeliefFilter(")]
    lines.remove(belief)
    assert len(lines) == len(other) <= 18
    changed = [(a, b) for a, b in zip(lines, other, strict=True) if a != b]
    assert [re.sub("seed=0", "seed=3", a).replace(STEPS, "256") for a, _ in changed] == [b for _, b in changed]
    assert len(changed) == 2


def test_lines_that_do_not_have_what_is_changed_are_refused() -> None:
    with pytest.raises(GrindError, match="'seed=0' 0 times"):
        variant(TEXT.replace("seed=0", "seed=1"), Cell(PLATES, "belief", 0))
    with pytest.raises(GrindError, match=r"does not train on .*PowerLimited-v0"):
        variant(TEXT.replace("PowerLimited", "Rush"), Cell(PLATES, "belief", 0))
    with pytest.raises(GrindError, match="has 0 blocks"):
        recipe("# no recipe\n")


def test_a_task_of_ones_own_is_refused_for_no_id_names_it(tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text('base = "power_limited"\n', encoding="utf-8")
    with pytest.raises(GrindError, match="mine is a file, and the recipe names its task by an id"):
        variant(TEXT, Cell(find_problem(str(tmp_path / "mine.toml")), "belief", 0))


def test_a_training_is_judged_kept_and_taken_up_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    few = re.sub(r"gym.make_vec\((.*?), 128", r"gym.make_vec(\1, 16", TEXT).replace("episodes=128", "episodes=2")
    cell, request = Cell(PLATES, "measurements", 1), Request(few, 960, tmp_path)
    found = train(cell, request, lambda done: None)
    assert (found.task, found.sees, found.seed, found.steps, found.episodes) == (
        "power_limited",
        "measurements",
        1,
        960,
        2,
    )
    assert found.score_low <= found.score <= found.score_high and found.cpu_seconds > 0.0
    (kept,) = tmp_path.glob("power_limited-measurements-1-*.json")
    assert Trained(**json.loads(kept.read_text(encoding="utf-8"))) == found
    assert (kept.with_suffix("") / "agent.zip").is_file()
    monkeypatch.setattr(recipes, "run", lambda text: pytest.fail("it was kept"))
    assert train(cell, request, lambda done: None) == found


def test_the_tables_are_of_all_trainings(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def trained(cell: Cell, request: Request) -> Trained:
        score = 80.0 + cell.seed
        numbers = {"score": score, "score_low": score - 1.0, "score_high": score + 1.0, "cost_per_good_part": 2.8}
        more = {"scrap": 0.0, "E": 7.0, "D": 0.3, "cpu_seconds": 60.0, "wall_seconds": 70.0}
        return Trained(
            task=cell.problem.name, sees=cell.way, seed=cell.seed, steps=request.steps, episodes=128, **numbers, **more
        )

    monkeypatch.setattr(recipes, "find_all", lambda cells, request, *_: [trained(cell, request) for cell in cells])
    places = ("--runs", str(tmp_path), "--results", str(tmp_path))
    monkeypatch.setattr(
        sys, "argv", ["agents", "recipe", "--tasks", "power_limited,rush", "--seeds", "3", "--steps", "1000", *places]
    )
    with pytest.raises(SystemExit) as ended:
        main()
    assert not ended.value.code and (text := (tmp_path / PAGE).read_text(encoding="utf-8")) in capsys.readouterr().out
    rows = list(csv.DictReader((tmp_path / CSV).read_text(encoding="utf-8").splitlines()))
    assert [(row["task"], row["sees"], row["seed"]) for row in rows] == [
        (task, way, str(seed)) for task in ("power_limited", "rush") for way in WAYS for seed in range(3)
    ]
    assert {"commit", "task_version", "torch"} <= set(rows[0])
    assert (
        "| rush | measurements alone | 81.0 | 80.0 | 80.0, 81.0, 82.0 |" in text and "1,000 steps of each, 128" in text
    )
    folders = {"console": Console(quiet=True), "runs": tmp_path, "results": tmp_path}
    run_recipe([PLATES], 1, 1000, jobs=1, **folders)
    after = list(csv.DictReader((tmp_path / CSV).read_text(encoding="utf-8").splitlines()))
    assert [row for row in after if row["task"] == "rush"] == rows[6:] and len(after) == 2 + 6
    assert "| rush | measurements alone | 81.0 |" in (tmp_path / PAGE).read_text(encoding="utf-8")
    run_recipe([PLATES], 1, 2000, jobs=1, **folders)
    assert "rush" not in (tmp_path / CSV).read_text(encoding="utf-8")


def test_the_published_recipe_scores_hold_what_the_readme_says() -> None:
    with (RESULTS / CSV).open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert {row["steps"] for row in rows} == {STEPS.replace("_", "")}
    assert not any("dirty" in row["commit"] for row in rows)
    flagship = [row for row in rows if row["task"] == "power_limited"]
    for way, mean, least in (("measurements", 64.0, 61.0), ("belief", 73.0, 70.0)):
        scores = [float(row["score"]) for row in flagship if row["sees"] == way]
        assert len(scores) == 5 and sum(scores) / 5 >= mean and min(scores) >= least
        shown = f"score {sum(scores) / 5:.0f} " if way == "belief" else f"({sum(scores) / 5:.0f} "
        assert shown in (ROOT / "README.md").read_text("utf-8")

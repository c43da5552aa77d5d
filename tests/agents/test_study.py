"""A study runs its trials once, caches them by their inputs and code, and writes a table and a page."""

import csv
import subprocess
import sys
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import pytest
from rich.console import Console

from agents import study as studies
from agents.provenance import ROOT
from agents.study import Options, Study
from grind_env.errors import GrindError
from grind_env.files import FileError

PAGE = ROOT / "docs" / "howto" / "study.md"


@dataclass(frozen=True)
class Trial:
    task: str
    number: int

    def __str__(self) -> str:
        return f"{self.task}"


def run(trial: Trial) -> dict[str, Any]:
    if trial.number == 13:
        raise GrindError("13 is not run")
    return {"square": trial.number**2}


STUDY = Study(
    name="squares",
    title="Squares",
    trials=[Trial("oracle6", 2), Trial("slot", 3)],
    run=run,
    columns=["task", "number", "square"],
    page=lambda found: f"{len(found)} squares",
)


@pytest.fixture
def ran(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """Run trials in this process; return the list of trials run."""
    asked: list[Any] = []

    def run_here(trials: Any, run: Any, jobs: Any, console: Any, ray: Any, done: Any) -> Any:
        asked.extend(trials)
        failed = {trial: "13 is not run" for trial in trials if trial.number == 13}
        for trial in [each for each in trials if each not in failed]:
            done(trial, run(trial))
        return failed

    monkeypatch.setattr(studies, "run_all", run_here)
    return asked


def options(folder: Path, **more: Any) -> Options:
    return Options(runs=folder / "runs", console=Console(quiet=True), **more)


def test_a_study_runs_uncached_trials_and_writes_a_table_and_a_page(tmp_path: Path, ran: list[Any]) -> None:
    STUDY.publish_to(tmp_path, options(tmp_path))
    with (tmp_path / "squares.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [(row["task"], row["number"], row["square"]) for row in rows] == [("oracle6", "2", "4"), ("slot", "3", "9")]
    assert (tmp_path / "squares.md").read_text() == "# Squares\n\n2 squares\n"
    more = replace(STUDY, trials=[*STUDY.trials, Trial("slot", 4)])
    more.publish_to(tmp_path, options(tmp_path))
    assert ran == more.trials
    STUDY.publish_to(tmp_path, options(tmp_path, fresh=True))
    assert ran == [*more.trials, *STUDY.trials]


def test_the_name_of_a_cache_file_depends_on_trial_and_code(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    first = STUDY.path(STUDY.trials[0], tmp_path)
    assert first == STUDY.path(Trial("oracle6", 2), tmp_path) and first.parent == tmp_path / "squares"
    others = [STUDY.path(Trial("oracle6", 3), tmp_path), STUDY.path(Trial("slot", 2), tmp_path)]
    others.append(replace(STUDY, decides=lambda trial: "other").path(STUDY.trials[0], tmp_path))
    monkeypatch.setattr(studies, "sources", lambda module: "other code")
    others.append(STUDY.path(STUDY.trials[0], tmp_path))
    assert first not in others and len(set(others)) == 4


def test_a_failed_trial_is_reported_and_the_others_stay_cached(tmp_path: Path, ran: list[Any]) -> None:
    broken = replace(STUDY, trials=[Trial("slot", 13), *STUDY.trials])
    with pytest.raises(GrindError, match=r"1 of 3 trials failed: slot: 13 is not run"):
        broken.publish_to(tmp_path, options(tmp_path))
    assert not (tmp_path / "squares.csv").exists()
    found, failed = broken.find(options(tmp_path))
    assert len(found) == 2 and list(failed.values()) == ["13 is not run"] and len(ran) == 4


def test_a_users_file_is_refused_as_output_before_any_work(tmp_path: Path, ran: list[Any]) -> None:
    (tmp_path / "squares.md").write_text("mine")
    with pytest.raises(FileError, match=r"squares\.md"):
        STUDY.publish_to(tmp_path, options(tmp_path))
    assert not ran and (tmp_path / "squares.md").read_text() == "mine"


def code_of_the_docs() -> str:
    (code,) = PAGE.read_text(encoding="utf-8").split("```python\n")[1:]
    return code.partition("```")[0]


def test_the_study_of_the_docs_is_short_and_a_trial_of_it_runs() -> None:
    code = code_of_the_docs()
    assert code.count("\n") <= 60
    named: dict[str, Any] = {"__name__": "depths"}
    exec(code.partition("if __name__")[0], named)
    assert named["run"](named["Trial"]("power_limited", 0.02, 2))["cost"] > 0.0


@pytest.mark.nightly
def test_the_study_of_the_docs_writes_its_results(tmp_path: Path) -> None:
    code = code_of_the_docs()
    (tmp_path / "depths.py").write_text(code.replace("episodes: int = 64", "episodes: int = 2"), encoding="utf-8")
    words = [sys.executable, tmp_path / "depths.py", "--jobs", "1"]
    environment = {"PYTHONPATH": str(ROOT), "PATH": "/usr/bin:/bin"}
    ended = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, check=False, env=environment)
    assert not ended.returncode, ended.stderr
    assert "6 runs, 6 to do" in ended.stdout and (tmp_path / "depths.md").exists()
    assert len((tmp_path / "depths.csv").read_text().splitlines()) == 7

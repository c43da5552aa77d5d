"""Commands of `python -m agents` replace result files only if they wrote them."""

from dataclasses import replace
from importlib import import_module
from inspect import signature
from pathlib import Path

import pytest

from agents.benchmark.replication_study import BEGINS as REPLICATIONS
from agents.benchmark.results import CSV
from agents.benchmark.results import TABLE as BENCHMARK
from agents.command_line import app
from agents.commands.studies import COMMANDS, DRESSES
from agents.csv_tables import check_tables
from agents.evaluation_cache import RESULTS
from agents.plants.page import BEGINS as PLANTS
from agents.track.study import FILES as TRACK
from grind_env import examples
from grind_env.command_exit import command
from grind_env.policies.problem_lookup import find_problem
from grind_env.policies.tuned_parameters import CONFIGS, TUNED_FILE
from tests.agents.asking import study_options

PART = examples.FOLDER / "plate_g82.nc"
JOB = PART.with_suffix(".toml")
BY_COMMAND = {
    "oracle6.csv": "dress-study --task oracle6 --results . --cache runs",
    "oracle6.png": "dress-study --task oracle6 --results . --cache runs",
    "gaps.csv": "gaps --task oracle6 --results . --cache runs",
    "gaps.md": "gaps --task oracle6 --results . --cache runs",
    "benchmark.csv": "benchmark --task oracle6 --kinds= --policies handbook --cache .",
    "benchmark.parquet": "benchmark --task oracle6 --kinds= --policies handbook --cache runs --results .",
    "replications.csv": "replicate --task oracle6 --results . --cache runs",
    "replications.md": "replicate --task oracle6 --results . --cache runs",
    "power_limited.csv": "scores --task power_limited --results . --cache runs",
    "intervals.csv": "intervals --results . --cache runs",
    "intervals.md": "intervals --results . --cache runs",
    "splits.csv": "splits --task oracle6 --episodes 2 --results . --cache runs",
    "splits.md": "splits --task oracle6 --episodes 2 --results . --cache runs",
    "scores.toml": "scores --task power_limited --results . --cache runs",
    "plate_g82.toml": f"tune --program {PART} --parameters . --cache runs --policies constant --fresh",
}


@pytest.mark.parametrize("name", BY_COMMAND)
def test_a_users_file_is_refused_as_output_before_any_work(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    path = Path(name)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(JOB.read_bytes())
    with pytest.raises(SystemExit) as ended, command("agents"):
        app(BY_COMMAND[name].split())
    said = capsys.readouterr()
    assert (ended.value.code, said.err.count("\n")) == (2, 1)
    assert path.name in said.err and (
        "would be lost" in said.err or "not written over" in said.err or "dam" in said.err
    )
    assert path.read_bytes() == JOB.read_bytes()
    assert [each for each in tmp_path.rglob("*") if each.is_file()] == [tmp_path / path]


def test_commands_recognise_their_checked_in_files() -> None:
    for own, paths in ((TUNED_FILE, CONFIGS.glob("*.toml")), (BENCHMARK, [RESULTS / CSV])):
        found = list(paths)
        assert found and all(own.fits(path) for path in found)
    check_tables(DRESSES, "dress-study", {path.name: "task,question,policy," for path in DRESSES.glob("*.csv")})
    for begins in (REPLICATIONS, PLANTS, TRACK):
        check_tables(RESULTS, "one of these", begins)


@pytest.mark.parametrize("name", [name for name, of in COMMANDS.items() if not signature(of.own).parameters])
def test_a_study_recognises_its_checked_in_files(name: str, tmp_path: Path) -> None:
    of = COMMANDS[name]
    study = import_module(of.module).study(replace(study_options(tmp_path, find_problem("rush")), results=of.folder))
    study.check(of.folder)

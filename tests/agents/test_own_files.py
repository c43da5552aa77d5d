"""Commands of `python -m agents` replace files under names of their own only if they have written them."""

from pathlib import Path

import pytest

from agents import recipe, splits
from agents.application import app
from agents.benchmark import replications
from agents.benchmark.results import CSV
from agents.benchmark.results import TABLE as BENCHMARK
from agents.cells import RESULTS
from agents.commands.dress_study import FOLDER
from agents.dressing.study import TABLE as STUDY
from agents.plants import page as plants
from agents.reference import gap_table as gaps
from agents.reference.scores import TABLE as SCORES
from agents.safety import study as safety
from agents.tables import check_tables
from agents.track import page as track
from grind_env import examples
from grind_env.policies.tuned import CONFIGS, TUNED_FILE
from grind_env.scores import FILE, REFERENCES
from grind_env.terminal import command

PART = examples.FOLDER / "plate_g82.nc"
JOB = PART.with_suffix(".toml")
BY_COMMAND = {
    "oracle6.csv": "dress-study --task oracle6 --results . --runs runs",
    "oracle6.png": "dress-study --task oracle6 --results . --runs runs",
    "gaps.csv": "gaps --task oracle6 --results . --runs runs",
    "gaps.md": "gaps --task oracle6 --results . --runs runs",
    "benchmark.csv": "benchmark --task oracle6 --kinds= --policies handbook --runs .",
    "benchmark.parquet": "benchmark --task oracle6 --kinds= --policies handbook --runs runs --results .",
    "replications.csv": "replicate --task oracle6 --results . --runs runs",
    "replications.md": "replicate --task oracle6 --results . --runs runs",
    "power_limited.csv": "scores --task power_limited --results . --runs runs --data new.toml",
    "splits.csv": "splits --task oracle6 --episodes 2 --results . --runs runs",
    "splits.md": "splits --task oracle6 --episodes 2 --results . --runs runs",
    "new.toml": "scores --task power_limited --results . --runs runs --data new.toml",
    "plate_g82.toml": f"tune --program {PART} --configs . --runs runs --policies constant --fresh",
}


@pytest.mark.parametrize("name", BY_COMMAND)
def test_a_file_of_somebody_is_told_before_any_work(
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


def test_what_is_checked_in_is_known_for_their_own() -> None:
    elsewhere = ("benchmark", "gaps", "plants", "recipe", "replications", "safety", "splits", "track")
    for own, paths in (
        (TUNED_FILE, CONFIGS.glob("*.toml")),
        (REFERENCES, [FILE]),
        (BENCHMARK, [RESULTS / CSV]),
        (STUDY, FOLDER.glob("*.csv")),
        (SCORES, [path for path in RESULTS.glob("*.csv") if path.stem not in elsewhere]),
    ):
        found = list(paths)
        assert found and all(own.fits(path) for path in found)
    for module in (gaps, plants, recipe, replications, safety, splits, track):
        check_tables(RESULTS, module.__name__, module.BEGINS)

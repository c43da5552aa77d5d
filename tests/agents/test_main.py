import importlib
import re
import shlex
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import minari
import pytest
import typer.main
from PIL import Image

from agents import __main__
from agents.command_line import app
from agents.dressing import findings as dress_study
from agents.provenance import ROOT
from grind_env.policies.tuned_parameters import read_tuned
from tests.agents.asking import in_process
from tests.examples import few

HEAVY = ("torch", "stable_baselines3", "matplotlib", "pyarrow", "cma", "minari")
NO_TABLE = ("dataset", "scores", "tune", "video")  #: commands without a checked-in page of results


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]):
    """Return a function that runs a command line and returns its output."""

    def command(*arguments: object, main: Callable[[], None] = __main__.main) -> str:
        monkeypatch.setattr(sys, "argv", ["agents", *map(str, arguments)])
        with pytest.raises(SystemExit) as stopped:
            main()
        printed = capsys.readouterr()
        assert not stopped.value.code, printed.err
        return printed.out

    return command


def tune(run, folder):
    places = ("--parameters", folder, "--cache", folder)
    run("tune", "--task", "oracle6", "--policies", "constant", "--episodes", 1, *places)
    assert list(read_tuned("oracle6", folder)) == ["constant"]


def study(run, folder):
    places = ("--cache", folder, "--results", folder / "results")
    said = run("dress-study", "--task", "oracle6", "--episodes", 2, *places)
    assert str(folder / "results") in said
    questions = [line.split(",")[1] for line in (folder / "results/oracle6.csv").read_text("utf-8").splitlines()]
    assert set(questions) == {"question", "interval", "plan", "dresser", "passes", "decision"}
    with Image.open(folder / "results/oracle6.png") as picture:
        assert picture.format == "PNG"


def video(run, folder):
    path = folder / "two.gif"
    policies = ("--left", "handbook", "--right", "E9000D1")
    run("video", *policies, "--task", "oracle6", "--frames", 1, "--output", path)
    with Image.open(path) as film:
        assert film.n_frames == 7


def dataset(run, folder):
    run("dataset", "--task", "oracle6", "--policy", "handbook", "--episodes", 2)
    assert list(minari.list_local_datasets()) == ["grind/oracle6/handbook-v0"]


SMOKE = {"tune": tune, "dress-study": study, "video": video, "dataset": dataset}


@pytest.mark.parametrize("command", few(SMOKE, 2))
def test_a_command_from_end_to_end(command: str, run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    in_process(monkeypatch)
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(tmp_path))
    monkeypatch.setattr(dress_study, "TRAINING", 2)
    SMOKE[command](run, tmp_path)


def test_make_results_runs_every_command_that_writes_results(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(ROOT)
    said = subprocess.run(["make", "-n", "results"], capture_output=True, text=True, check=True).stdout
    (listed,) = {*re.findall(r"for each in (.*?); do ", said)}
    every = typer.main.get_command(app)
    asked = [shlex.split(words) for words in shlex.split(listed)]
    assert {*NO_TABLE, *(name for name, *_ in asked)} == {*every.commands}
    for name, *options in asked:
        every.commands[name].make_context(name, options)


def test_help_loads_no_heavy_library():
    every = [*typer.main.get_command(app).commands]
    program = (
        "import sys; from agents.command_line import app\n"
        f"for command in {[[], *([name] for name in every)]}:\n"
        "    app([*command, '--help'], prog_name='agents', standalone_mode=False)\n"
        f"print('loaded:', [name for name in {HEAVY} if name in sys.modules])"
    )
    root = Path(__file__).parents[2]
    ended = subprocess.run([sys.executable, "-c", program], cwd=root, capture_output=True, text=True, check=True)
    assert ended.stdout.count("Usage: agents") == 1 + len(every)
    assert ended.stdout.splitlines()[-1] == "loaded: []"


@pytest.mark.parametrize(
    ("work", "words", "again"),
    [
        ("study.run_all", "benchmark --tasks oracle6 --kinds= --fresh", "the same command without --fresh"),
        ("tuning.rule_tuning.tune", "tune --task oracle6", "the same command"),
        ("study.run_all", "scores --task oracle6", "the same command"),
        ("study.run_all", "dress-study --task oracle6", "the same command"),
    ],
)
def test_ctrl_c_names_the_command_to_resume_with(monkeypatch, capsys, tmp_path, work, words, again):
    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    module, _, name = work.rpartition(".")
    monkeypatch.setattr(importlib.import_module(f"agents.{module}"), name, interrupted)
    folders = [f"--{name}={tmp_path}" for name in ("cache", "results")[: 1 if words.startswith("tune") else 2]]
    monkeypatch.setattr(sys, "argv", ["agents", *words.split(), *folders])
    with pytest.raises(SystemExit) as stopped:
        __main__.main()
    assert stopped.value.code == 130
    assert capsys.readouterr().err == f"agents: interrupted; {again} goes on where it was\n"

"""First commands of a new user: `grind`, `grind init`, `grind job --template`, `grind catalogue`."""

import errno
import json
import os
import re
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

from grind_env.control import read_file
from grind_env.examples import FOLDER as EXAMPLES
from grind_env.machine.job import Diamond, Lots, Part, Setup, Stage, Times, WheelStart
from grind_env.machine.job.job_file import load_job
from grind_env.process.catalogue import KINDS, load_catalogue
from grind_env.process.entries import quantities
from grind_env.shop.start.job_template import job_template
from grind_env.shop.start.sample_log import PRESSURE, sample_log
from grind_env.shop.start.starter_folder import LOG, start_folder
from tests.command import Grind

FILES = {"part.nc", "part.toml", "shop.toml", "first_steps.ipynb", "log.csv"}


def test_grind_without_arguments_names_three_existing_commands(grind: Grind, tmp_path: Path) -> None:
    status, out, err = grind()
    named = re.findall(r"^  grind (\w+)", out, re.MULTILINE)
    assert (status, err, len(named)) == (0, "", 3)
    for name in named:
        assert grind(name, "--help")[0] == 0


def test_the_program_of_grind_init_runs_like_the_example(grind: Grind, tmp_path: Path) -> None:
    folder = tmp_path / "new" / "part"
    status, out, _ = grind("init", folder)
    assert status == 0 and {path.name for path in folder.iterdir()} == FILES
    assert f"grind run {folder / 'part.nc'}" in out
    found = json.loads(grind("run", folder / "part.nc", "--json")[1])
    wanted = json.loads(grind("run", EXAMPLES / "plate_g82.nc", "--json")[1])
    assert found["parts"] == wanted["parts"] and found["warnings"] == []


def test_the_sample_log_is_reproducible_and_can_be_fitted(grind: Grind, tmp_path: Path) -> None:
    """The fitted interval contains the true ploughing pressure."""
    program, job, *_ = start_folder(tmp_path)
    text = (tmp_path / LOG).read_text(encoding="utf-8")
    given, made = (
        np.array([row.split(",") for row in each.splitlines()[1:]], float)
        for each in (text, sample_log(read_file(program), load_job(job)))
    )
    np.testing.assert_allclose(made, given, atol=1.0)
    fitted = json.loads(grind("calibrate", tmp_path / LOG, "--program", program, "--job", job, "--json")[1])
    (found,) = [each for each in fitted["constants"] if each["name"].endswith("ploughing_pressure")]
    assert found["low"] < PRESSURE * found["was"] < found["high"] and found["low"] > found["was"]


@pytest.mark.parametrize("name", sorted(FILES))
def test_grind_init_overwrites_nothing(name: str, grind: Grind, tmp_path: Path) -> None:
    (tmp_path / name).write_text("mine")
    status, _, err = grind("init", tmp_path)
    assert status == 2 and name in err and "not overwritten" in err
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == {name: "mine"}


def test_the_notebook_of_grind_init_runs(
    grind: Grind, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    grind("init", tmp_path)
    monkeypatch.chdir(tmp_path)
    cells = json.loads((tmp_path / "first_steps.ipynb").read_text("utf-8"))["cells"]
    scope: dict[str, object] = {}
    for cell in cells:
        if cell["cell_type"] == "code":
            exec("".join(cell["source"]), scope)
    assert len(re.findall(r"^E\d+: [\d.]+ s", capsys.readouterr().out, re.MULTILINE)) == 4


@pytest.mark.parametrize("there", [False, True])
@pytest.mark.parametrize("works", range(8))
def test_grind_init_writes_all_files_or_none(
    works: int, there: bool, grind: Grind, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder, left = tmp_path / "new" / "part", [works]
    if there:
        folder.mkdir(parents=True)
        (folder / "mine.txt").write_text("mine")
    before = {path: path.is_dir() or path.read_text() for path in tmp_path.rglob("*")}

    def until_full(name: str) -> None:
        does = getattr(Path, name)

        def method(self: Path, *arguments: object, **named: object) -> object:
            left[0] -= 1
            if left[0] < 0:
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
            return does(self, *arguments, **named)

        monkeypatch.setattr(Path, name, method)

    until_full("write_text")
    until_full("replace")
    status, out, err = grind("init", folder)
    monkeypatch.undo()
    assert (status, out) == (2, "") and "No space left on device" in err and err.count("\n") == 1
    assert {path: path.is_dir() or path.read_text() for path in tmp_path.rglob("*")} == before
    assert grind("init", folder)[0] == 0


def test_the_template_is_the_job_of_the_example(grind: Grind, tmp_path: Path) -> None:
    path = tmp_path / "job.toml"
    path.write_text(grind("job", "--template")[1], encoding="utf-8")
    assert load_job(path) == load_job(EXAMPLES / "plate_g82.toml")
    assert grind("job")[0] == 2


def test_the_defaults_in_the_template_are_the_actual_ones(tmp_path: Path) -> None:
    path = tmp_path / "job.toml"
    stated = re.sub(r"^#(\w+ = .+)$", r"\1", job_template(), flags=re.MULTILINE)
    assert stated.count("\n#") < job_template().count("\n#")
    kept = stated.partition("#[[part.stages]]")
    path.write_text(kept[0] + kept[2][kept[2].index("[setup]") :], encoding="utf-8")  # a stage has no default
    assert load_job(path) == load_job(EXAMPLES / "plate_g82.toml")


def test_the_template_has_every_key() -> None:
    keys = set(re.findall(r"^#?(\w+) =", job_template(), re.MULTILINE))
    tables = (Part, Stage, Setup, Times, WheelStart, Diamond, Lots)
    assert keys >= {each.name for table in tables for each in fields(table)} - {"stages"}


def test_the_catalogue_lists_every_entry(grind: Grind) -> None:
    listed = json.loads(grind("catalogue", "--json")[1])
    known = load_catalogue()
    assert {kind: set(names) for kind, names in listed.items()} == {
        kind: set(getattr(known, f"{kind}s")) for kind in KINDS
    }
    assert all(remark for kind in ("material", "wheel") for remark in listed[kind].values())
    shown = grind("catalogue")[1]
    assert all(name in shown for names in listed.values() for name in names)


@pytest.mark.parametrize("kind", KINDS)
def test_a_catalogue_entry_is_shown_with_values_and_units(
    kind: str, grind: Grind, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(os.environ, "COLUMNS", "200")
    name, entry = next(iter(getattr(load_catalogue(), f"{kind}s").items()))
    data = json.loads(grind("catalogue", kind, name, "--json")[1])
    assert all(data[key] == getattr(entry, key) for key in quantities(KINDS[kind]))
    shown = grind("catalogue", kind, name)[1]
    for key, legal in quantities(KINDS[kind]).items():
        (line,) = [line for line in shown.splitlines() if line.split()[:1] == [key]]
        assert getattr(legal, "unit", "") in line


def test_an_entry_of_a_file_is_shown_with_its_remark(grind: Grind, tmp_path: Path) -> None:
    path = tmp_path / "own.toml"
    path.write_text("[wheel.ours]  # from the shelf\nbase = 'a60j'\nwidth = 40\n", encoding="utf-8")
    data = json.loads(grind("catalogue", "wheel", "ours", "--file", path, "--json")[1])
    assert (data["width"], data["remark"]) == (40.0, "from the shelf")


@pytest.mark.parametrize("words", [("weel",), ("wheel", "a60")])
def test_an_unknown_catalogue_name_gets_a_suggestion(words: tuple[str, ...], grind: Grind) -> None:
    status, _, err = grind("catalogue", *words)
    assert status == 2 and "did you mean" in err and err.count("\n") == 1

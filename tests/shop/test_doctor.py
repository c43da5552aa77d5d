"""`grind doctor`: what is installed, what is missing, and how to get it."""

import json
import shlex
from importlib.metadata import requires, version
from pathlib import Path

import pytest
from packaging.requirements import Requirement

from grind_env.shop import doctor
from grind_env.task_version import TASK_VERSION
from tests.command import Grind


def found(grind: Grind) -> dict[str, dict[str, str]]:
    status, out, err = grind("doctor", "--json")
    assert (status, err) == (0, "")
    return {each["what"]: each for each in json.loads(out)}


def test_it_names_what_is_installed_and_how_fast_it_is(grind: Grind) -> None:
    told = found(grind)
    assert version("grind_env") in told["grind_env"]["found"]
    assert f"numba {version('numba')}" in told["libraries"]["found"]
    assert " ns on 1 core" in told["a stroke"]["found"]
    assert {*doctor.EXTRAS} < {*told}


def test_of_an_extra_that_is_missing_it_names_the_remedy(grind: Grind, monkeypatch: pytest.MonkeyPatch) -> None:
    installed = doctor._version
    monkeypatch.setattr(doctor, "_version", lambda library: None if library == "torch" else installed(library))
    told = found(grind)
    assert told["train"]["found"].startswith("torch missing, for `grind train`")
    remedy = shlex.split(told["train"]["remedy"])  # as it is typed anywhere, also outside a checkout
    assert remedy[:2] == ["pip", "install"] and [Requirement(each).name for each in remedy[2:]] == ["torch"]
    (asked,) = {each for each in requires("grind_env") or () if "torch" in each and "'train'" in each}
    assert Requirement(remedy[2]).specifier == Requirement(asked).specifier
    assert "matplotlib " in told["shop"]["found"] and not told["shop"]["remedy"]


def test_a_cache_that_cannot_be_written_is_told(tmp_path: Path) -> None:
    told = doctor._kernels(tmp_path / "no_such_folder")
    assert "cannot be written (No such file or directory)" in told.found and "NUMBA_CACHE_DIR" in told.remedy
    assert not [*tmp_path.iterdir()]


def test_a_library_belongs_to_the_extras_that_ask_for_it() -> None:
    asked = ["numpy>=1.26", "pandas>=2.2; extra == 'data'", 'sb3-contrib<3,>=2.9; extra == "agents"']
    assert doctor._required(asked, "data") == {"pandas": "pandas>=2.2"}
    assert doctor._required(asked, "agents") == {"sb3-contrib": "sb3-contrib<3,>=2.9"}


def test_the_version_is_that_of_the_package_and_of_its_tasks(grind: Grind) -> None:
    assert grind("--version") == (0, f"grind_env {version('grind_env')}, tasks of version {TASK_VERSION}\n", "")

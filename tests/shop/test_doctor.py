"""`grind doctor` lists installed and missing libraries and how to install them."""

import json
import shlex
from importlib.metadata import requires, version
from pathlib import Path

import pytest
from packaging.requirements import Requirement

from grind_env.shop import doctor
from grind_env.task_version import TASK_VERSION
from tests.command import Grind


def doctor_rows(grind: Grind) -> dict[str, dict[str, str]]:
    status, out, err = grind("doctor", "--json")
    assert (status, err) == (0, "")
    return {each["what"]: each for each in json.loads(out)}


def test_doctor_lists_versions_and_the_time_of_a_stroke(grind: Grind) -> None:
    told = doctor_rows(grind)
    assert version("grind_env") in told["grind_env"]["found"]
    assert f"numba {version('numba')}" in told["libraries"]["found"]
    assert " ns on 1 core" in told["a stroke"]["found"]
    assert {*doctor.EXTRAS} < {*told}


def test_doctor_names_the_install_command_of_a_missing_extra(grind: Grind, monkeypatch: pytest.MonkeyPatch) -> None:
    installed = doctor._version
    monkeypatch.setattr(doctor, "_version", lambda library: None if library == "torch" else installed(library))
    told = doctor_rows(grind)
    assert told["train"]["found"].startswith("torch missing, for `grind train`")
    remedy = shlex.split(told["train"]["remedy"])  # works outside a checkout, too
    assert remedy[:2] == ["pip", "install"] and [Requirement(each).name for each in remedy[2:]] == ["torch"]
    (asked,) = {each for each in requires("grind_env") or () if "torch" in each and "'train'" in each}
    assert Requirement(remedy[2]).specifier == Requirement(asked).specifier
    assert "matplotlib " in told["shop"]["found"] and not told["shop"]["remedy"]


def test_doctor_reports_a_cache_folder_it_cannot_write(tmp_path: Path) -> None:
    told = doctor._kernels(tmp_path / "no_such_folder")
    assert "cannot be written (No such file or directory)" in told.found and "NUMBA_CACHE_DIR" in told.remedy
    assert not [*tmp_path.iterdir()]


def test_required_libraries_are_listed_by_extra() -> None:
    asked = ["numpy>=1.26", "pandas>=2.2; extra == 'data'", 'sb3-contrib<3,>=2.9; extra == "agents"']
    assert doctor._required(asked, "data") == {"pandas": "pandas>=2.2"}
    assert doctor._required(asked, "agents") == {"sb3-contrib": "sb3-contrib<3,>=2.9"}


def test_the_version_option_prints_the_package_and_task_versions(grind: Grind) -> None:
    assert grind("--version") == (0, f"grind_env {version('grind_env')}, tasks of version {TASK_VERSION}\n", "")

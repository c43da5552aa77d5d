"""Each usual mistake causes one sentence with its line and the remedy."""

import json
from pathlib import Path
from typing import Any

import pytest

from grind_env.toml import tomllib
from tests.command import status
from tests.machine.harness import DRESS

MISTAKES: list[dict[str, Any]] = tomllib.loads(Path(__file__).with_name("mistakes.toml").read_text("utf-8"))["mistake"]

PROGRAM = f"""G71 G94 G90 G19 S1910 M03
M08
G00 Y20.
G00 X-30. Z-2.5
G00 Y0
G82 X230. I-30. Y-.05 J-.01 L2 F60. E12000. P9100
G80
G00 Y20.
M09
M05
M30
{DRESS}"""

JOB = """
[part]
material = "aisi_52100"
length = 200
width = 20
height = 30
stock = 0.05
tolerance = 9
scrap_cost = 40

[setup]
wheel_speed = 30

[diamond]
x = -120
y = 10
z = -10
"""


def messages_of(program: str, job: str, folder: Path, capsys: pytest.CaptureFixture[str]) -> list[str]:
    """Return the warnings and errors of `grind check --job` for a program and a job."""
    (folder / "part.nc").write_text(program)
    (folder / "part.toml").write_text(job)
    ended = status("check", folder / "part.nc", "--job", folder / "part.toml", "--json")
    report = json.loads(capsys.readouterr().out)
    errors = [error["message"] for error in report["errors"]]
    assert bool(errors) == bool(ended)
    return [*report["warnings"], *errors]


def test_a_correct_program_causes_no_message(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert messages_of(PROGRAM, JOB, tmp_path, capsys) == []
    assert messages_of(PROGRAM.replace("P9100", "P9100 D1"), JOB, tmp_path, capsys) == []


def test_a_wheel_that_wears_below_its_least_diameter_is_reported(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    job = JOB.replace("[diamond]", "[wheel]\ndiameter = 220.00001\n\n[diamond]")
    (sentence,) = messages_of(PROGRAM, job, tmp_path, capsys)
    assert "smaller than its least diameter, 220 mm; begin with a larger one" in sentence


def test_there_are_at_least_40_different_mistakes() -> None:
    assert len(MISTAKES) >= 40
    assert len({mistake["title"] for mistake in MISTAKES}) == len(MISTAKES)


@pytest.mark.parametrize("mistake", MISTAKES, ids=lambda mistake: mistake["title"])
def test_a_mistake_is_reported_in_one_sentence_with_line_and_remedy(
    mistake: dict[str, Any], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    program, job = PROGRAM, JOB
    for old, new in mistake["changes"]:
        assert (old in program) != (old in job)
        program, job = program.replace(old, new, 1), job.replace(old, new, 1)
    (sentence,) = messages_of(program, job, tmp_path, capsys)
    assert f"part.nc:{mistake['line']}: " in sentence or f"line {mistake['line']} " in sentence
    places = [sentence.find(words) for words in mistake["says"]]
    assert -1 not in places and places == sorted(places), sentence
    assert ";" in sentence[: places[-1]]  # the remedy comes after what is wrong

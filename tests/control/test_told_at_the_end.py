"""Options without effect are reported at the end of the program."""

import json
from pathlib import Path
from typing import Any

import pytest

from grind_env.control import Control, Interrupt, Message, ProgramEnd, execute, read
from tests.command import status
from tests.machine.test_cli_run import PLATE

CYCLE = "G71 G94 G90 G19\nG82 X30. I-30. Y-.02 J-.01 F60. E12000. P9{}\nG80\nM30\nO9\nG00 Y{}\nM99\n"


def messages(text: str, **settings: Any) -> list[str]:
    events = list(execute(read(text), Control(**settings)))
    assert isinstance(events[-1], ProgramEnd)
    return [event.text for event in events if isinstance(event, Message)]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("G00 X1.", "nothing has read it"),
        ("#1=#501", "nothing has read it"),
        ("IF [1 EQ 2] THEN #1=#500", "nothing has read it"),
        ("#500=2\nG00 X#500", "the program assigns another one before it reads it"),
        ("#500=#0\n#1=#500", "the program assigns another one before it reads it"),
        ("G00 X#500", ""),
        ("#501=500\nG00 X#[#501]", ""),  # through another variable
        ("IF [#500 EQ #0] GOTO 9\nN9", ""),
        ("#500=#500+1", ""),
        ("G65 P8 A1.\nM30\nO8\n#2=#500\nM99", ""),
        ("M98 P8\nM30\nO8\nWHILE [#500 LT 9] DO 1\n#500=#500+1\nEND 1\nM99", ""),
        (CYCLE.format(" D1", "#500"), ""),  # in a dress program that is executed
        (CYCLE.format("", "#500"), "nothing has read it"),  # in a dress program that is not executed
        (CYCLE.format(" L#500", "9."), ""),
    ],
)
def test_a_variable_that_nothing_reads_is_reported(text: str, said: str) -> None:
    found = messages(text, variables={500: 1.0})
    assert len(found) == bool(said)
    for sentence in found:
        assert sentence.startswith("#500 was given a value at the start") and said in sentence


def test_a_macro_does_not_read_the_local_variables_of_the_main_program() -> None:
    macro = "G65 P8 A1.\nM30\nO8\nG00 X#1\nM99"
    assert len(messages(macro, variables={1: 5.0})) == 1
    assert messages(f"G00 X#1\n{macro}", variables={1: 5.0}) == []


@pytest.mark.parametrize("whole_cycles", [False, True])
def test_late_dress_and_interrupt_requests_are_reported(whole_cycles: bool) -> None:
    text = CYCLE.format("", "9.")
    (dress,) = messages(text, operator_dress_at=(0.1, 5000.0), whole_cycles=whole_cycles)
    assert dress.startswith("the dress asked for at 5000 s is not made") and dress.endswith("ask for it before")
    (interrupt,) = messages(text, interrupts=(Interrupt(9, at=0.1), Interrupt(9, at=5000.0)), whole_cycles=whole_cycles)
    assert interrupt.startswith("O9, asked for at 5000 s, is not run, for the program ends at ")
    assert messages(text, operator_dress_at=(0.1,), interrupts=(Interrupt(9, at=0.2),)) == []


def test_every_command_reports_options_without_effect(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    late = ["--dress-at", "5000", "--interrupt", "9100@6000"]
    variable, dress, interrupt = "#500 was given", "asked for at 5000 s", "asked for at 6000 s"
    assert status("run", PLATE, "--set", "#500=1", *late, "--json") == 0
    found = " ".join(json.loads(capsys.readouterr().out)["warnings"])
    assert all(each in found for each in (variable, dress, interrupt))
    for job in ([], ["--job", Path(PLATE).with_suffix(".toml")]):
        assert status("check", PLATE, *job, "--set", "#500=1") == 0
        assert variable in capsys.readouterr().out
    assert status("trace", PLATE, "--set", "#500=1") == 0
    out, err = capsys.readouterr()
    assert variable in err and variable not in out
    assert status("report", PLATE, "--set", "#500=1", *late, "-o", tmp_path / "page.html") == 0
    page = (tmp_path / "page.html").read_text("utf-8")
    assert all(each in page for each in (variable, dress, interrupt))

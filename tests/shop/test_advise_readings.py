"""Readings of the adviser: rows of files, lines of JSON, typed values, and their refusals."""

import sys
from io import BytesIO
from pathlib import Path
from typing import Any

import pytest

from grind_env.errors import GrindError
from grind_env.shop.advise.operator_readings import check_readings, readings_of
from grind_env.shop.advise.reading_sources import LONGEST_LINE, CsvSource, JsonLines, Prompt, ReadingsRow
from tests.command import Grind
from tests.shop.advising import PLATE, advised, batch, plate_in, rows_of, session_of, session_steps


@pytest.mark.parametrize(
    ("row", "message"),
    [
        ({"mean_powr": 3}, "there is no reading 'mean_powr' .did you mean mean_power"),
        ({"mean_power": "much"}, "mean_power is 'much', but must be a number; leave it empty"),
        ({"mean_power": "nan"}, "must be a number"),
        ({"mean_power": 10**400}, "must be a number"),
        ({"mean_power": True}, "must be a number"),
        ({"mean_power": [1]}, "must be a number"),
        ({"mean_power": -1}, "mean_power is -1, but must lie between 0 and 37500 W"),
        ({"mean_power": 1e6}, "must lie between 0 and 37500 W"),
        ({"E": 50}, "E is 50, but must lie between 3000 and 30000 mm/min"),
        ({"D": 1.5}, "D is 1.5, but must be a whole number"),
        ({"D": 9}, "D is 9, but must lie between 0 and 3"),
        ({"block": 7}, "this is of block 7, but block 1 is awaited"),
        ({"part": 2}, "this is of part 2, but part 1 is awaited"),
        ({"Ra": 0.3}, "Ra is of a finished part, but block 1 finishes none: give it with the last block of part 1"),
        ({"diameter": 400}, "diameter is 400, but must lie between 20 and 301 mm"),
        ({"new_wheel": "perhaps"}, "new_wheel is 'perhaps', but must be 1 or 0"),
        ({"new_wheel": 1}, "new_wheel is 1, but not how large it is: give its diameter"),
    ],
)
def test_a_faulty_reading_is_refused_with_one_sentence(row: dict[str, Any], message: str, tmp_path: Path) -> None:
    session = session_of(tmp_path, [row], [])
    with pytest.raises(GrindError, match=message) as caught:
        session.run()
    assert "\n" not in str(caught.value)
    assert not session_steps(tmp_path)


@pytest.mark.parametrize(
    ("row", "message"),
    [
        ({"mean_power": 2.6}, "mean_power is 2.6 W: if that is kW, write 2600"),
        ({"peak_power": 2.9}, "peak_power is 2.9 W: if that is kW, write 2900"),
        ({"mean_power": 2600.0, "peak_power": 2000.0}, "peak_power is 2000, but a mean power 2600 W"),
        ({"first_power": 2600.0, "peak_power": 2000.0}, "no mean is above the highest load"),
    ],
)
def test_implausible_readings_are_refused(row: dict[str, Any], message: str, tmp_path: Path) -> None:
    simulation: Any = batch(PLATE, 2).simulation()
    with pytest.raises(GrindError, match=f"row 7: .*{message}"):
        check_readings(readings_of(row, "row 7"), simulation, 0, "row 7")
    with pytest.raises(GrindError, match=r"size_error is -0.004 um: if that is mm, write -4"):
        check_readings(readings_of({"size_error": -0.004}, "row 7"), simulation, 1, "row 7")
    # noise may put a peak below an equal mean
    check_readings(readings_of({"mean_power": 2600.0, "peak_power": 2400.0}, "row 7"), simulation, 0, "row 7")


def test_a_refused_reading_does_not_end_the_session(tmp_path: Path) -> None:
    said: list[str] = []
    session = session_of(tmp_path, [], said, as_json=True)
    session.source = JsonLines(BytesIO(b'{"mean_power": 2.6}\nnothing\n{"mean_power": 2600}\n'))
    session.run()
    refused = [line["refused"] for line in advised(said) if "refused" in line]
    assert len(refused) == 2 and "line 1 of the input: mean_power is 2.6 W" in refused[0]
    assert session_steps(tmp_path) == [{"mean_power": 2600.0}]


def test_a_refused_row_of_a_growing_file_can_be_corrected(tmp_path: Path) -> None:
    measured, said = tmp_path / "m.csv", list[str]()
    measured.write_text("mean_power\n2.6\n")
    session = session_of(tmp_path, [], said)

    def wait(seconds: float) -> None:
        if not any("if that is kW" in line for line in said) or "2600" in measured.read_text():
            raise KeyboardInterrupt
        measured.write_text("mean_power\n2600\n")

    session.source = CsvSource(measured, follow=True, wait=wait)
    with pytest.raises(KeyboardInterrupt):
        session.run()
    assert session_steps(tmp_path) == [{"mean_power": 2600.0}]


def test_typed_readings_are_asked_for_until_they_are_valid(tmp_path: Path) -> None:
    lines = iter(["peak_power", "peak_power=much", "size_error=3", "peak_power=2400 mean_power=2100", "stop"])
    said: list[str] = []
    session = session_of(tmp_path, [], said)
    session.source = Prompt(lambda text: next(lines))
    session.run()
    assert session_steps(tmp_path) == [{"mean_power": 2100.0, "peak_power": 2400.0}]
    refused = [
        line for line in said if "write name=value" in line or "must be a number" in line or "of a finished" in line
    ]
    assert len(refused) == 3


def test_a_typed_line_that_is_not_utf_8_is_asked_for_again(tmp_path: Path) -> None:
    lines, said = iter([b"Ra=\xff", b"mean_power=2100", b"stop"]), list[str]()
    session = session_of(tmp_path, [], said)
    session.source = Prompt(lambda text: next(lines).decode())
    session.run()
    assert session_steps(tmp_path) == [{"mean_power": 2100.0}]
    assert any("is not text in UTF-8: type it again" in line for line in said)


def test_unreadable_lines_do_not_lose_the_other_lines() -> None:
    source = JsonLines(BytesIO(b'\n{"Ra": 0.4}\n\xef\xbb\xbf{}\n{"Ra": \xff}\n{}\n' + b" " * LONGEST_LINE))
    assert source.next("") == ReadingsRow({"Ra": 0.4}, "line 2 of the input")
    for what in ("line 3 of the input is", r"line 4 of the input: its byte 8 is not text in UTF-8"):
        with pytest.raises(GrindError, match=what):
            source.next("")
    assert source.next("") == ReadingsRow({}, "line 5 of the input")
    with pytest.raises(GrindError, match="line 6 of the input has no end"):
        source.next("")


def test_a_csv_is_read_with_commas_or_semicolons_and_while_it_grows(tmp_path: Path) -> None:
    path, wanted = tmp_path / "m.csv", [{"block": 1, "peak_power": 2400.5}, {"block": 2, "size_error": -1.5}]
    commas = "block,peak_power,size_error\n1,2400.5,\n\n2,,-1.5\n"
    assert rows_of(path, "\ufeff" + commas.replace(",", ";").replace(".", ",")) == wanted
    assert rows_of(path, commas.rstrip("\n")) == wanted
    assert rows_of(path, commas.rstrip("\n"), follow=True) == wanted[:1]
    assert rows_of(path, "block,peak", follow=True) == []


def test_closed_standard_input_is_refused(grind: Grind, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "stdin", None)
    status, out, err = grind("advise", plate_in(tmp_path), "--parts", 1, "--policy", "E12000D0")
    assert (status, out) == (2, "") and "standard input is closed" in err and "--measurements" in err

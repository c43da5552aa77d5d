"""Names and texts of users never control a terminal or a spreadsheet."""

import csv
import io
import shutil
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

import grind_env
from grind_env.files import FORMULA, csv_cell
from grind_env.message_text import printable
from tests.command import Grind

EXAMPLES = Path(grind_env.__file__).parent / "examples"
ESCAPE = "\x1b[31mRED\x1b]0\x07\x9b2J\x7f\u202e"
CONTROLS = {chr(code) for code in (*range(32), *range(127, 160), 0x202E, 0x2066, 0x2028)} - {"\n", "\t"}


@given(st.text())
def test_a_printed_text_has_no_controls(text: str) -> None:
    said = printable(text)
    assert not CONTROLS & set(said)
    assert printable(said) == said
    assert text != "".join(letter for letter in text if letter.isprintable()) or said == text


def test_line_ends_and_tabs_stay() -> None:
    assert printable("a\tb\nc\u00a0µ\x1b[1m") == "a\tb\nc\u00a0µ\\x1b[1m"


@pytest.fixture
def hostile(tmp_path: Path) -> Path:
    """A program whose name, comments, message and warnings hold escapes."""
    text = (EXAMPLES / "plate_g82.nc").read_text("utf-8")
    text = text.replace("(ROUGH:", f"(MSG,{ESCAPE})\n(ROUGH{ESCAPE}:").replace("E15000.", "E45000.")
    path = tmp_path / f"plate{ESCAPE}.nc"
    path.write_text(text, encoding="utf-8")
    shutil.copy(EXAMPLES / "plate_g82.toml", path.with_suffix(".toml"))
    return path


@pytest.mark.parametrize(
    "words",
    [
        ("check",),
        ("check", "--json"),
        ("check", "--strokes", "0"),
        ("trace",),
        ("run",),
        ("run", "--json"),
        ("run", "--plot", ESCAPE),
        ("run", "--record", ESCAPE),
        ("run", "--job", ESCAPE),
        ("report",),
        ("report", "-o", "no/such/folder.html"),
        ("play", "--policy", "E12000D0", "--no-window", "--program"),
        ("play", "--policy", ESCAPE, "--no-window", "--program"),
        ("evaluate", "--policy", "E12000D0", "--episodes", "2", "--program"),
    ],
)
def test_no_command_prints_control_characters_of_a_program(
    words: tuple[str, ...], hostile: Path, monkeypatch: pytest.MonkeyPatch, grind: Grind
) -> None:
    monkeypatch.chdir(hostile.parent)
    _, out, err = grind(*words, hostile)
    assert (out or err) and not CONTROLS & set(out + err)


@pytest.mark.parametrize("words", [("catalogue", "wheel", ESCAPE), ("catalogue", ESCAPE), ("init", ESCAPE)])
def test_no_argument_is_printed_raw(
    words: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, grind: Grind
) -> None:
    monkeypatch.chdir(tmp_path)
    _, out, err = grind(*words)
    assert not CONTROLS & set(out + err)


@given(st.text() | st.sampled_from(FORMULA).map(lambda sign: f'{sign}HYPERLINK("x")'))
def test_a_csv_cell_is_no_formula_and_keeps_its_text(text: str) -> None:
    cell = csv_cell(text)
    assert isinstance(cell, str) and not cell.startswith(FORMULA)
    assert cell in (text, f"'{text}")
    file = io.StringIO(newline="")
    csv.writer(file).writerow([cell, csv_cell(-1.5)])
    assert next(csv.reader(io.StringIO(file.getvalue(), newline=""))) == [cell, "-1.5"]

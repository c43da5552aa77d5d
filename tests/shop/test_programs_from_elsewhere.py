"""Programs as ten shops would write them, each with what follows for its strokes and dresses from the manual by hand.

They are in inches and millimetres, in capitals and lower case, in Latin-1 with CRLF, without N words or a last line
end, with loops by M98, WHILE and GOTO, with macros, in two planes, and with many ways to write a dress program.
"""

import json
import re
from pathlib import Path
from typing import Any

import pytest

from grind_env.control import read, read_file
from grind_env.files import read_bytes
from grind_env.machine.grind import grind
from grind_env.machine.job.file import load_job
from grind_env.shop.optimise.editing import text_of
from grind_env.shop.optimise.variation import variation_of
from grind_env.shop.report.run import block_rows
from grind_env.shop.search_options import options_of
from tests.examples import few
from tests.shop.test_optimise import status

pytestmark = pytest.mark.usefixtures("few_lots")

FOLDER = Path(__file__).with_name("programs_from_elsewhere")
CYCLES = {
    # code, strokes and dresses of each cycle: 1 + (picks + L) traverses in a G83, picks + 1 + L in a G82
    "column_machine": [("G83", 1 + (6 + 1) * 4, 1), ("G83", 1 + (5 + 1) * 4, 0)],
    "die_shoe_inch": [("G83", 1 + 8 * 7, 2), ("G83", 1 + (5 + 2) * 20, 1)],
    "fuehrungsleiste": [("G82.1", 9 + 1 + 1, 1 + 2), ("G82.1", 10 + 1 + 6, 1)],
    "guide_rail": [("G83", 1 + 4 * 3, 0), ("G82", 2 + 1 + 1, 1), ("G82", 2 + 1 + 1, 1)] * 2,
    "hand_plunge": [("G81", 19, 0)],
    "inch_macro": [("G82", 4 + 1 + 2, 1), ("G82", 4 + 1 + 2, 1), ("G82", 5 + 1 + 2, 0)],
    "magnet_plate": [("G83.1", 1 + 5 * 9, 1 + 1), ("G83", 1 + 3 * 16, 0), ("G83.1", 1 + (2 + 1) * 41, 1)],
    "plate_goto": [("G82", 5 + 1, 1)] * 3 + [("G82", 5 + 1 + 4, 0)],
    "step_grind": [("G82", 5 + 1 + 1, 1)] * 4 + [("G82", 3 + 1 + 4, 0)],  # J-.0025 is cut to .002 mm: three picks
    "three_steps": [("G83", 1 + 5 * 4, 1)] * 3 + [("G83", 1 + (2 + 1) * 7, 0)],
}
VARIED = {
    "column_machine": {9: "ED", 10: "E"},
    "die_shoe_inch": {12: "ED", 16: "ED"},
    "fuehrungsleiste": {13: "ED", 15: "E"},
    "guide_rail": {19: "ED", 26: "ED"},
    "hand_plunge": {8: "E"},
    "magnet_plate": {14: "ED", 17: "E", 20: "E"},
    "step_grind": {19: "D"},
    "three_steps": {18: "ED", 24: "E"},
}
"""The E and D words that are there as numbers, by line."""
COMMENT = re.compile(rb" ?\([^()]*\)")


@pytest.mark.parametrize("name", CYCLES)
def test_it_is_checked_and_ground_as_its_shop_expects(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    path = FOLDER / f"{name}.nc"
    assert status("check", path, "--job", path.with_suffix(".toml"), "--json") == 0
    told: dict[str, Any] = json.loads(capsys.readouterr().out)
    assert [(cycle["code"], cycle["strokes"], cycle["dresses"]) for cycle in told["cycles"]] == CYCLES[name]
    assert told["errors"] == []
    if name == "guide_rail":  # calls its dress program by M98, too
        assert [warning.split(" runs ")[0] for warning in told["warnings"]] == [
            "guide_rail.nc:9: M98 P1510",
            "guide_rail.nc:18: M98 P1510",
        ]
    elif name == "step_grind":
        (warning,) = told["warnings"]
        assert "line 22: J-.0025 has more decimals than are read, and is taken for J-0.002" in warning
    else:
        assert told["warnings"] == []

    job = load_job(path.with_suffix(".toml"))
    record = grind(read_file(path), job)
    assert record.parts["survival"].min() > 0.99
    assert len(record.dresses) == sum(dresses for _, _, dresses in CYCLES[name])
    assert record.parts["S"] == pytest.approx(job.part.stock, abs=0.01)


@pytest.mark.usefixtures("nothing_compiled")
@pytest.mark.parametrize("name", few(VARIED))
def test_other_words_leave_every_other_byte(name: str) -> None:
    path = FOLDER / f"{name}.nc"
    text, job = text_of(read_bytes(path)), load_job(path.with_suffix(".toml"))
    found = variation_of(read_file(path), text, job, options_of(("E", "D"), untried=True), 1, 1)
    assert {(each.place, each.name) for each in found.choices.variables}
    new = found.with_words((0,) * len(found.counts)).bytes()
    old = path.read_bytes()
    assert old.count(b"\r\n") == new.count(b"\r\n") and old.endswith(b"\n") == new.endswith(b"\n")
    before, after = old.split(b"\n"), new.split(b"\n")
    changed = {k + 1 for k, lines in enumerate(zip(before, after, strict=True)) if lines[0] != lines[1]}
    assert changed == set(VARIED[name])
    for line in changed:
        one, other = (re.findall(rb"[A-Za-z][^A-Za-z]*", COMMENT.sub(b"", each[line - 1])) for each in (before, after))
        words = {chr(a[0]).upper() for a, b in zip(one, other[: len(one)], strict=True) if a.strip() != b.strip()}
        assert words <= set(VARIED[name][line])
    assert grind(read(new.decode("latin-1")), job).parts["survival"].size == grind(read_file(path), job).parts.size


@pytest.mark.parametrize(("name", "word"), [("plate_goto", "N120: E[#4*1000]"), ("inch_macro", "line 20: E#3")])
def test_words_that_are_no_numbers_are_named(name: str, word: str, capfd: pytest.CaptureFixture[str]) -> None:
    assert status("optimise", FOLDER / f"{name}.nc", "--parts", "1", "--budget", "1s") == 2
    assert f"{word} is kept as it is; write a number there" in capfd.readouterr().err


def test_a_report_takes_what_a_run_takes(tmp_path: Path) -> None:
    path, page = FOLDER / "step_grind.nc", tmp_path / "page.html"
    requests = ["--dress-at", "35", "--set", "#500=0", "--max-blocks", "9000", "--interrupt", "9100@60"]
    assert status("run", path, *requests) == status("report", path, *requests, "-o", page) == 0
    assert "<td>operator</td>" in page.read_text(encoding="utf-8")
    assert status("report", path, "--set", "nothing", "-o", page) == 2


def test_a_report_shows_the_letters_of_latin_1(tmp_path: Path) -> None:
    page = tmp_path / "page.html"
    assert status("report", FOLDER / "fuehrungsleiste.nc", "-o", page) == 0
    assert "(FÜHRUNGSLEISTE OBERFLÄCHE SCHLEIFEN)" in page.read_text(encoding="utf-8")


def test_every_round_of_a_loop_is_a_run_of_its_block() -> None:
    path = FOLDER / "step_grind.nc"
    programs = read_file(path)
    rows = block_rows(grind(programs, load_job(path.with_suffix(".toml"))))
    assert [(row.line, row.cells["runs"], row.cells["strokes"]) for row in rows] == [(19, "4", "8"), (22, "1", "8")]

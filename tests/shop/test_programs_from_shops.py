"""Programs of many shops, with strokes and dresses counted by hand from the manual.

`programs_from_shops` has stations, macros, counters, loops of feed strokes and inches. A G82 makes one stroke, one more
for each pick, and L more. A G83 makes one stroke and `ceil(way / K)` more for each traverse. After an odd number of
strokes the table makes one more, and the next cycle begins there. `programs_from_elsewhere` has inches and millimetres,
capitals and lower case, Latin-1 with CRLF, texts without N words or a last line end, loops by M98, WHILE and GOTO,
macros, two planes, and many ways to write a dress program.
"""

import json
import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from grind_env.control import read, read_file
from grind_env.errors import GrindError
from grind_env.machine.grind import grind
from grind_env.machine.job import Job
from grind_env.machine.job.job_file import load_job
from grind_env.shop.optimise import search_problem
from grind_env.shop.optimise.result import Verdict
from grind_env.shop.python_api import optimise, sweep
from grind_env.shop.report.run_report import block_rows
from grind_env.shop.search_options import options_of
from tests.command import Grind, status
from tests.examples import few
from tests.shop.programs import KNOWN, varied

pytestmark = pytest.mark.usefixtures("few_lots")

FOLDER = Path(__file__).with_name("programs_from_shops")


class Shop(NamedTuple):
    """Strokes, dresses and parts of a program, counted by hand, and the variables given to it."""

    strokes: int
    dresses: int
    parts: int
    given: Mapping[int, float] = {}


SHOPS = {
    # eight plates of 8 + 1 and 5 + 1 + 2 strokes; every fourth is dressed
    "counter_500": Shop(8 * (9 + 1 + 8), 2, 8, {500: 0.0}),
    # M98 leads the wheel over the diamond but dresses nothing
    "creep_feed_lug": Shop(2, 0, 1),
    "macro_two_fixtures_inch": Shop(10 + 1 + 2 + 10 + 1 + 3, 2, 2),
    "maschinenmesser": Shop((5 + 4 + 2) * 2, 0, 1),
    "punch_block_inch": Shop(6 * 2 + 2 * 2, 0, 1),
    # twelve picks, alternately 6 and 4 um
    "row_of_plates": Shop(3 * (12 + 1 + 1 + 5 + 1 + 3), 0, 3),
    # four strokes beside each other, to and fro, in three layers
    "step_over_goto": Shop(3 * 4, 0, 1),
    "two_rows_g10": Shop(2 * (1 + (2 + 1) * 4 + 1 + 1 + (1 + 1 + 1) * 4), 2, 2),
    # J-.0025 is read as .002 mm: five picks
    "two_vices": Shop(2 * (6 + 1 + 5 + 1 + 2), 2, 2),
}
MADE_BETTER = ("counter_500", "macro_two_fixtures_inch", "maschinenmesser", "punch_block_inch", "row_of_plates")


def program_and_job(name: str) -> tuple[Path, Job]:
    path = FOLDER / f"{name}.nc"
    return path, replace(load_job(path.with_suffix(".toml")), variables=SHOPS[name].given)


@pytest.mark.parametrize("name", SHOPS)
def test_strokes_dresses_and_parts_match_the_hand_count(name: str) -> None:
    path, job = program_and_job(name)
    record, shop = grind(read_file(path), job), SHOPS[name]
    assert (record.strokes.size, len(record.dresses), record.parts.size) == shop[:3]
    assert not any(record.unjudged)
    stock = [each.part.stock for each in job.stations] or [job.part.stock] * shop.parts
    assert record.parts["S"] == pytest.approx(stock, rel=0.15, abs=0.015)  # the wheel deflects, and wears after a dress


def test_infeeds_beside_a_reciprocating_table_grind_the_stock() -> None:
    """The G81 has eight infeeds of 10 um; the number of strokes between them depends on time."""
    path = FOLDER / "g81_handwheel.nc"
    record = grind(read_file(path), load_job(path.with_suffix(".toml")))
    cutting = record.strokes["Z"]
    assert sorted({round(1000.0 * float(depth)) for depth in cutting if depth > 0.0})[-1] == 80
    assert record.parts["survival"][0] > 0.99


@pytest.mark.usefixtures("clock_of_looks")
@pytest.mark.parametrize("name", few(MADE_BETTER))
def test_promised_quantities_match_a_run_of_the_optimised_program(
    name: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    path, job = program_and_job(name)
    known = tmp_path / path.with_suffix(".toml").name
    known.write_text(path.with_suffix(".toml").read_text(encoding="utf-8") + KNOWN, encoding="utf-8")
    if name == "maschinenmesser":  # Ra is near its limit: only many lots tell which program keeps it
        monkeypatch.setattr(search_problem, "USUAL_RUNS", 50)
    found = optimise(path, known, parts=4, budget=6.0, variables=job.variables)
    assert found.verdict is Verdict.BETTER
    record = grind(read(found.after, path.name, path.parent), replace(job, variables=SHOPS[name].given))
    for quantity, column in (("cost", "total_cost"), ("seconds", "seconds"), ("Ra", "Ra")):
        assert found.quantity(quantity).expected[1] == pytest.approx(record.parts[column].mean(), rel=1e-9), quantity


def test_a_sweep_refuses_a_program_that_returns_to_a_station() -> None:
    path, _ = program_and_job("two_vices")
    with pytest.raises(GrindError, match=r"strokes come back to station vice 1; .* that is for grind run alone"):
        sweep(path, parts=2)


@pytest.mark.parametrize("command", ["optimise", "sweep", "advise"])
def test_a_refusal_of_several_parts_names_file_and_line(command: str, grind: Grind, tmp_path: Path) -> None:
    more = ["--state", tmp_path / "state.json"] if command == "advise" else []
    status, _, err = grind(command, FOLDER / "two_vices.nc", "--parts", 3, *more)
    assert status == 2 and err.startswith("grind: two_vices.nc:33: ")


def test_a_counter_without_a_value_names_the_remedy(grind: Grind) -> None:
    for command in (["run"], ["optimise"], ["sweep"], ["advise"]):
        status, _, err = grind(*command, FOLDER / "counter_500.nc")
        assert status == 2 and "counter_500.nc:7:6: #500 has no value" in err and "--set '#500=1'" in err
    assert json.loads(grind("run", FOLDER / "counter_500.nc", "--set", "#500=0", "--json")[1])["good_parts"] > 7.9


ELSEWHERE = Path(__file__).with_name("programs_from_elsewhere")
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
#: E and D words that are plain numbers, by line
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
COMMENT = re.compile(rb" ?\([^()]*\)")


@pytest.mark.parametrize("name", CYCLES)
def test_check_and_run_match_the_hand_count_of_each_cycle(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    path = ELSEWHERE / f"{name}.nc"
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
def test_varied_words_leave_all_other_bytes_unchanged(name: str) -> None:
    path = ELSEWHERE / f"{name}.nc"
    found = varied(path, options_of(("E", "D"), untried=True))
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
    runs = [grind(programs, found.job).parts.size for programs in (read(new.decode("latin-1")), found.programs)]
    assert runs[0] == runs[1]


@pytest.mark.parametrize(("name", "word"), [("plate_goto", "N120: E[#4*1000]"), ("inch_macro", "line 20: E#3")])
def test_optimise_names_words_that_are_not_numbers(name: str, word: str, capfd: pytest.CaptureFixture[str]) -> None:
    assert status("optimise", ELSEWHERE / f"{name}.nc", "--parts", "1", "--budget", "1s") == 2
    assert f"{word} is kept as it is; write a number there" in capfd.readouterr().err


def test_report_accepts_the_options_of_run(tmp_path: Path) -> None:
    path, page = ELSEWHERE / "step_grind.nc", tmp_path / "page.html"
    requests = ["--dress-at", "35", "--set", "#500=0", "--max-blocks", "9000", "--interrupt", "9100@60"]
    assert status("run", path, *requests) == status("report", path, *requests, "-o", page) == 0
    assert "<td>operator</td>" in page.read_text(encoding="utf-8")
    assert status("report", path, "--set", "nothing", "-o", page) == 2


def test_a_report_shows_the_letters_of_latin_1(tmp_path: Path) -> None:
    page = tmp_path / "page.html"
    assert status("report", ELSEWHERE / "fuehrungsleiste.nc", "-o", page) == 0
    assert "(FÜHRUNGSLEISTE OBERFLÄCHE SCHLEIFEN)" in page.read_text(encoding="utf-8")


def test_block_rows_count_every_iteration_of_a_loop() -> None:
    path = ELSEWHERE / "step_grind.nc"
    programs = read_file(path)
    rows = block_rows(grind(programs, load_job(path.with_suffix(".toml"))))
    assert [(row.line, row.cells["runs"], row.cells["strokes"]) for row in rows] == [(19, "4", "8"), (22, "1", "8")]

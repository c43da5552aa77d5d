"""The validation report: printed table, CSV file, page and exit status."""

import csv
import io
import re
import subprocess
import sys
from collections import Counter
from dataclasses import replace

import pytest
from rich.console import Console

from grind_env.pages.validation import validation_page
from grind_env.validation import CHECKS, GROUPS, Evidence, Row, is_expected, known_failures, unfit_uses, validate
from grind_env.validation import __main__ as module
from grind_env.validation.report import CSV_COLUMNS, WIDTH, print_report, totals, write_csv


def printed(rows: list[Row]) -> str:
    console = Console(file=io.StringIO(), width=400)
    print_report(rows, console)
    return console.file.getvalue()


@pytest.fixture(scope="module")
def rows() -> list[Row]:
    return validate()


@pytest.fixture(scope="module")
def page(rows: list[Row]) -> str:
    return validation_page(rows, "the caption")


def test_a_failing_row_is_printed_with_its_value_and_reason():
    good, lacking = CHECKS[0], CHECKS[1]
    rows = [Row(good, 5.0), Row(lacking, float("nan"), "there is no wheel 'x'")]
    text = printed(rows)
    assert good.what in text and "FAILS" in text and " 5 " in text
    assert "there is no wheel 'x'" in text
    assert totals(rows) == "2 rows: 0 pass, 0 known to fail, 2 unexpected"


def test_a_known_failure_is_printed_with_its_reason():
    name, why = next(iter(known_failures().items()))
    check = replace(CHECKS[0], name=name)
    text = printed([Row(check, 5.0)])
    assert "known to fail" in text
    assert why.split()[0] in text
    assert "passes, though known to fail" in printed([Row(check, 0.5)])


def test_the_exit_status_says_whether_all_results_are_expected(rows, monkeypatch, capsys):
    monkeypatch.setattr(module, "validate", lambda: rows)
    assert module.main([]) == (0 if all(map(is_expected, rows)) else 1)
    output = capsys.readouterr().out
    assert all(title in output for title in GROUPS.values())
    assert max(map(len, output.splitlines())) <= WIDTH == 120


def test_the_first_line_counts_the_rows_by_evidence(rows):
    (first, *_) = printed(rows).splitlines()
    counts = [int(number) for number in re.findall(r"\d+", first)]
    kinds = Counter(check.basis.evidence for check in CHECKS)
    assert counts == [len(CHECKS), *(kinds[kind] for kind in Evidence)]
    assert counts[0] == sum(counts[1:])
    assert len(first) <= WIDTH


def test_an_unexpected_result_gives_exit_status_1(monkeypatch, capsys):
    monkeypatch.setattr(module, "validate", lambda: [Row(CHECKS[0], 0.5)])
    assert module.main([]) == 0
    monkeypatch.setattr(module, "validate", lambda: [Row(CHECKS[0], 5.0)])
    assert module.main([]) == 1
    assert "1 unexpected" in capsys.readouterr().out
    passing = replace(CHECKS[0], name=next(iter(known_failures())))
    monkeypatch.setattr(module, "validate", lambda: [Row(passing, 0.5)])
    assert module.main([]) == 1


def test_the_rows_are_written_as_csv(rows, tmp_path):
    write_csv(rows, tmp_path / "rows.csv")
    with (tmp_path / "rows.csv").open(newline="", encoding="utf-8") as file:
        lines = list(csv.DictReader(file))
    assert [line["name"] for line in lines] == [row.check.name for row in rows]
    for line, row in zip(lines, rows, strict=True):
        assert tuple(line) == CSV_COLUMNS
        assert float(line["predicted"]) == pytest.approx(row.value, rel=1e-5)
        inside = float(line["low"] or "-inf") <= row.value <= float(line["high"] or "inf")
        assert inside == row.passed
        assert (line["verdict"] == "pass") == row.passed
        assert bool(line["outside limits"]) == bool(row.outside)
    assert {line["evidence"] for line in lines} == {"measured", "drawn", "remembered", "own"}
    assert [path.name for path in tmp_path.iterdir()] == ["rows.csv"]


def test_a_missing_number_is_an_empty_csv_cell(tmp_path):
    write_csv([Row(CHECKS[0], float("nan"), "there is no wheel 'x'")], tmp_path / "rows.csv")
    with (tmp_path / "rows.csv").open(newline="", encoding="utf-8") as file:
        (line,) = csv.DictReader(file)
    assert (line["predicted"], line["low"], line["verdict"]) == ("", "", "FAILS")
    assert line["reason"] == "there is no wheel 'x'"


def test_an_unwritable_csv_path_is_refused_before_the_work():
    command = [sys.executable, "-m", "grind_env.validation", "--csv", "/nowhere/rows.csv"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == "validation: /nowhere/rows.csv: there is no folder /nowhere; make it first\n"


def test_the_page_lists_every_row_known_failure_and_unfit_use(page):
    assert all(check.what.replace("|", "\\|") in page for check in CHECKS)
    assert all(f"{use}: {why}" in page for use, why in unfit_uses().items())
    assert all(why in page for why in known_failures().values())
    assert "(validation.png)\n\nthe caption" in page
    assert re.search(r"temperature limit.*scrap", page, re.DOTALL)


@pytest.mark.parametrize("use", ["Ti-6Al-4V", "absolute Ra", "Form and corner wear", "Chatter", "Creep feed"])
def test_the_unfit_uses_include(use):
    assert any(use in name for name in unfit_uses())


def test_the_page_marks_rows_outside_the_catalogue(page):
    mark = "; outside the catalogue: wheel speed 80 m/s (sg60j: at most 35)"
    assert len([line for line in page.splitlines() if mark in line]) == 4
    assert "](validation.csv)" in page

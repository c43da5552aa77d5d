"""What is printed, written and returned."""

import io
import re
import subprocess
import sys
from dataclasses import replace

import pytest
from rich.console import Console

from grind_env.pages.exponents import plot_exponents
from grind_env.pages.validation import validation_page
from grind_env.process.catalogue import load_catalogue
from grind_env.validation import (
    CHECKS,
    GROUPS,
    Band,
    Rig,
    Row,
    is_as_known,
    known_failures,
    row_of,
    unfit_uses,
    validate,
)
from grind_env.validation import __main__ as module
from grind_env.validation.neighbours import Step, neighbours
from grind_env.validation.report import comparison, print_report, totals
from grind_env.validation.valve_alloys import Prediction, predictions


def printed(rows: list[Row]) -> str:
    console = Console(file=io.StringIO(), width=400)
    print_report(rows, [], [], console)
    return console.file.getvalue()


@pytest.fixture(scope="module")
def page() -> str:
    rig = Rig(load_catalogue())
    steps = [Step("10 mm wide", (Row(CHECKS[0], 5.0),)), Step("40 mm wide", ())]
    return validation_page(validate(rig.catalogue), predictions(rig), steps, "validation.png")


def test_a_row_that_fails_is_printed_with_its_number_and_its_reason():
    good, lacking = CHECKS[0], CHECKS[1]
    rows = [Row(good, 5.0), Row(lacking, float("nan"), "there is no wheel 'x'")]
    text = printed(rows)
    assert good.what in text and "FAILS" in text and " 5 " in text
    assert "there is no wheel 'x'" in text
    assert totals(rows) == "2 rows: 0 pass, 0 known to fail, 2 not as known"


def test_a_known_failure_is_printed_with_its_reason():
    name, why = next(iter(known_failures().items()))
    check = replace(CHECKS[0], name=name)
    text = printed([Row(check, 5.0)])
    assert "known to fail" in text
    assert why.split()[0] in text
    assert "passes, though known to fail" in printed([Row(check, 0.5)])


def test_the_exit_status_says_whether_all_is_as_known():
    command = [sys.executable, "-m", "grind_env.validation"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == (0 if all(map(is_as_known, validate())) else 1), done.stderr
    assert all(title in done.stdout for title in GROUPS.values())


def test_a_row_that_fails_gives_exit_status_1(monkeypatch, capsys):
    monkeypatch.setattr(module, "predictions", lambda rig: [])
    monkeypatch.setattr(module, "neighbours", lambda catalogue, rows: [])
    monkeypatch.setattr(module, "validate", lambda catalogue: [Row(CHECKS[0], 0.5)])
    assert module.main() == 0
    monkeypatch.setattr(module, "validate", lambda catalogue: [Row(CHECKS[0], 5.0)])
    assert module.main() == 1
    assert "1 not as known" in capsys.readouterr().out


def test_the_page_has_every_row_and_what_the_model_must_not_be_used_for(page):
    assert all(check.what.replace("|", "\\|") in page for check in CHECKS)
    assert all(f"{use}: {why}" in page for use, why in unfit_uses().items())
    assert all(why in page for why in known_failures().values())
    assert "(validation.png)" in page
    assert re.search(r"temperature limit.*scrap", page, re.DOTALL)


@pytest.mark.parametrize("use", ["Ti-6Al-4V", "absolute Ra", "Form and corner wear", "Chatter", "Creep feed"])
def test_unfit_uses_name(use):
    assert any(use in name for name in unfit_uses())


def test_each_alloy_is_predicted_from_the_other():
    found = predictions(Rig(load_catalogue()))
    assert len(found) == 12
    for each in found:
        assert each.power_law > 0.0 and each.level > 0.0
    # wear of alumina is nearly in proportion to the volume in both alloys, and not to be had from a level
    wear = [each for each in found if each.wheel.startswith("3NQ") and each.response == "wear"]
    assert all(each.power_law < 0.7 * each.level for each in wear)


def test_the_page_says_what_fails_a_step_away(page):
    assert f"| 10 mm wide | {CHECKS[0].name} 5 ({CHECKS[0].band}) |" in page
    assert "| 40 mm wide | - |" in page


def test_a_step_away_takes_the_numbers_anew():
    catalogue = load_catalogue()
    check = next(check for check in CHECKS if check.name == "threshold force")
    value = row_of(check, Rig(catalogue)).value
    narrow = replace(check, band=Band(value, value))  # no more than the number itself, which few steps leave as it is
    steps = neighbours(catalogue, [row_of(narrow, Rig(catalogue))])
    moved = {step.change: step.failing[0].value for step in steps if step.failing}
    assert "10 mm wide" in moved or "wheel 240 mm" in moved
    assert all(other != value for other in moved.values())
    assert neighbours(catalogue, [Row(narrow, 2.0 * value)])[0].failing == ()  # it failed already


def test_the_picture_is_drawn(tmp_path):
    plot_exponents(validate(), tmp_path / "exponents.png")
    assert (tmp_path / "exponents.png").read_bytes().startswith(b"\x89PNG")


def test_the_sentence_on_the_power_law_counts():
    near = Prediction("3NQ 45 m/s", "wear", "INC751", 70.0, 30.0, 25.0, 20.0)
    assert "nearer than the power law in 1 of 2" in comparison([near, replace(near, model_fitted=35.0)])

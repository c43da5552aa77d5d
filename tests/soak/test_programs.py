"""Random programs of the soak, tests of its checks, and programs that once failed."""

import re
from collections import Counter
from dataclasses import replace
from typing import Any

import pytest

from grind_env.machine.grind import grind
from grind_env.machine.job import Job
from grind_env.machine.program_run import GrindingRun
from grind_env.machine.record import GrindingRecord
from tests.machine.harness import DRESS, job
from tests.soak import examine as ways
from tests.soak import programs
from tests.soak.examine import Examined, Finding, examine
from tests.soak.found import FOUND, PLAIN
from tests.soak.writer import Case, case

PROGRAMS, FEW = 150, 30
PATIENT = 300.0  #: processor time for one way of running a program, with compilation, s
WORDS = """M00 M01 M98 G04 G65 G81 G82 G83 G8[123][.]1 G17 G18 G19 G76 G77 G70 G91 G52 G5[4-9] WHILE GOTO Q L[1-9]"""
EVENTS = {"spindle slows", "stall", "air", "dresses", "several parts", "several stations ground"}


def test_a_few_random_programs_give_equal_results_in_all_ways_of_running() -> None:
    for seed in range(FEW):
        drawn = case(seed)
        assert examine(drawn, seconds=PATIENT).findings == [], f"seed {seed}\n{drawn.text}"


@pytest.mark.nightly
def test_random_programs_with_all_words_give_equal_results_in_all_ways_of_running() -> None:
    seen, texts = Counter[str](), ""
    for seed in range(PROGRAMS):
        drawn = case(seed)
        examined = examine(drawn, seconds=PATIENT)
        assert examined.findings == [], f"seed {seed}\n{drawn.text}"
        seen.update(examined.happened | {examined.end, examined.replay})
        texts += drawn.text
    assert seen["ground"] > 0.8 * PROGRAMS and seen["script"] > 0.25 * PROGRAMS
    assert EVENTS - set(seen) == {word for word in WORDS.split() if re.search(rf"\b{word}", texts) is None} == set()


def test_equal_seeds_give_equal_cases_and_other_seeds_give_other_programs() -> None:
    assert [case(seed) for seed in range(20)] == [case(seed) for seed in range(20)]
    assert len({case(seed).text for seed in range(200)}) == 200


# --- the checks find faults -------------------------------------------------------------------------


def examine_text(text: str, shop: Job | None = None) -> Examined:
    """Run a program with its dress program in all ways."""
    return examine(Case(0, text + DRESS, shop or job(stock=0.03, tolerance=30.0)), seconds=PATIENT)


def kinds(examined: Examined) -> set[str]:
    return {finding.kind for finding in examined.findings}


@pytest.mark.parametrize(
    ("name", "field", "expected"),
    [
        ("parts", "peak_power", "replay: part power"),
        ("parts", "rise", "replay: part temperature"),
        ("parts", "seconds", "replay: seconds"),
        ("parts", "total_cost", "replay: cost"),
        ("parts", "survival", "replay: good parts"),
        ("parts", "worn", "replay: worn"),
        ("strokes", "T", "run: strokes stroke by stroke: T"),
        ("strokes", "A", "run: strokes stroke by stroke: A"),
    ],
)
def test_the_checks_find_changed_results(name: str, field: str, expected: str, monkeypatch: pytest.MonkeyPatch) -> None:
    def other(*arguments: Any, **keywords: Any) -> GrindingRecord:
        record = grind(*arguments, **keywords)
        rows = getattr(record, name).copy()
        rows[field] *= 1.0 + 1e-8
        return replace(record, **{name: rows})

    assert kinds(examine_text(PLAIN)) == set()
    monkeypatch.setattr(ways, "grind", other)
    assert expected in kinds(examine_text(PLAIN))


def test_the_checks_find_crashes_and_hangs(monkeypatch: pytest.MonkeyPatch) -> None:
    def falls(run: GrindingRun) -> None:
        raise ZeroDivisionError

    monkeypatch.setattr(GrindingRun, "take_pending_part_off", falls)
    (found,) = examine_text(PLAIN).findings
    assert found.kind == "run: ZeroDivisionError in event_consumer.py:_begin" and "Traceback" in found.details

    def hangs(*arguments: Any, **keywords: Any) -> None:
        while True:
            pass

    monkeypatch.setattr(ways, "grind", hangs)
    (slow,) = examine(Case(0, PLAIN + DRESS, job()), seconds=1.0).findings
    assert slow.kind == "run: slow"


def test_a_failed_case_reports_its_program_job_and_finding(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        programs, "examine", lambda drawn: Examined(end="ground", findings=[Finding("odd", "1, not 2")])
    )
    tried = programs.attempt(7)
    assert (tried.end, tried.kind) == ("fallen", "odd")
    assert case(7).text in tried.details and "1, not 2" in tried.details and "[part]" in tried.details
    assert tried.sums["end: ground"] == 1


# --- programs that once failed ----------------------------------------------------------------------


@pytest.mark.parametrize(("text", "shop"), FOUND.values(), ids=list(FOUND))
def test_programs_that_once_failed_give_equal_results_in_all_ways_of_running(text: str, shop: Job) -> None:
    examined = examine_text(text, shop)
    assert examined.findings == [] and examined.end == "ground"

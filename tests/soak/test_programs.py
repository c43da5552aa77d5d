"""A short run, proof that it sees what it looks for, and programs that have shown faults."""

from collections import Counter
from dataclasses import replace
from typing import Any

import pytest

from grind_env.machine.grind import grind
from grind_env.machine.job import Job
from grind_env.machine.record import GrindingRecord
from grind_env.machine.run import GrindingRun
from tests.machine.harness import DRESS, job
from tests.soak import examine as ways
from tests.soak import programs
from tests.soak.examine import Examined, Finding, examine
from tests.soak.found import FOUND, PLAIN
from tests.soak.writer import Case, case

PROGRAMS, FEW = 150, 30
PATIENT = 300.0
"""s of processor time for a way, with what numba compiles on it."""
ASKED = {
    "M00 in a cycle",
    "M01 in a cycle",
    "M01",
    "dwell",
    "WHILE",
    "GOTO",
    ".1 form",
    "second block in a running cycle",
    "weak spindle",
    "spindle slows",
    "stall",
    "air",
    "wheel left above",
    "G81",
    "G82",
    "G83",
    "G17",
    "G18",
    "G19",
    "inch",
    "M98",
    "G65",
    "G91",
    "strokes by G01",
    "stations",
    "several stations ground",
    "G52",
    "stages",
    "part conditions",
    "several parts",
    "dresses",
    "redirected table",
    "strokes inside the part",
    "beside the part",
    "extreme E",
    "grooving by the wheel",
    "grooving by a tool",
    "wheel change",
    "soft machine",
    "Q",
    "L",
}


def test_a_few_random_programs_come_to_the_same_on_all_their_ways() -> None:
    for seed in range(FEW):
        drawn = case(seed)
        assert examine(drawn, seconds=PATIENT).findings == [], f"seed {seed}\n{drawn.text}"


@pytest.mark.nightly
def test_random_programs_come_to_the_same_on_all_their_ways() -> None:
    seen: Counter[str] = Counter()
    for seed in range(PROGRAMS):
        drawn = case(seed)
        examined = examine(drawn, seconds=PATIENT)
        assert examined.findings == [], f"seed {seed}\n{drawn.text}"
        seen.update(drawn.constructs | examined.happened | {examined.end, examined.replay})
    assert seen["ground"] > 0.8 * PROGRAMS and seen["script"] > 0.25 * PROGRAMS
    assert ASKED - set(seen) == set()


def test_a_case_follows_from_its_seed() -> None:
    assert [case(seed) for seed in range(20)] == [case(seed) for seed in range(20)]
    assert len({case(seed).text for seed in range(200)}) == 200


# --- it sees what it looks for ----------------------------------------------------------------------


def of(text: str, shop: Job | None = None) -> Examined:
    """What a program comes to on all its ways."""
    return examine(Case(0, text + DRESS, shop or job(stock=0.03, tolerance=30.0), frozenset()), seconds=PATIENT)


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
def test_differences_are_seen(name: str, field: str, expected: str, monkeypatch: pytest.MonkeyPatch) -> None:
    def other(*arguments: Any, **keywords: Any) -> GrindingRecord:
        record = grind(*arguments, **keywords)
        rows = getattr(record, name).copy()
        rows[field] *= 1.0 + 1e-8
        return replace(record, **{name: rows})

    assert kinds(of(PLAIN)) == set()
    monkeypatch.setattr(ways, "grind", other)
    assert expected in kinds(of(PLAIN))


def test_crashes_and_hangs_are_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    def falls(run: GrindingRun) -> None:
        raise ZeroDivisionError

    monkeypatch.setattr(GrindingRun, "let_part_go", falls)
    (found,) = of(PLAIN).findings
    assert found.kind == "run: ZeroDivisionError in events.py:_begin" and "Traceback" in found.details

    def hangs(*arguments: Any, **keywords: Any) -> None:
        while True:
            pass

    monkeypatch.setattr(ways, "grind", hangs)
    (slow,) = examine(Case(0, PLAIN + DRESS, job(), frozenset()), seconds=1.0).findings
    assert slow.kind == "run: slow"


def test_what_is_needed_to_repeat_a_program_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        programs, "examine", lambda drawn: Examined(end="ground", findings=[Finding("odd", "1, not 2")])
    )
    tried = programs.attempt(7)
    assert (tried.end, tried.kind) == ("fallen", "odd")
    assert case(7).text in tried.details and "1, not 2" in tried.details and "[part]" in tried.details
    assert tried.sums["end: ground"] == 1 and set(case(7).constructs) < set(tried.sums)


# --- what it has found ------------------------------------------------------------------------------


@pytest.mark.parametrize(("text", "shop"), FOUND.values(), ids=list(FOUND))
def test_what_has_fallen_stands(text: str, shop: Job) -> None:
    examined = of(text, shop)
    assert examined.findings == [] and examined.end == "ground"

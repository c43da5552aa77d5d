"""A short, repeatable run of the fuzzer, and proof that it sees what it looks for."""

from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import pytest

from grind_env.control import ControlError, Event, Execution
from tests.control import fuzz_examine
from tests.control.fuzz import growth, main, run_chunk
from tests.control.fuzz_cases import Case, case
from tests.control.fuzz_examine import Finding, examine, smallest

PROGRAMS = 2000
ENDS = """
done block-format missing-parameter block-budget program-not-found number-format out-of-range expression arc-geometry
axis-conflict dress-program unknown-word not-supported interrupt-program feed-mode missing-return interference
zero-stroke no-feedrate nesting zero-pick backwards-motion circular-departure-too-small
"""
LONG = "G00 X1.\nX2.\nG01 X3. F100.\nZ1. (HERE)\nX4. Y5.\nM30\n"


def test_random_programs() -> None:
    record = run_chunk(range(PROGRAMS))
    assert record["findings"] == []
    assert record["ends"]["done"] > PROGRAMS // 4
    assert set(ENDS.split()) <= set(record["ends"])


def test_a_case_follows_from_its_seed() -> None:
    assert [case(seed) for seed in range(50)] == [case(seed) for seed in range(50)]
    assert Counter(case(seed).text for seed in range(200)).most_common(1)[0][1] == 1


def broken_control(monkeypatch: pytest.MonkeyPatch, how: str) -> None:
    """A control that fails in some way as soon as an axis comes to Z1."""
    take = Execution.__next__

    def failing(self: Execution) -> Event:
        event = take(self)
        if getattr(event, "end", (0, 0, 0))[2] == 1.0:
            if how == "crash":
                raise ZeroDivisionError
            if how == "no place":
                raise ControlError("block-format", "somewhere")
            if how == "a motion has impossible numbers":
                object.__setattr__(event, "seconds", float("nan"))
            if how == "a motion does not begin where the one before ended":
                object.__setattr__(event, "start", (9.0, 9.0, 9.0))
            if how == "slow":
                while True:
                    pass
        return event

    monkeypatch.setattr(Execution, "__next__", failing)


def found(monkeypatch: pytest.MonkeyPatch, how: str) -> Finding:
    broken_control(monkeypatch, how)
    finding = examine(Case(LONG, {"block_delete": True}))[1]
    assert finding is not None
    return finding


PROMISES = [
    "no place",
    "a motion has impossible numbers",
    "a motion does not begin where the one before ended",
]


@pytest.mark.parametrize("how", PROMISES)
def test_broken_promises_are_seen_and_made_small(how: str, monkeypatch: pytest.MonkeyPatch) -> None:
    finding = smallest(found(monkeypatch, how))
    assert finding.signature == how
    assert "Z1." in finding.case.text and len(finding.case.text) < len("G01 X3. F100.\nZ1.") + 2
    assert finding.case.settings == {}


def test_crashes_are_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    finding = found(monkeypatch, "crash")
    assert finding.signature.startswith("ZeroDivisionError in ") and "Traceback" in finding.details


def test_slow_programs_are_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fuzz_examine, "SLOW", 0.1)
    assert found(monkeypatch, "slow").signature == "slow"


def test_more_strokes_than_the_budget_are_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    text = "G19 G81 X9. E9000.\nG04 P9.\nM30\n"
    assert examine(Case(text, {"block_budget": 20}))[0] == "block-budget"
    monkeypatch.setattr("grind_env.control.budget.Budget.spend", lambda self, place: None)
    monkeypatch.setattr("grind_env.control.budget.Budget.foresee", lambda self, count, place: None)
    finding = examine(Case(text, {"block_budget": 20}))[1]
    assert finding is not None and finding.signature == "more strokes than the budget"


def test_growth_counts_from_full_caches() -> None:
    def records(worker: int, memory: Iterator[float]) -> list[dict[str, float]]:
        return [{"worker": worker, "memory": mb} for mb in memory]

    steady = records(1, iter([10.0, 40.0, 50.0, 50.0, 50.0, 50.0, 50.0, 51.0]))
    leaking = records(2, (10.0 * count for count in range(20)))
    assert growth(steady + leaking + records(3, iter([1.0, 99.0]))) == {1: 1.0, 2: 140.0}


def test_a_run_goes_on_where_it_stopped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    results = tmp_path / "seed-5.jsonl"
    monkeypatch.setattr("tests.control.fuzz.CHUNK", 20)
    for programs, chunks in ((20, 1), (50, 3), (50, 3)):
        arguments = ["--programs", str(programs), "--seed", "5", "--jobs", "1", "--out", str(tmp_path)]
        monkeypatch.setattr("sys.argv", ["fuzz", *arguments])
        assert main() == 0
        assert len(results.read_text().splitlines()) == chunks

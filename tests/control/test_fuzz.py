"""A short, repeatable run of the random programs, and proof that the run detects faults."""

from collections import Counter

import pytest

from grind_env.control import ControlError, Event, Execution
from tests.control import fuzz_examine
from tests.control.fuzz_cases import Case
from tests.control.fuzz_examine import attempt, examine

PROGRAMS = 3000
ENDS = """
done block-format missing-parameter block-budget program-not-found number-format out-of-range expression arc-geometry
axis-conflict dress-program unknown-word not-supported interrupt-program feed-mode missing-return interference
zero-stroke no-feedrate nesting zero-pick backwards-motion circular-departure-too-small
"""
LONG = "G00 X1.\nX2.\nG01 X3. F100.\nZ1. (HERE)\nX4. Y5.\nM30\n"


def test_a_hundred_random_programs_break_no_promise() -> None:
    assert [seed for seed in range(100) if attempt(seed).end == "fallen"] == []


@pytest.mark.nightly
def test_thousands_of_random_programs_break_no_promise() -> None:
    tried = [attempt(seed) for seed in range(PROGRAMS)]
    assert [each for each in tried if each.end == "fallen"] == []
    ends = Counter(end for each in tried for end in each.sums)
    assert ends["done"] == sum(each.end == "accepted" for each in tried) > PROGRAMS // 4
    assert set(ENDS.split()) <= set(ends)


def break_control(monkeypatch: pytest.MonkeyPatch, how: str) -> None:
    """Make the control fail in the given way as soon as an axis reaches Z1."""
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


@pytest.mark.parametrize(
    ("how", "kind"),
    [
        ("no place", "no place"),
        ("a motion has impossible numbers", "a motion has impossible numbers"),
        ("a motion does not begin where the one before ended", "a motion does not begin where the one before ended"),
        ("crash", "ZeroDivisionError in "),
        ("slow", "TooSlowError"),
    ],
)
def test_broken_promises_crashes_and_slow_programs_are_detected(
    how: str, kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(fuzz_examine, "SLOW", 0.1 if how == "slow" else fuzz_examine.SLOW)
    break_control(monkeypatch, how)
    tried = examine(Case(LONG, {"block_delete": True}))
    assert tried.end == "fallen" and tried.kind.startswith(kind)
    assert LONG.rstrip() in tried.details and ("Traceback" in tried.details) == (how in ("crash", "slow"))

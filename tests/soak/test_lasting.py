"""What is said of one process that goes on for long."""

import math
import re

import pytest

from tests.soak.lasting import Round, faults

STEADY = [Round(steps=1000, seconds=1.0, megabytes=300.0, result=2.5)] * 12


def changed(**changes: list[float]) -> list[Round]:
    rows = [{"steps": 1000, "seconds": 1.0, "megabytes": 300.0, "result": 2.5} for _ in STEADY]
    for name, values in changes.items():
        for row, value in zip(rows, values, strict=True):
            row[name] = value
    return [Round(**row) for row in rows]


def test_what_stays_as_it_is_lasts() -> None:
    assert faults(STEADY) == []
    first_is_new = changed(megabytes=[100.0, *[300.0] * 11], seconds=[9.0, *[1.0] * 11])
    assert faults(first_is_new) == []


@pytest.mark.parametrize(
    ("name", "values", "said"),
    [
        ("megabytes", [300.0 + 4.0 * k for k in range(12)], "memory has grown by 28 MB"),
        ("seconds", [1.0 + 0.05 * k for k in range(12)], "steps/s have become"),
        ("result", [2.5] * 11 + [2.6], r"the same work has come to \[2\.5, 2\.6\]"),
        ("result", [math.nan] * 12, r"the same work has come to \[nan\]"),
    ],
)
def test_what_grows_slows_down_or_changes_does_not(name: str, values: list[float], said: str) -> None:
    (found,) = faults(changed(**{name: values}))
    assert re.search(said, found)

import csv
import json
from pathlib import Path
from typing import Any

import pytest

from grind_env.control import Control, ControlError, execute, read, record

FOLDER = Path(__file__).parent / "linuxcnc"
CASES = [case for case in json.loads((FOLDER / "index.json").read_text())["cases"] if not case["compensated"]]
TOLERANCE = 1e-4


def program(case: dict[str, Any]) -> str:
    text = (FOLDER / case["ngc"]).read_text()
    return text.replace("G20", "G70").replace("G21", "G71")


def rows(case: dict[str, Any]) -> list[dict[str, str]]:
    with (FOLDER / case["csv"]).open(newline="") as file:
        return list(csv.DictReader(file))


def moving(points: list[tuple[str, list[float]]]) -> list[bool]:
    """Which motions move, the start being the origin; an arc always does."""
    position = [0.0, 0.0, 0.0]
    flags = []
    for kind, end in points:
        flags.append(kind == "arc" or any(abs(a - b) > 1e-9 for a, b in zip(position, end, strict=True)))
        position = end
    return flags


@pytest.mark.parametrize("case", [c for c in CASES if c["mode"] == "exact"], ids=lambda case: case["id"])
def test_motions(case: dict[str, Any]) -> None:
    control = Control(rapid_feed=60_000.0)
    found = [found for event in execute(read(program(case)), control) if (found := record(event))]
    expected = rows(case)
    flags = moving([(row["kind"], [float(row[axis]) for axis in "xyz"]) for row in expected])
    expected = [row for row, moves in zip(expected, flags, strict=True) if moves]
    assert [motion["kind"] for motion in found] == [row["kind"] for row in expected]
    for motion, row in zip(found, expected, strict=True):
        assert motion["end"] == pytest.approx([float(row[axis]) for axis in "xyz"], abs=TOLERANCE)
        assert motion["block"] == int(row["n"])
        if row["kind"] == "arc":
            assert motion["rotation"] == int(row["rotation"])
            assert motion["plane"] == row["plane"]
            for coordinate, column in zip(motion["center"], ("cx", "cy", "cz"), strict=True):
                assert row[column] == "" or coordinate == pytest.approx(float(row[column]), abs=TOLERANCE)
        if case["compare_feed"] and row["feed"]:
            assert motion["feed"] == pytest.approx(float(row["feed"]), abs=TOLERANCE)


@pytest.mark.parametrize("case", [c for c in CASES if c["mode"] == "error"], ids=lambda case: case["id"])
def test_refused(case: dict[str, Any]) -> None:
    with pytest.raises(ControlError) as caught:
        list(execute(read(program(case))))
    assert caught.value.block == int(rows(case)[-1]["n"])


def test_every_case_is_compared() -> None:
    assert len(CASES) == 29
    assert {case["mode"] for case in CASES} == {"exact", "error"}

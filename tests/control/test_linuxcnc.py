"""Motions compared with those of LinuxCNC's interpreter, an independent implementation (linuxcnc/README.md)."""

import csv
import itertools
import json
import math
from pathlib import Path
from typing import Any

import pytest

from grind_env.control import Control, ControlError, execute, read, record
from tests.control.contours import FIRST_AND_SECOND, Run, Vector, runs

FOLDER = Path(__file__).parent / "linuxcnc"
CASES = json.loads((FOLDER / "index.json").read_text())["cases"]
TOLERANCE = 1e-4
MILLIMETRES = {"mm": 1.0, "inch": 25.4}


def of_mode(mode: str) -> list[dict[str, Any]]:
    return [case for case in CASES if case["mode"] == mode]


def program(case: dict[str, Any]) -> str:
    text = (FOLDER / case["ngc"]).read_text()
    return text.replace("G20", "G70").replace("G21", "G71")


def rows(case: dict[str, Any]) -> list[dict[str, str]]:
    with (FOLDER / case["csv"]).open(newline="") as file:
        return list(csv.DictReader(file))


def control(case: dict[str, Any]) -> Control:
    unit = MILLIMETRES[case["units"]]
    radii = {int(number): unit * radius for number, radius in case["radii"].items()}
    return Control(rapid_feed=60_000.0, radius=unit * case["radius"], radii=radii)


def found(case: dict[str, Any]) -> list[dict[str, Any]]:
    return [motion for event in execute(read(program(case)), control(case)) if (motion := record(event))]


def expected(case: dict[str, Any]) -> list[dict[str, Any]]:
    """Return the rows of a case as trace records, with their scope."""
    records = []
    for row in rows(case):
        centre = [float(row[column]) if row[column] else math.nan for column in ("cx", "cy", "cz")]
        records.append(
            {
                "kind": row["kind"],
                "end": [float(row[axis]) for axis in "xyz"],
                "center": centre,
                "rotation": int(row["rotation"] or 0),
                "plane": row["plane"],
                "feed": float(row["feed"]) if row["feed"] else None,
                "block": int(row["n"]),
                "scope": row["scope"],
            }
        )
    return records


@pytest.mark.parametrize("case", of_mode("exact"), ids=lambda case: case["id"])
def test_exact_cases_have_the_motions_of_linuxcnc(case: dict[str, Any]) -> None:
    ours, theirs = runs(found(case)), runs(expected(case))
    assert [run.kind for run in ours] == [run.kind for run in theirs]
    for mine, other in zip(ours, theirs, strict=True):
        assert mine.end == pytest.approx(other.end, abs=TOLERANCE)
        if mine.kind == "arc":
            assert (mine.rotation, mine.plane) == (other.rotation, other.plane)
            assert mine.centre == pytest.approx(other.centre, abs=TOLERANCE)
        if case["compare_feed"] and other.feed is not None and not (case["compensated"] and mine.kind == "arc"):
            assert mine.feed == pytest.approx(other.feed, abs=TOLERANCE)


@pytest.mark.parametrize("case", [c for c in of_mode("exact") if not c["compensated"]], ids=lambda case: case["id"])
def test_uncompensated_motions_carry_the_block_numbers_of_linuxcnc(case: dict[str, Any]) -> None:
    assert [motion["block"] for motion in found(case)] == [
        motion["block"] for motion, moves in zip(expected(case), moving(expected(case)), strict=True) if moves
    ]


def moving(records: list[dict[str, Any]]) -> list[bool]:
    position = [0.0, 0.0, 0.0]
    flags = []
    for motion in records:
        flags.append(motion["kind"] == "arc" or math.dist(position, motion["end"]) > 1e-9)
        position = motion["end"]
    return flags


@pytest.mark.parametrize("case", of_mode("contour"), ids=lambda case: case["id"])
def test_contours_follow_the_elements_of_linuxcnc_except_near_corners(case: dict[str, Any]) -> None:
    theirs = runs(expected(case))
    ours, radius = iter(runs(found(case))), abs(case["radius"])
    corners = [(run.plane, run.centre) for run in theirs if run.kind == "arc" and run.scope == "dialect"]
    shared = [run for run in theirs if run.scope == "shared"]
    slanted = [run for run in theirs if run.scope == "dialect" and run.kind != "arc"]
    assert shared and (corners or slanted)

    def near_a_corner(point: Vector) -> bool:
        """Return whether a point is near an outside corner or an angled entry or exit, where controls differ."""
        for plane, centre in corners:
            first, second = FIRST_AND_SECOND[plane]
            if radius - TOLERANCE <= math.dist((point[first], point[second]), centre) <= 2.0 * radius + TOLERANCE:
                return True
        return any(math.dist(point, other.end) <= 2.0 * radius for other in slanted)

    here: Run | None = None
    for element in shared:
        while here is None or not here.covers(element, TOLERANCE):
            here = next(ours, None)
            assert here is not None, f"{element} is not run through"
            if not any(here.covers(other, TOLERANCE) for other in shared):
                assert near_a_corner(here.end)
                assert here.start == theirs[0].end or all(near_a_corner(point) for point in here.points())
        for point in here.points():
            on_the_element = any(math.dist(point, near) <= longest_gap(element) for near in element.points())
            assert on_the_element or near_a_corner(point)
    for rest in ours:
        assert near_a_corner(rest.end) or any(math.dist(rest.end, other.end) <= TOLERANCE for other in slanted)


def longest_gap(run: Run) -> float:
    """Return a little more than half the longest distance between neighbouring points."""
    points = run.points()
    return 0.51 * max(math.dist(a, b) for a, b in itertools.pairwise(points)) + TOLERANCE


@pytest.mark.parametrize("case", of_mode("error"), ids=lambda case: case["id"])
def test_faulty_programs_are_refused_at_the_block_of_linuxcnc(case: dict[str, Any]) -> None:
    with pytest.raises(ControlError) as caught:
        list(execute(read(program(case)), control(case)))
    assert caught.value.block == int(rows(case)[-1]["n"])


def test_all_71_cases_and_three_modes_are_present() -> None:
    assert len(CASES) == 71
    assert {case["mode"] for case in CASES} == {"exact", "contour", "error"}

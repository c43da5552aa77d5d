"""A part with cuts that are not simulated stays unjudged in all commands."""

import json
import re
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from grind_env import report
from grind_env.control import Interrupt, read
from grind_env.envs.job.job_simulation import JobSimulation
from grind_env.errors import GrindError
from grind_env.machine.job import Job
from grind_env.machine.part.coverage import CELL
from grind_env.machine.part.unsimulated_cuts import UnjudgedError, list_lines
from grind_env.machine.record import GrindingRecord
from grind_env.machine.script.script import script_of
from tests.command import status
from tests.examples import examples
from tests.machine import harness
from tests.machine.harness import CYCLE, HEAD

AWAY = "G80\nG00 Y20.\n"
BACK = "G00 X-30. Z0\nG00 Y0\n"
#: feed moves that plunge over the part and rise over it again
SLOPES = "G80\n#1=0\nWHILE [#1 LT 6] DO 1\nG01 X230. Y-.06 F12000.\nG01 X-30. Y-.05\n#1=#1+1\nEND 1\nG00 Y20.\n"


def job(**part: Any) -> Job:
    return harness.job(**{"stock": 0.05, "tolerance": 9.0, **part})


def run(text: str, **part: Any) -> GrindingRecord:
    return harness.run(f"{HEAD}{text}M30\n", job(**part))


def lines_of(record: GrindingRecord) -> list[tuple[int, ...]]:
    """Return the lines that leave each part unjudged."""
    return [tuple(line for each in found for line in each.lines) for found in record.unjudged]


def test_feed_moves_that_plunge_over_the_part_leave_it_unjudged() -> None:
    found, plain = run(CYCLE + SLOPES), run(CYCLE + AWAY)
    (warning,) = found.warnings
    assert warning.startswith("test.nc:7: 12 feed moves outside a cycle ")
    assert "0.05099 to 0.05901 mm deep" in warning and "set the wheel to depth beside the part" in warning
    assert lines_of(found) == [(7, 8)] and found.unjudged[0][0].why in warning
    assert found.parts["survival"][0] == 0.0 and found.cost_per_good_part == float("inf")
    assert found.strokes.tobytes() == plain.strokes.tobytes()
    assert plain.parts["survival"][0] > 0.99 and lines_of(plain) == [()]


@pytest.mark.parametrize(
    ("moves", "depths"),
    [
        ("G01 X230. Y-.06 F500.", "0.05099 to 0.05901"),
        ("G01 Y-.052 F500.\nG01 X230. Y-.05", "0.0502 to 0.0518"),
        ("G01 X230. Y-.051 Z30. F500.", "0.0501 to 0.05067"),  # plunges and goes off the part
        ("G01 Y-.06 F500.\nX-30. Z-10.\nX230. Z10.", "0.06 mm deep"),  # leaves some of the width
        ("G01 Z-40. F500.\nY-.06\nX100.\nZ-2.5", "0.06 mm deep"),  # from the side
        ("G00 X100. Y1.\nG01 Y-.1 F500.", "0 to 0.1 mm deep"),
        ("G18 G02 X230. Z0 R2000. F500.", "0.05 mm deep"),
        ("G00 X100. Y1.\nG17 G02 X100. Y1. J-.55 F500.", "deep"),  # a full circle, which begins above the part
        ("G00 Y1.\nG00 X80.\nG17 G03 X120. Y1. R190. F500.", "deep"),  # only its middle lies below the surface
        ("G00 Y.2\nG00 X0\nG41 G17 G01 X10. Y-.06 F500.\nG40 G01 X210. Y2.", "deep"),
    ],
)
def test_a_cutting_feed_move_that_is_no_stroke_leaves_the_part_unjudged(moves: str, depths: str) -> None:
    found = run(f"{CYCLE}G80\nG00 X-30.\n{moves}\nG17 G40 G00 Y20.\n")
    assert found.parts["survival"][0] == 0.0
    (warning,) = found.warnings
    assert "which is not simulated" in warning and depths in warning


@pytest.mark.parametrize(
    "moves",
    [
        "G01 Y1. F300.",  # only lifts
        "G01 Y-.04 F500.\nG01 X230.",  # stays above the ground surface
        "G01 Y20. F500.\nG01 X100.\nG01 Y0",
        "G01 Z30. F500.\nG01 Y-.2\nG01 X230.",  # beside the part
        "G00 X230.",  # a rapid rubs, as before
        "G00 Y1.\nG18 G02 X230. Z0 R140. F500.",
        "M98 P9100",
    ],
)
def test_feed_moves_that_cut_nothing_change_no_verdict(moves: str) -> None:
    found = run(f"{CYCLE}G80\nG00 X-30.\n{moves}\nG00 Y20.\n")
    assert lines_of(found) == [()] and found.parts["survival"][0] > 0.99


def test_an_interrupt_that_cuts_leaves_the_part_unjudged() -> None:
    text = f"{HEAD}{CYCLE}G80\nG04 P1.\nG00 Y20.\nM30\nO7\nG90 G01 X{{}} F9000.\nX230.\nM99\n"
    asked = replace(job().control, interrupts=(Interrupt(7, at=14.5),))
    found, clear = (harness.run(text.format(words), job(), control=asked) for words in ("-30.", "-30. Y1."))
    assert lines_of(found) == [(10,)] and lines_of(clear) == [()]


def test_feed_moves_before_the_first_stroke_may_leave_the_part_unjudged() -> None:
    before = "G01 X230. Y-.02 F500.\nG00 Y20.\nG00 X-30.\nG00 Y0\n"
    assert lines_of(run(before + CYCLE + AWAY)) == [(3,)]
    assert lines_of(run(before.replace("Y-.02", "Y.02") + CYCLE + AWAY)) == [()]


def test_each_part_has_its_own_verdict() -> None:
    part = BACK + CYCLE + "{}" + AWAY
    found = run("M00\n".join(part.format(moves) for moves in ("", "G80\nG01 X230. Y-.06 F5000.\n", "")))
    assert [survival > 0.99 for survival in found.parts["survival"]] == [True, False, True]
    assert [bool(lines) for lines in lines_of(found)] == [False, True, False]


def test_a_part_ground_by_feed_moves_alone_is_counted() -> None:
    by_feed = BACK + "G01 X230. Y-.05 F500.\nG00 Y20.\n"
    found = run(f"{CYCLE}{AWAY}M00\n{by_feed}")
    assert lines_of(found) == [(), (9,)]
    assert [survival > 0.99 for survival in found.parts["survival"]] == [True, False]
    (warning,) = found.warnings
    assert warning.startswith("test.nc:9: a feed move outside a cycle takes the wheel over the part 0.005024 to ")
    assert len(run(f"{CYCLE}{AWAY}M00\n{by_feed.replace('Y-.05', 'Y1.')}").parts) == 1


STATION = AWAY + "G10 L2 P2 {}\nG55\n" + BACK + CYCLE + AWAY


@pytest.mark.parametrize("offset", ["X300.", "X-300.", "Z60.", "Y5.", "X0"])
def test_a_cycle_at_a_second_work_offset_leaves_the_part_unjudged(offset: str) -> None:
    found = run(CYCLE + STATION.format(offset))
    (warning,) = found.warnings
    assert warning.startswith("test.nc:10: ") and " mm deep, may be those of another part" in warning
    assert "so that this one is not judged; give every part a program and a job of its own" in warning
    assert lines_of(found) == [(10,)] and found.parts["survival"][0] == 0.0


def test_g81_at_a_second_work_offset_leaves_the_part_unjudged() -> None:
    by_hand = "G81 X230. I-30. E12000.\nG01 Z20. F200.\nG01 Z0\nG80\nG00 Y20.\n"  # across, at one depth
    found = run(CYCLE + AWAY + "G10 L2 P2 X300.\nG55\nG00 X-30. Z0\nG00 Y-.05\n" + by_hand)
    assert lines_of(found) == [(10,)]
    feeding = "G81 X230. I-30. E12000.\nG01 Y-.05 F1.\nG80\nG00 Y20.\n"
    assert lines_of(run(CYCLE + AWAY + "G10 L2 P2 X300.\nG55\n" + BACK + feeding)) == [(10,)]


def test_one_warning_names_the_lines_of_all_further_work_offsets() -> None:
    stations = "".join(STATION.format(offset) for offset in ("X300.", "X600."))
    found = run(CYCLE + stations)
    assert len(found.warnings) == 1 and lines_of(found) == [(10, 19)]
    down = "G00 Y.3\n" + CYCLE.replace("Y-.05", "Y.1")  # causes a warning, but is intended
    above, beside = run(down + STATION.format("X300.") + "G54\n" + BACK + CYCLE + AWAY).warnings
    assert "the lowest is at Y0.1" in above and "may be those of another part" in beside


def test_many_repeated_cycles_give_one_warning() -> None:
    again = "#1=0\nWHILE [#1 LT 100] DO 1\n" + BACK + CYCLE + "G80\nG00 Y20.\n#1=#1+1\nEND 1\n"
    found = run(CYCLE + AWAY + again)
    assert len(found.warnings) == 1 and lines_of(found) == [(10,)]
    assert list_lines(range(1, 4000, 3)) == "lines 1 to 3997"
    assert list_lines([7]) == "line 7" and list_lines([9, 3, 4, 5]) == "lines 3 to 5, 9"


@pytest.mark.parametrize(
    "text",
    [
        CYCLE + "G82 Y-.05 J-.005 L9 E9000.\n",  # sparks out once more
        CYCLE + "G80\nG00 Y1.\nG00 X-30.\nG00 Y-.045\n" + CYCLE.replace("J-.01", "J-.001") * 2,  # the last of its depth
        "G00 Y.3\n" + CYCLE.replace("Y-.05", "Y.1") + "G82 Y-.05 J-.01 L2\n",  # comes down on the part
        "G81 X230. I-30. E12000.\nG04 P3.\n" + CYCLE + "G80\nG00 Y1.\nG00 X-30.\nG81 X230. I-30. E9000.\nG04 P3.\n",
        "G00 Z-60.\nG81 X230. I-30. E12000.\nG04 P3.\nG80\nG00 X-30. Z0\n" + CYCLE,  # a table set going beside the part
    ],
)
def test_an_intended_cycle_in_the_air_changes_no_verdict(text: str) -> None:
    found = run(text + AWAY)
    assert lines_of(found) == [()] and found.parts["survival"][0] > 0.99


@given(
    st.lists(
        st.tuples(st.sampled_from([-30.0, 230.0, 100.0]), st.integers(-80, 60), st.sampled_from([0.0, 40.0, -40.0])),
        min_size=1,
        max_size=6,
    )
)
@examples(30)
def test_feed_moves_below_the_ground_surface_leave_the_part_unjudged(ways: list[tuple[float, int, float]]) -> None:
    """A part is judged while no feed move, except a stroke, goes below the ground surface.

    The surface is stored in cells. A move that goes below it in less than one cell may be found or not.
    """
    points = [(-30.0, 0.02, 0.0), *((x, 0.001 * y, z) for x, y, z in ways)]
    assume(all(start[1] != end[1] or end[1] > 0.0 for start, end in pairwise(points)))
    moves = "".join(f"G01 X{x} Y{y:.3f} Z{z} F900.\n" for x, y, z in points)
    found = run(f"{CYCLE}G80\nG00 Y1.\nG00 X-30.\n{moves}G00 Y20.\n")
    left = 0.05 - 0.001 * found.parts["size_error"][0]
    cuts = False
    for start, end in pairwise(points):
        sweeps = max(CELL, abs(end[0] - start[0]), abs(end[2] - start[2]))
        within_cell = abs(end[1] - start[1]) * CELL / sweeps
        for k in range(1001):
            x, y, z = (a + 0.001 * k * (b - a) for a, b in zip(start, end, strict=True))
            over = 0.0 < x < 200.0 and -25.0 < z < 20.0
            lifts = (start[0], start[2]) == (end[0], end[2]) and end[1] >= start[1]
            cuts |= over and not lifts and -y > left + within_cell
    if cuts:
        assert lines_of(found) != [()]
    elif min(y for _, y, _ in points) > -left:
        assert lines_of(found) == [()]


# ------------------------------------------------------------------------------------------------ commands


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """Write a program with feed moves that cut but are no strokes, and its job."""
    folder = tmp_path_factory.mktemp("unjudged")
    program, written = folder / "part.nc", folder / "part.toml"
    program.write_text(HEAD.replace("G19", "G19 S1910 M03 M08") + CYCLE + SLOPES + "M30\n" + harness.DRESS)
    written.write_text(
        '[part]\nmaterial = "aisi_52100"\nlength = 200\nwidth = 20\nheight = 20\n'
        "stock = 0.05\ntolerance = 9\nscrap_cost = 40\n"
    )
    return program, written


SENTENCE = re.compile(
    r"part\.nc:7: 12 feed moves outside a cycle .*\(lines 7, 8\).* straight along the table from there"
)


def test_run_and_check_report_an_unjudged_part(files: tuple[Path, Path], capsys: pytest.CaptureFixture[str]) -> None:
    program, written = files
    assert status("run", program, "--json") == 1
    data = json.loads(capsys.readouterr().out)
    (part,) = data["parts"]
    assert part["beyond"] == ["not judged (lines 7, 8)"] and part["survival"] == data["good_parts"] == 0.0
    assert SENTENCE.search(data["warnings"][0]) and data["reasons"]["not judged (lines 7, 8)"] in data["warnings"][0]
    assert status("run", program) == 1
    out = capsys.readouterr().out
    assert "1 part, not judged; " in out and ", no good part" in out and "good with" not in out
    assert "not judged (lines 7, 8): part 1\n" in out and SENTENCE.search(out)
    assert status("check", program, "--job", written, "--json") == 0
    assert SENTENCE.search(json.loads(capsys.readouterr().out)["warnings"][0])
    record = harness.run(f"{HEAD}{CYCLE}{SLOPES}M30\n", job())
    assert "not judged (lines 7, 8): part 1" in record._repr_html_()


def test_a_report_shows_an_unjudged_part(files: tuple[Path, Path], tmp_path: Path) -> None:
    page = report(files[0], output=tmp_path / "part.html").read_text("utf-8")
    assert "The part is not judged." in page and "not judged (lines 7, 8): part 1" in page
    assert "within the limits" not in page


def test_optimise_sweep_and_advise_reject_unsimulated_cuts(
    files: tuple[Path, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    program, _ = files
    for asked in (["optimise", program], ["sweep", program], ["advise", program, "--state", tmp_path / "state.json"]):
        assert status(*asked) == 2
        assert SENTENCE.search(capsys.readouterr().err), asked


def test_environments_and_scripts_reject_unsimulated_cuts() -> None:
    text = f"{HEAD}{CYCLE}{SLOPES}M30\n{harness.DRESS}"
    by_wheel = text.replace(SLOPES, f"#2=#5041\n{SLOPES}").replace("DO 1\n", "DO 1\n#3=#2\n")  # without a script
    beside = f"{HEAD.replace('Z0', 'Z-30.')}{CYCLE}{AWAY}M30\n{harness.DRESS}"
    for each in (text, by_wheel, beside):
        with pytest.raises(UnjudgedError):
            JobSimulation(read(each, "part.nc"), job(), 0.0)
        with pytest.raises(UnjudgedError):
            script_of(read(each, "part.nc"), job())
    assert issubclass(UnjudgedError, GrindError)

import dataclasses
import re
from dataclasses import replace
from typing import Any

import pytest

from grind_env.control import Control
from grind_env.render.limit_causes import explain
from tests.machine.harness import CATALOGUE, CYCLE, HEAD, job, run


def test_an_inch_program_gets_the_sufficient_feed_in_inches() -> None:
    slow = "G70 G94 G90 G19\nG00 X-1.2 Y0 Z0\nG82 X9.1 I-1.2 Y-.002 J-.0004 F.02 E470.\nM30\n"
    (warning,) = run(slow, job()).warnings
    found = re.search(r"its picks at F0.02 inch/min take .*; F([.\d]+) would do", warning)
    assert found is not None
    assert run(slow.replace("F.02", f"F{found[1]}"), job()).warnings == ()


def test_the_named_feed_is_the_least_sufficient_one() -> None:
    text = HEAD + CYCLE.replace("J-.01", "J-.5").replace("Y-.05", "Y-2.") + "M30\n"
    out_of_reach = job(surface=-10.0)
    found = re.search(r"; F(\d+) would do", run(text.replace("F60.", "F1."), out_of_reach).warnings[0])
    assert found is not None
    enough = int(found[1])
    for feed, slow in ((enough, False), (enough - 1, True)):
        warnings = run(text.replace("F60.", f"F{feed}."), out_of_reach).warnings
        assert any("would do" in warning for warning in warnings) is slow


def test_a_pick_warns_if_no_feed_finishes_it_in_time() -> None:
    control = Control(acceleration=10.0, reversal_dwell=0.0)
    text = HEAD + "G82 X30. I-30. Y-500. J-250. F6000. E60000. P9100\nM30\n"
    warnings = run(text, job(length=20.0, surface=-600.0), control=control).warnings
    assert any("no F would do" in warning for warning in warnings)


def test_a_slow_pick_before_a_dress_causes_no_warning() -> None:
    text = HEAD + "G82 X230. I-30. Y-.01 J-.01 F.3 E12000. P9100 D1\nM30\n"
    assert run(text, job()).warnings == ()


def test_a_cut_outside_the_limits_of_the_model_warns_once() -> None:
    record = run(HEAD + re.sub(r"E[0-9]+", "E2000", CYCLE) + "M30\n", job())
    assert record.warnings == (
        "test.nc:3: a stroke cuts at E2000 mm/min; the process model holds from 3000 to 40000 mm/min",
    )
    strong = dataclasses.replace(CATALOGUE.machine("default"), power_limit=75_000.0)
    deep = HEAD + CYCLE.replace("Y-.05 J-.01", "Y-.25 J-.25") + "M30\n"
    (warning,) = run(deep, job(setup={"machine": strong})).warnings
    assert re.fullmatch(r"test\.nc:3: a stroke cuts 0\.\d\d mm deep; the process model holds up to 0\.1 mm", warning)


def warnings_of(text: str, **part: Any) -> tuple[str, ...]:
    return run(HEAD + text + "M30\n", job(**part)).warnings


LIFT = "G80\nG00 Y20.\n"


def test_a_move_that_crosses_the_part_below_its_surface_warns() -> None:
    assert len(warnings_of("G00 Y-.03\nG00 X230.\n" + CYCLE)) == 1
    # first half-way down at the edge of the part, then clear of it before it is below the surface
    assert len(warnings_of("G00 X100. Y-.03\nG00 Y20.\nG00 X-30.\nG00 Y0\n" + CYCLE)) == 1
    assert warnings_of("G00 X100. Y1.\nG00 X-30. Y-.03\n" + CYCLE) == ()


@pytest.mark.parametrize("move", ["G00 X-6.", "G00 X206.", "G00 Z45. X100.", "G00 Z-50. X100.", "G00 Y.1\nG00 X100."])
def test_a_move_beside_or_above_the_part_causes_no_warning(move: str) -> None:
    lines = ["G00 Y20.", *move.split("\n")[:1], "G00 Y-.1" if "Y" not in move else move.split("\n")[1], "G00 Y20."]
    assert warnings_of("\n".join([*lines, "G00 X-30. Z0", "G00 Y0", CYCLE])) == ()


def test_the_first_move_of_a_program_or_part_causes_no_warning() -> None:
    assert run(HEAD.replace("X-30. Y0 Z0", "X-30. Y-.02") + CYCLE + "M30\n", job()).warnings == ()
    second = LIFT + "G00 X100. Y1.\nM00\nG00 X-30. Y-.02\n" + CYCLE
    assert warnings_of(CYCLE + second) == ()


def test_moves_over_a_ground_surface_warn_only_below_it() -> None:
    assert warnings_of(CYCLE + "G80\nG00 X230.\nG00 X-30.\n") == ()
    assert len(warnings_of(CYCLE + "G80\nG00 X-30.\nG00 Y-.06\nG00 X230.\n")) == 1


@pytest.mark.parametrize(
    ("cycle", "width", "move", "into"),
    [
        # along the part, ground up to X100 only
        (CYCLE.replace("X230.", "X100."), 20.0, "G00 X230.", True),
        (CYCLE.replace("X230.", "X100."), 20.0, "G00 X100.", False),
        (CYCLE.replace("X230.", "X100."), 20.0, "G00 X230. Y20.", False),
        # across a part of 80 mm, ground over its first 25 mm only
        (CYCLE, 80.0, "G00 X100.\nG00 Z60.", True),
        (CYCLE, 80.0, "G00 X100.\nG00 Z-30.", False),
        (CYCLE, 80.0, "G00 X100.\nG00 Z60. Y20.", False),
    ],
)
def test_a_move_through_an_unground_area_warns(cycle: str, width: float, move: str, into: bool) -> None:
    text = cycle + f"G80\nG00 X-30.\n{move}\nG00 Y20.\nG00 X-30. Z0\nG00 Y0\n" + CYCLE
    found = [warning for warning in warnings_of(text, width=width) if "into the part" in warning]
    assert len(found) == into
    assert all("takes the wheel 0.05 mm into the part" in warning for warning in found)


@pytest.mark.parametrize("turn", [150.0, 150.3, 150.5, 150.9])
def test_the_wheel_may_come_down_where_strokes_have_turned(turn: float) -> None:
    down = f"G80\nG00 Y20.\nG00 X{{}}\nG00 Y-.05\nG00 X0\nG00 Y20.\nG00 X-30.\nG00 Y0\n{CYCLE}"
    cycle = CYCLE.replace("X230.", f"X{turn}")
    for x, crashes in ((turn, 0), (turn + 2.0, 1)):
        found = [warning for warning in warnings_of(cycle + down.format(x)) if "into the part" in warning]
        assert len(found) == crashes


def test_an_infeed_on_a_reciprocating_table_causes_no_warning() -> None:
    assert warnings_of("G81 X230. I-30. E12000.\nG01 Y-.1 F1.\nG04 P3.\nG80\n") == ()
    # a short infeed, within a stroke
    assert warnings_of("G81 X230. I-30. E12000.\nG04 P.5\nG01 Y-.01 F60.\nG04 P3.\nG80\n") == ()


@pytest.mark.parametrize(
    ("head", "part", "words"),
    [
        ("Y.5", {}, "the lowest is at Y0.45, the surface at Y0; give a depth below it"),
        ("Y0", {"start": 240.0}, "which lies from X240 to X440; the wheel passes from X-30 to X230"),
        ("Y0", {"across": 26.0}, "which lies from Z26 to Z46; the wheel passes from Z0 to Z25"),
    ],
)
def test_a_cycle_that_cuts_air_warns_once(head: str, part: dict[str, float], words: str) -> None:
    depth = "Y.45" if head == "Y.5" else "Y-.05"
    text = HEAD.replace("Y0", head) + CYCLE.replace("Y-.05", depth) + "M30\n"
    (warning,) = run(text, job(tolerance=9.0, **part) if head == "Y.5" else job(**part)).warnings
    assert warning.startswith("test.nc:3: no stroke of this cycle touches the part")
    assert words in warning


def test_a_repeated_cycle_without_m00_warns_of_nothing_to_grind() -> None:
    part = "G00 X-30. Y0\n" + CYCLE + LIFT
    text = HEAD + "M98 P500 L3\nM30\nO500\n" + part + "{}M99\n"
    (warning,) = run(text.format(""), job()).warnings
    assert warning.startswith("test.nc:7: this cycle finds nothing to grind, for the part has been ground as deep as ")
    assert "Y-0.05 before; go deeper, or put M00 before it" in warning
    assert run(text.format("M00\n"), job()).warnings == ()


def test_a_program_that_leaves_stock_warns() -> None:
    (warning,) = warnings_of(CYCLE, tolerance=9.0)
    assert warning.startswith("test.nc:3: the part is ground to a depth of 0.05 mm, but has 0.1 mm of stock")
    assert warnings_of(CYCLE, stock=0.055, tolerance=9.0) == ()
    assert warnings_of(CYCLE) == ()  # the job has no tolerance


def test_a_table_started_before_a_cycle_does_not_cut_air() -> None:
    table = "G81 X230. I-30. E12000.\nG04 P3.\n"
    assert warnings_of(table + CYCLE) == ()
    assert warnings_of(CYCLE + "G80\nG00 X-30.\n" + table + "G80\n") == ()
    (warning,) = warnings_of(table)
    assert warning.startswith("test.nc:3: no stroke of this cycle touches the part: the lowest is at Y0")
    (warning,) = warnings_of("G00 Y1.\n" + table + CYCLE.replace("Y-.05", "Y.95"))
    assert warning.startswith("test.nc:6: no stroke of this cycle touches the part")
    per_part = table + CYCLE + "G80\nG00 Y20.\nM00\nG00 X-30.\nG00 Y0\n"
    (warning,) = warnings_of(per_part + table)
    assert warning.startswith("test.nc:11: ")


def test_a_dress_program_called_as_a_subprogram_dresses_nothing() -> None:
    text = HEAD + "M98 P9100\nG00 X-30. Z0\nG00 Y0\n" + CYCLE + "M30\n"
    record = run(text, job())
    (warning,) = record.warnings
    assert warning.startswith("test.nc:3: M98 P9100 runs the motions of the dress program and dresses nothing; ")
    assert record.dresses.size == 0
    # it moves as a dress program, although no cycle names it
    unnamed = text.replace("P9100\nM30", "\nM30")
    assert run(unnamed, job()).warnings == (warning,)
    assert run(unnamed.replace("M98 P9100", "M98 P7") + "O7\nG00 Y20.\nM99\n", job()).warnings == ()
    assert run(text.replace("M98 P9100\n", ""), job()).warnings == ()
    # leading zeros do not matter
    assert len(run(text.replace("M98 P9100", "M098 P09100"), job()).warnings) == 1


def test_an_uncalled_dress_program_causes_no_warning() -> None:
    text = HEAD + CYCLE + "/M98 P9100\nM30\n"
    assert len(run(text, job()).warnings) == 1
    assert run(text, job(), control=Control(block_delete=True)).warnings == ()
    assert run(HEAD + CYCLE + "M30\nM98 P9100\n", job()).warnings == ()


def test_a_cycle_that_continues_another_causes_no_warning() -> None:
    assert warnings_of(CYCLE + "G82 Y-.05 J-.005 L4 E9000.\n") == ()  # sparks out once more
    assert warnings_of(CYCLE + "G82 Y-.055 J-.005 L4 E9000.\n") == ()
    assert warnings_of(CYCLE + "G80\nG00 Y0\nG00 X-30.\n" + CYCLE.replace("Y-.05", "Y-.06")) == ()


def test_advice_for_a_deep_feed_pass_is_about_its_depth_and_F() -> None:
    machine = replace(CATALOGUE.machine("default"), power_limit=2000.0)
    shop = job(stock=0.5, tolerance=20.0, roughness_limit=0.1, setup={"machine": machine})
    record = run(f"{HEAD}G01 Y-0.5 F500.\nX230. F600.\nG00 Y20.\nM30\n", shop)
    said = {cause: explain(cause, [1], record) for cause in ("power", "rise", "roughness", "size")}
    assert said["power"].startswith("line 4: ") and said["power"].endswith("; go less deep or lower F")
    assert said["rise"].endswith("; go less deep or lower F, or dress before")
    assert said["roughness"].endswith("; dress finer, lower F, or add strokes at full depth")
    assert said["size"].endswith("; add strokes at full depth, or end with less deep ones")

"""Strokes by feed moves grind as strokes of a cycle do."""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grind_env.control import read
from grind_env.envs.job.job_simulation import JobSimulation
from grind_env.machine.grind import GrindingError, grind
from grind_env.machine.job import Job
from grind_env.machine.loops.stroke_totals import Tally
from grind_env.machine.record import STROKE_ROW, GrindingRecord
from grind_env.machine.script.script import script_of
from grind_env.machine.script.script_block import ScriptError
from tests.examples import examples
from tests.machine import harness
from tests.machine.harness import CYCLE, DRESS, HEAD, run
from tests.machine.test_replay import assert_replayed

AWAY = "G00 Y20.\n"
PLACED = ("part", "groove", "time", "line", "number")  #: columns for place and time of a stroke, not for its results


def job(*, dwell: float = 0.0, **values: Any) -> Job:
    """Return a job with a table that does not rest at its reversal points, as feed moves do not."""
    machine = replace(harness.TIMELESS["machine"], reversal_dwell=dwell)
    setup = {**harness.TIMELESS, "machine": machine}
    return harness.job(**{"stock": 0.05, "tolerance": 9.0, "setup": setup, **values})


def ground(text: str, shop: Job | None = None) -> GrindingRecord:
    return run(f"{HEAD}{text}{AWAY}M30\n", shop or job())


def assert_same_strokes(found: GrindingRecord, expected: GrindingRecord) -> None:
    """Assert equal bits of strokes, wheel and part, but for place and time of the strokes."""
    assert len(found.strokes) == len(expected.strokes)
    for name in STROKE_ROW.names or ():
        if name not in PLACED:
            assert found.strokes[name].tobytes() == expected.strokes[name].tobytes(), name
    for name in ("S", "taper", "unground", "Ra", "peak_power", "rise", "worn"):
        assert found.parts[name].tobytes() == expected.parts[name].tobytes(), name


def by_moves(strokes: Sequence[tuple[int, int]]) -> str:
    """Return feed moves to and fro for strokes, each a (further depth in um, F)."""
    lines = []
    for number, (deeper, feed) in enumerate(strokes):
        lines.append(f"G91 G01 Y-{0.001 * deeper:.3f} F500.\nG90 X{230 if number % 2 == 0 else -30}. F{feed}.\n")
    return "".join(lines)


some_feeds = st.integers(30, 300).map(lambda hundreds: 100 * hundreds)
some_strokes = st.lists(st.tuples(st.integers(0, 20), some_feeds), min_size=1, max_size=6)


def test_a_wheel_that_covers_the_part_may_go_across() -> None:
    oblique, straight = (ground(f"G00 Z-4.\nG01 Y-.01 F500.\nG01 X230. Z{z} F12000.\n") for z in ("-1.", "-4."))
    share = 260.0 / math.hypot(260.0, 3.0)
    assert oblique.strokes["E"] == pytest.approx(12000.0 * share) and straight.strokes["E"] == 12000.0
    assert oblique.strokes["b"] == 20.0 and oblique.unjudged == ((),)
    assert oblique.strokes["ae"] == pytest.approx(straight.strokes["ae"], rel=1e-3)
    leaving = ground("G00 Z-4.\nG01 Y-.01 F500.\nG01 X230. Z1. F12000.\n" + CYCLE)
    assert leaving.unjudged[0][0].lines == (5,)


def test_a_wheel_narrower_than_the_part_leaves_the_rest_unground() -> None:
    wide = job(width=40.0)
    one = ground("G01 Y-.01 F500.\nX230. F12000.\n", wide)
    both = ground("G01 Y-.01 F500.\nX230. F12000.\nZ15. F900.\nX-30. F12000.\n", wide)
    assert one.parts["unground"][0] == pytest.approx(15.0 / 40.0)
    assert both.parts["unground"][0] == 0.0 and both.strokes["b"].tolist() == [25.0, 15.0]


def test_a_stroke_that_ends_over_the_part_grinds_the_covered_length() -> None:
    short = ground("G01 Y-.01 F500.\nX100. F12000.\nG00 Y1.\n")
    cycle = ground("G01 Y-.01 F500.\nG81 X100. I-30. E12000.\nG04 P.01\nG80\nG00 Y1.\n")
    assert_same_strokes(short, cycle)
    assert short.strokes["Lw"] == 100.0 and short.parts["unground"] == 0.5
    assert "a stroke turns at X100, over the part" in short.warnings[0] and short.unjudged == ((),)


@pytest.mark.parametrize(
    ("text", "feed"),
    [
        ("G17\nG00 Z-30. X0 Y-2.5\nG01 X-.01 F500.\nG01 Z230. F12000.\nG00 X20.\n", 12000.0),
        ("G18\nG00 Y-30. Z0 X-2.5\nG01 Z-.01 F500.\nG01 Y230. F12000.\nG00 Z20.\n", 12000.0),
        ("G19 G70\nG00 X-1.2 Y0 Z-.1\nG01 Y-.0004 F20.\nG01 X9. F480.\nG00 Y1.\n", 480.0 * 25.4),
    ],
)
def test_the_plane_sets_the_axis_of_strokes(text: str, feed: float) -> None:
    found = run(f"G71 G94 G90\n{text}M30\n", job())
    assert found.strokes["Lw"].tolist() == [200.0] and found.strokes["E"][0] == pytest.approx(feed)
    assert found.unjudged == ((),)


def test_the_plane_of_the_first_cycle_also_holds_for_feed_moves_before_it() -> None:
    by_feed = "G01 Y-.01 F500.\nG01 X230. F12000.\nG00 Y20.\nG00 X-30.\nG00 Y0\n"
    late = run(f"G71 G94 G90\nG00 X-30. Y0 Z0\n{by_feed}G19 {CYCLE}G80\n{AWAY}M30\n", job())
    early = run(f"{HEAD}{by_feed}{CYCLE}G80\n{AWAY}M30\n", job())
    assert_same_strokes(late, early)
    assert late.strokes["number"].tolist() == [0, *range(1, 9)]


def test_a_program_without_a_stroke_along_the_table_is_rejected() -> None:
    with pytest.raises(GrindingError, match=r"feed moves grind that go straight along the axis across G17, G18 or G19"):
        run("G71 G94 G90\nG00 X-30. Y0 Z0\nG01 Y-.01 F500.\nG01 X230. F12000.\nM30\n", job())


def test_each_part_ground_by_feed_moves_alone_is_judged() -> None:
    part = "G00 X-30. Z0\nG00 Y0\n" + by_moves([(10, 12000)] * 5 + [(0, 12000)] * 3) + AWAY
    found = ground("M00\n".join([part] * 3))
    assert found.parts["strokes"].tolist() == [8] * 3 and found.unjudged == ((),) * 3
    assert (found.parts["survival"] > 0.99).all() and not found.warnings
    assert (np.diff(found.strokes["V"]) > 0.0).all()  # all parts share a wheel
    assert found.strokes["time"][0] == 20.0  # loading ends with the first stroke
    shallow = ground(part.replace("Y-0.010", "Y-0.000", 1))
    assert "the part is ground to a depth of 0.04 mm" in shallow.warnings[0]


def test_repeated_feed_moves_leave_the_part_unjudged() -> None:
    part = "G00 X-30. Z0\nG00 Y0\n" + by_moves([(10, 12000)] * 5) + AWAY
    again = ground(part * 2)
    assert len(again.unjudged[0]) == 1 and again.parts["survival"][0] == 0.0
    (warning,) = again.warnings
    assert "this feed move finds nothing to grind" in warning and "may be those of another part" in warning
    back = part.replace("X-30. F12000", "X-30. F9000") + "G00 X-30.\nG00 Y-.01\nG01 X230. F9000.\n" + AWAY
    assert ground(back).unjudged == ((),)  # a way back above the ground surface


@pytest.mark.parametrize(
    ("moves", "says"),
    [
        ("G01 Y-.01 F500.\nX230. F70000.\n", ["F60000 is more than the table", "lower F"]),
        ("G01 Y-2. F500.\nX230. F9000.\n", ["in a stroke the spindle stalls", "go less deep or lower F, or dress"]),
        ("G01 Y-.3 F500.\nX230. F9000.\n", ["a stroke cuts 0."]),
    ],
)
def test_warnings_of_feed_strokes_name_F_and_not_E(moves: str, says: list[str]) -> None:
    warnings = " ".join(ground(moves).warnings)
    assert all(each in warnings for each in says), warnings
    assert " E" not in warnings


def test_a_dress_between_feed_strokes_sharpens_the_wheel() -> None:
    first, then = by_moves([(10, 12000)] * 2), "G91 G01 Y-.01 F500.\nG90 X230. F12000.\n"
    dressed = f"{first}G00 Y1.\nG81.1 X-35. I-30. E9000. P9100\nG80\nG00 X-30.\nG00 Y-.02\n{then}"
    plain = f"{first}G00 Y1.\nG00 Y-.02\n{then}"
    sharp, dull = ground(dressed), ground(plain)
    assert len(sharp.dresses) == 1 and len(dull.dresses) == 0
    assert sharp.strokes["ds"][-1] < dull.strokes["ds"][-1] - 0.07
    assert sharp.strokes["A"][-1] < dull.strokes["A"][-1]


# ------------------------------------------------------------------------------------------- scripts and replays


def simulation_of(text: str) -> JobSimulation:
    return JobSimulation(read(f"{HEAD}{text}M30\n{DRESS}", "part.nc"), harness.job(stock=0.05, tolerance=9.0), 0.0)


PLUNGE = "G82 X230. I-30. Y-{:.3f} J-.005 L1 F60. E9000. P9100 D1\nG80\n"
some_blocks = st.lists(st.tuples(st.sampled_from(["moves", "cycle"]), some_strokes), min_size=1, max_size=3)


@given(some_blocks, st.integers(1, 2), st.lists(st.tuples(some_feeds, st.integers(0, 2)), min_size=40, max_size=40))
@examples(12)
def test_a_replay_of_feed_strokes_and_cycles_equals_the_control(
    blocks: list[tuple[str, list[tuple[int, int]]]], parts: int, choices: list[tuple[int, int]]
) -> None:
    part, depth = "", 0.0
    for kind, strokes in blocks:
        part += f"G00 Y1.\nG00 X-30.\nG01 Y-{depth:.3f} F500.\n"
        if kind == "moves":
            part += by_moves(strokes)
            depth += 0.001 * sum(deeper for deeper, _ in strokes)
        else:
            depth += 0.01
            part += PLUNGE.format(depth)
    simulation = simulation_of("M00\n".join([f"G00 X-30.\n{part}{AWAY}"] * parts))
    assert simulation.why is None
    assert len(simulation.blocks) == parts * sum(len(strokes) if kind == "moves" else 1 for kind, strokes in blocks)
    assert_replayed(simulation, choices[: len(simulation.blocks)])


def test_feed_moves_before_a_second_M00_only_position_the_wheel() -> None:
    simulation = simulation_of(f"{CYCLE}G80\n{AWAY}M00\nG00 X-30.\nG01 Y-.01 F500.\nM00\nG01 X230. F12000.\n{AWAY}")
    assert len(simulation.blocks) == len(grind(simulation.programs, simulation.job).blocks) == 2


def test_the_F_of_a_feed_stroke_can_be_varied() -> None:
    simulation = simulation_of(by_moves([(10, 12000)] * 3) + AWAY)
    episodes = simulation.start([np.random.default_rng(0)])
    played = []
    for speed in (9000.0, 12000.0, 15000.0):
        played.append(simulation.writer.block(episodes, 0, speed, 2.0))
        simulation.step(episodes, np.array([speed]), np.array([2.0]))
    written = simulation.writer.program(played)
    moves = [line for line in written.splitlines() if line.startswith("G90 X")]
    assert moves == ["G90 X230. F9000.", "G90 X-30. F12000.", "G90 X230. F15000."]
    record = grind(read(written, "part.nc"), simulation.job)
    assert record.strokes["E"].tolist() == [9000.0, 12000.0, 15000.0] and len(record.dresses) == 0
    assert simulation.writer.record(episodes, 0, played).strokes.tobytes() == record.strokes.tobytes()


NO_SCRIPT = {
    "holds on behind it": "G01 X230. F12000.\nG01 Y-.06\nG01 X-30. F12000.\n",
    "an F of its own": f"G01 X230. F12000.\nG00 X-30.\n{CYCLE.replace('F60. ', '')}",
    "turns over the part or beside it": "G01 X100. F12000.\n",
    "goes across": "G00 Z-4.\nG01 X230. Z-2. F12000.\n",
    "depends on the wheel": "#1=#5041\nG01 X230. F12000.\n",
}


@pytest.mark.parametrize("reason", NO_SCRIPT)
def test_feed_strokes_without_a_script_are_executed_by_the_control(reason: str) -> None:
    programs, shop = read(f"{HEAD}{CYCLE}G80\nG00 X-30.\n{NO_SCRIPT[reason]}G80\n{AWAY}M30\n{DRESS}", "part.nc"), job()
    with pytest.raises(ScriptError, match=reason):
        script_of(programs, shop)
    simulation, record = JobSimulation(programs, shop, 0.0), grind(programs, shop)
    episodes, strokes, worn = simulation.start([np.random.default_rng(0)]), 0.0, 0.0
    for block in simulation.blocks:
        _, tallies = simulation.step(episodes, np.array([block.plan.feed]), np.zeros(1))
        tally = Tally(*tallies[0].tolist())
        strokes, worn = strokes + tally.strokes, worn + tally.worn
    assert strokes == len(record.strokes) and worn == pytest.approx(record.parts["worn"][0])

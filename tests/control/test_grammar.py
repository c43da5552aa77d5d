import pytest

from grind_env.control import ControlError, Dwell, Line, Motion, ProgramEnd, ProgramStop, execute, read
from grind_env.control.block_decoding import recognise
from grind_env.control.block_words import read_block
from grind_env.control.numbers import STANDARD
from grind_env.control.program_reader import read_file
from tests.control.harness import ends, motions, plans, refusal, run


def test_b1_a_block_may_hold_every_kind_of_word() -> None:
    text = "/ N3 G00 X10. Z10. M3 ;"
    (move,) = motions(text)
    assert (move.block, move.line, move.end) == (3, 1, (10.0, 0.0, 10.0))
    assert motions(text, block_delete=True) == []


def test_b2_modes_act_on_the_values_to_their_right() -> None:
    assert ends("N10 G90 X5 G91 Z2 ;") == [(5.0, 0.0, 2.0)]
    assert ends("G00 X1. Z1.;N10 G91 X5 G90 Z2")[-1] == (6.0, 0.0, 2.0)


def test_b5_a_change_of_feed_mode_needs_an_f() -> None:
    error = refusal("G94 F100 ; G95 X10 ;")
    assert (error.name, error.line, error.column) == ("no-feedrate", 1, 12)
    assert refusal("F0.2 G95 X10").name == "no-feedrate"
    (line,) = motions("S60 G95 G01 X10 F0.2")
    assert isinstance(line, Line) and line.feed == 12.0


def test_b6_the_sign_of_r_selects_the_short_or_the_long_arc() -> None:
    def centre(radius: str) -> tuple[float, float]:
        arc = motions(f"F100 G00 Z10.; G02 X20 Z10 {radius}")[-1]
        return arc.centre[0], arc.centre[2]

    assert centre("R-10") == pytest.approx((10.0, 10.0))
    assert centre("R10") == pytest.approx((10.0, 10.0))
    short, long = centre("R15"), centre("R-15")
    assert abs(short[1] - 10.0) == pytest.approx(11.1803, abs=1e-4)
    assert short[1] - 10.0 == pytest.approx(10.0 - long[1])
    assert refusal("F100 G00 Z10.; G02 X20 Z10 R9").name == "arc-geometry"


def test_b7_subprograms_repeat_and_nest() -> None:
    assert ends("O1000; N1 M98 P2000 L2; N2 M30; O2000; N1 G91 X1; M99;") == [(1, 0, 0), (2, 0, 0)]
    assert ends("M98 P2 L0\nM30\nO2\nG00 X1\nM99") == []
    chain = "O1000;M98 P2000;M30;O2000;M98 P3000;M99;O3000;M98 P4000;M99;O4000;M98 P5000;M99;O5000;G91 X1;{}M99"
    assert ends(chain.format("")) == [(1, 0, 0)]
    assert refusal(chain.format("M98 P6000;") + ";O6000;M99").name == "nesting"


def test_b9_the_integrand_of_g81_is_read_in_the_last_mode() -> None:
    (start,) = plans(run("G00 Z10.\nG81 G91 Z40 G90 K5 E200 ;"))
    assert (start.plan.primary, start.plan.secondary) == (50.0, 5.0)
    (start,) = plans(run("G00 Z10.\nG81 G90 Z40 G91 K5 E200 ;"))
    assert (start.plan.primary, start.plan.secondary) == (40.0, 15.0)


def test_a_refusal_lists_exactly_the_known_g_codes() -> None:
    listed = refusal("G05").message.partition("; ")[2].removesuffix(" are").replace("G", "")
    ranges = [(part.partition(" to ")[0], part.rpartition(" to ")[2]) for part in listed.split(", ")]
    assert len(ranges) < 20
    for code in (*range(100), 81.1, 82.1, 83.1, 92.1, 59.1, 59.2, 59.3, 39.1, 100, 99.9):
        named = any(float(first) <= code <= float(last) for first, last in ranges)
        try:
            recognise(read_block(next(iter(read(f"G{code}").main.blocks))), STANDARD)
        except ControlError as error:
            assert not named and error.name in ("unknown-word", "not-supported")
        else:
            assert named


def test_g70_reads_later_words_in_inches_with_four_decimals() -> None:
    (move,) = motions("G00 X1. G70 Y.12345")
    assert move.end == (1.0, 3.13436, 0.0)
    assert move.inch


def test_a_dwell_is_given_in_seconds_or_revolutions() -> None:
    first, second, third = motions("G04 P1.5\nG04 X2\nG95 F1. S120\nG04 P3")
    assert all(isinstance(move, Dwell) for move in (first, second, third))
    assert [move.seconds for move in (first, second, third)] == [1.5, 2.0, 1.5]


def test_program_stops_and_ends_are_events() -> None:
    stop, end = run("N4 M00\nM30")
    assert isinstance(stop, ProgramStop) and (stop.code, stop.block) == ("M00", 4)
    assert isinstance(end, ProgramEnd) and end.cause == "M30"
    assert run("M03 T5 S1000 M08 G40 G54")[-1].cause == "text end"


def test_increments_add_up_without_residue() -> None:
    down = "G91 G01 Y-.1 F100.\nY-.1\nY-.1\nG90 Y-.3\n"
    assert [end[1] for end in ends(down)] == [-0.1, -0.2, -0.3]
    (start,) = plans(run(f"G19 {down}G82 X9. Y-.3 J-.01 E600.\nM30"))
    assert start.plan.depth == 0.0
    assert ends("G70 G91 G00 X.1\nX.1\nX.1\nG90 X.3")[-1][0] == 7.62


def test_a_file_beside_the_program_holds_several_programs(tmp_path) -> None:
    (tmp_path / "part.nc").write_text("M98 P77\nM30\nO79\nG00 X9.\nM99")
    (tmp_path / "O77.nc").write_text("O77\nM98 P78\nM98 P79\nM99\nO78\nG00 X8.\nM99\nO79\nX-\nM99")
    moves = [event for event in execute(read_file(tmp_path / "part.nc")) if isinstance(event, Motion)]
    assert [move.end[0] for move in moves] == [8.0, 9.0]

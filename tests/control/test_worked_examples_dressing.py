import itertools

import pytest

from grind_env.control import Arc, Control, Motion, Source, dress_program_moves, execute, read
from tests.control.harness import dress_moves, motions, picks, run, story, strokes

D1 = "O1000\nN1 G00 X50.\nN2 Z100.\nN3 G01 X45. F5.\nN4 Z90.\nN5 X50.\nN6 M99\n"
Leg = tuple[float, float, float | None]


def legs(moves: list[Motion], source: Source) -> list[Leg]:
    """Return X, Z and feed (None for a rapid) of the moves from one source."""
    return [(move.end[0], move.end[2], getattr(move, "feed", None)) for move in moves if move.source is source]


def dressed(program: str, before: str = "") -> list[Motion]:
    """Return the moves of the pre-dress of a G81.1 at X10 Z0, with F20 active."""
    text = f"G00 X10.\nF20.\n{before}\nG81.1 Z40. K0 E200. P1000\nM30\n{program}"
    return dress_moves(run(text))


def test_d1_four_moves_are_retraced() -> None:
    moves = dressed(D1)
    assert legs(moves, Source.DRESS) == [(50, 0, None), (50, 100, None), (45, 100, 5), (45, 90, 5), (50, 90, 5)]
    assert legs(moves, Source.RETRACE) == [(45, 90, 5), (45, 100, 5), (50, 100, 5), (50, 0, None), (10, 0, None)]


@pytest.mark.parametrize("before", ["M902", "M900\nM902"])
def test_d2_m902_retraces_two_moves(before: str) -> None:
    back = legs(dressed(D1, before), Source.RETRACE)
    assert back == [(50, 100, 5), (50, 0, None), (10, 0, None)]


def test_d3_m900_returns_straight() -> None:
    assert legs(dressed(D1, "M900"), Source.RETRACE) == [(10, 0, 5)]


def test_d4_a_circular_move_ends_the_memory() -> None:
    program = "O1000\nN1 G00 X50.\nN2 Z100.\nN3 G02 X40. Z110. R10.\nN4 G01 X50.\nN5 M99\n"
    moves = dressed(program)
    assert any(isinstance(move, Arc) for move in moves)
    assert legs(moves, Source.RETRACE) == [(50, 100, 20), (50, 0, None), (10, 0, None)]


def test_d5_a_circular_first_move_leaves_only_the_start() -> None:
    program = "O1000\nN1 G02 X20. Z10. R10.\nN2 G01 X50.\nN3 M99\n"
    moves = dressed(program)
    assert legs(moves, Source.DRESS) == [(20, 10, 20), (50, 10, 20)]
    assert legs(moves, Source.RETRACE) == [(10, 0, 20)]


def test_d6_a_short_program_needs_no_link() -> None:
    assert legs(dressed("O1000\nN1 G00 X50.\nN2 M99\n"), Source.RETRACE) == [(10, 0, None)]


def test_d7_the_pre_dress_comes_before_all_reciprocation() -> None:
    text = "G00 X10.\nG81.1 Z40. K0 E200. P1000\n" + D1
    moves = [move for move in motions(text, strokes=2) if move.source is not Source.PROGRAM]
    assert [move.end for move in moves[:10]][-1] == (10.0, 0.0, 0.0)
    assert [move.end for move in moves[10:]] == [(10.0, 0.0, 40.0), (10.0, 0.0, 0.0)]
    assert moves[10].begin == moves[9].finish


PLUNGE_AT_Z0 = "G17 G00 Z40.\nG82 Z0 K40. X-.2 I-.1 Q0 E2400. F60. P1000\nM30\n" + D1


def plunging(request: float) -> str:
    return story(run(PLUNGE_AT_Z0, operator_dress_at=(request,)))


def test_d8_a_request_waits_for_the_stroke_and_its_pick() -> None:
    free = strokes(run(PLUNGE_AT_Z0))
    to_z0, to_z40 = free[0], free[1]
    assert plunging(to_z0.begin + 0.4 * to_z0.seconds) == "Z0 x-0.1 operator Z40 Z0 x-0.2 Z40"
    assert plunging(to_z40.begin + 0.4 * to_z40.seconds) == "Z0 x-0.1 Z40 operator Z0 x-0.2 Z40"


def test_d8_the_wheel_returns_to_the_exact_point() -> None:
    events = run(PLUNGE_AT_Z0, operator_dress_at=(0.9,))
    moves = dress_moves(events)
    assert moves[0].start == moves[-1].end == (-0.1, 0.0, 0.0)
    assert moves[0].begin >= max(picks(events)[0].finish, strokes(events)[0].finish)


def test_requests_during_a_dress_are_run_once_at_the_next_reversal() -> None:
    text = "G00 X10.\nG81 Z40. E2400. P1000\n" + D1
    assert story(run(text, strokes=3, operator_dress_at=(0.2, 5.0, 6.0))) == "Z40 operator Z0 operator Z40"


def test_a_program_motion_ends_before_a_requested_dress() -> None:
    text = "G81 Z40. E2400. P1000\nG01 Y10. F100.\nG01 Y20.\n" + D1
    events = run(text, strokes=20, operator_dress_at=(0.2,))
    moves = [event for event in events if isinstance(event, Motion)]
    lines = [move for move in moves if move.source is Source.PROGRAM]
    dress = dress_moves(events)
    # the table makes a stroke of 40 mm each second beside the motion, and finishes the last one
    ended = [stroke.finish for stroke in strokes(events)]
    assert sum(finish <= lines[0].finish for finish in ended) > 1
    assert dress[0].begin == min(finish for finish in ended if finish >= lines[0].finish)
    assert dress[0].start[:2] == (0.0, 10.0)
    assert lines[1].begin == dress[-1].finish
    assert len(strokes(events)) == 20


def test_a_requested_dress_does_not_feed_the_standing_table_into_the_part() -> None:
    text = "G17 G81 Z40. E2400. P1000\nG01 X-.1 F1.\nG04 X3.\nG80\nM30\n" + D1
    depths = [stroke.end[0] for stroke in strokes(run(text, operator_dress_at=(1.3,)))]
    assert max(before - after for before, after in itertools.pairwise(depths)) < 0.03


def test_an_auto_dress_comes_before_an_operator_dress() -> None:
    text = "G17\nG82 Z0 K40. X-.1 I-.1 E2400. F60. P1000 D1\nM30\n" + D1
    assert story(run("G00 Z40.\n" + text, operator_dress_at=(0.2,))) == "Z0 x-0.1 auto operator Z40"


def test_modes_come_back_after_a_dress() -> None:
    text = "G91 F20.\nG81.1 Z40. E200. P7\nG01 X1.\nM30\nO7\nG70 G90 G17 G03\nG00 X1. F1.\nM99"
    line = next(move for move in motions(text) if move.source is Source.PROGRAM)
    assert (line.end[0], line.end[1]) == (1.0, 0.0)
    assert getattr(line, "feed", None) == 20.0
    assert not line.inch


def test_m90x_in_a_dress_program_holds_from_the_next_dress() -> None:
    program = D1.replace("N6 M99", "N6 M900\nM99")
    text = "G00 X10.\nG81.1 Z40. K0 E200. P1000\nG81.1 Z40. K0\nM30\n" + program
    backs = [move for move in dress_moves(run(text)) if move.source is Source.RETRACE]
    assert len(backs) == 5 + 1


def test_dress_program_moves_executes_a_dress_program_alone() -> None:
    programs = read("G00 X1.\nM30\n" + D1)
    moves = dress_program_moves(programs, 1000, Control(), start=(10.0, 0.0, 0.0))
    assert [move.source for move in moves] == [Source.DRESS] * 5 + [Source.RETRACE] * 5
    assert moves[-1].end == (10.0, 0.0, 0.0)
    assert list(execute(programs))


def test_the_way_back_carries_the_block_of_the_m99() -> None:
    moves = dressed(D1 + "N7 X--\n")
    assert {move.block for move in moves if move.source is Source.RETRACE} == {6}


def test_a_way_back_without_a_link_needs_no_feed() -> None:
    text = "G81.1 Z40. K0 E200. P7\nM30\nO7\nG00 X50.\nG01\nM99"
    assert legs(dress_moves(run(text)), Source.RETRACE) == [(0, 0, None)]

"""Dress programs within their cycle: remembered moves, the way back, and changes that stay (22-11)."""

from collections.abc import Iterable

import pytest

from grind_env.control import Control, DressEnd, DressStart, Event, Hold, Motion, Position, Source, execute, read
from tests.control.harness import COMMON, PARKED, dress_moves, ends, run, strokes

SIX = "G00 X1.\nX2.\nX3.\nX4.\nX5.\nX6.\n"


def pre_dressed(program: str, before: str = "", cycle: str = "") -> list[Motion]:
    """Return the moves of a pre-dress from X0 Z0."""
    return dress_moves(run(f"G18\n{before}\nG81.1 Y9. E100. P7 {cycle}\nM30\nO7\n{program}M99\n"))


def back(moves: Iterable[Motion]) -> list[Position]:
    return [move.end for move in moves if move.source is Source.RETRACE]


@pytest.mark.parametrize("count", range(5))
def test_m900_to_m904_set_the_number_of_retraced_moves(count: int) -> None:
    expected = [float(x) for x in range(count, -1, -1)]
    assert [end[0] for end in back(pre_dressed(SIX, before=f"M90{count}"))] == expected


def test_the_number_of_retraced_moves_ends_with_the_program() -> None:
    programs = read("M901\nG81.1 Y9. E100. P7\nM30\nO7\n" + SIX + "M99\n")
    control = Control()
    first, second = (list(execute(programs, control)) for _ in range(2))
    assert back(dress_moves(first)) == back(dress_moves(second))
    without = read("G81.1 Y9. E100. P7\nM30\nO7\n" + SIX + "M99\n")
    assert len(back(dress_moves(list(execute(without, control))))) == 5


def test_the_link_to_the_retraced_moves_is_rapid_under_g00() -> None:
    fast = pre_dressed("G01 X1. F60.\nX2.\nX3.\nX4.\nX5.\nG00 X6.\n")
    links = [type(move).__name__ for move in fast if move.source is Source.RETRACE]
    assert links == ["Rapid", "Line", "Line", "Line", "Line"]
    slow = pre_dressed("G00 X1.\nX2.\nX3.\nX4.\nX5.\nG01 X6. F60.\n")
    assert [type(move).__name__ for move in slow if move.source is Source.RETRACE] == ["Line"] + ["Rapid"] * 4


def test_blocks_without_motion_are_not_remembered() -> None:
    program = "G04 P1.\nM08\nG00 X1.\nX1.\nG04 P1.\nX2.\nF60.\nX3.\nX4.\nX5.\n"
    assert [end[0] for end in back(pre_dressed(program))] == [4.0, 3.0, 2.0, 1.0, 0.0]


def test_a_move_of_three_axes_is_retraced_as_one() -> None:
    moves = pre_dressed("G00 X1. Y1. Z1.\nX2. Z2.\nX3.\nX4.\nX5.\n")
    assert back(moves) == [(4.0, 1.0, 2.0), (3.0, 1.0, 2.0), (2.0, 1.0, 2.0), (1.0, 1.0, 1.0), (0.0, 0.0, 0.0)]


def test_work_systems_changed_in_a_dress_stay_changed() -> None:
    text = "G81.1 Y9. E100. P7\nG80\nG00 X1.\nM30\nO7\nG91 G55\nG10 L2 P1 X50.\nM99\n"
    assert ends(text, work_offsets={"G55": (7.0, 0.0, 0.0)})[-1] == (51.0, 0.0, 0.0)


def test_each_of_several_dresses_at_one_reversal_returns() -> None:
    text = COMMON + "G82 X230. I-30. Y-.01 J-.01 F60. E12000. P7 D3\nM30\nO7\nG90 G00 Y50.\nM99\n"
    events = run(text, start=PARKED)
    ways = [move.end[1] for move in dress_moves(events)]
    assert ways == [50.0, -0.01] * 3
    marks = [event for event in events if isinstance(event, DressStart | DressEnd)]
    assert [type(mark).__name__ for mark in marks] == ["DressStart", "DressEnd"] * 3
    assert strokes(events)[1].begin == marks[-1].time


def run_with_feedhold(text: str, after: int) -> list[Event]:
    """Return the events of a program with a feedhold after `after` motions, which the operator ends at once."""
    control = Control()
    events: list[Event] = []
    for event in execute(read(text), control):
        events.append(event)
        if isinstance(event, Motion) and sum(isinstance(one, Motion) for one in events) == after:
            control.feedhold()
        if isinstance(event, Hold):
            control.resume()
    return events


@pytest.mark.parametrize("after", [1, 3, 7])
def test_a_feedhold_within_a_dress_leaves_the_motions_unchanged(after: int) -> None:
    text = "G81.1 Y9. E100. P7\nG80\nM30\nO7\n" + SIX + "M99\n"
    events = run_with_feedhold(text, after)
    kinds = [event for event in events if isinstance(event, Motion | Hold)]
    assert isinstance(kinds[after], Hold)
    moves = [event for event in kinds if isinstance(event, Motion)]
    assert [move.end for move in moves] == ends(text)

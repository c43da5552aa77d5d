"""Modal codes: modes at power-up, effect and duration of each code (10-23)."""

import pytest

from grind_env.control import Arc, Control, Line, Motion, Rapid, Switch, execute, read
from grind_env.control.modal_state import Modes
from tests.control.harness import ends, motions, run

POWER_UP = {
    "motion": "G00",
    "plane": "G18",
    "incremental": False,
    "per_revolution": False,
    "inch": False,
    "diameter": False,
    "compensation": "G40",
    "corner": "G39",
    "work_system": "G54",
    "surface_speed": False,
    "feed": None,
    "spindle": None,
}
GROUPS = [
    ["G17", "G18", "G19"],
    ["G90", "G91"],
    ["G94 F1.", "G95 F1."],
    ["G70", "G71"],
    ["G40", "G41", "G42"],
    ["G39", "G39.1"],
    ["G54", "G55", "G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3"],
    ["G07", "G08"],
    ["G96", "G97"],
    ["G00", "G01", "G02", "G03"],
]


def modes_after(text: str) -> Modes:
    """Return the modes after a text, at the M00 that follows it."""
    execution = execute(read(text + "\nM00"), Control(radii={33: 100.0}))
    next(event for event in execution if type(event).__name__ == "ProgramStop")
    return execution.modes._replace(feed=None)


def test_a_program_starts_with_the_power_up_modes() -> None:
    assert modes_after("")._asdict() == POWER_UP


@pytest.mark.parametrize("group", GROUPS, ids=lambda group: group[0])
def test_a_code_holds_until_another_of_its_group(group: list[str]) -> None:
    others = " ".join(codes[-1] for codes in GROUPS if codes is not group)
    states = [modes_after(f"{code}\nM08\n{others}\nM09") for code in group]
    assert len(set(states)) == len(group)
    for first in group:
        for second, state in zip(group, states, strict=True):
            assert modes_after(f"{first}\n{others}\n{second}") == state


@pytest.mark.parametrize("end", ["M02", "M30"])
def test_the_end_of_the_program_restores_the_modes(end: str) -> None:
    execution = execute(read(f"G19 G91 G70 G08 G39.1 G55 G41 G01 F9. S100\n{end}"))
    assert modes_after("G19 G91 G70 G08 G39.1 G55 G41 G01 F9. S100")._asdict() != POWER_UP
    list(execution)
    assert execution.modes._asdict() == POWER_UP


def test_g02_turns_clockwise_in_the_default_plane() -> None:
    # ZX with Z to the right and X up: clockwise from the top leads to the right
    (arc,) = motions("G02 Z10. X-10. R10. F100.")
    assert isinstance(arc, Arc) and arc.plane == "G18" and arc.rotation == -1
    assert arc.centre == pytest.approx((-10.0, 0.0, 0.0))
    (back,) = motions("G03 Z10. X-10. R10. F100.")
    assert isinstance(back, Arc) and back.centre == pytest.approx((0.0, 0.0, 10.0))


def test_stored_values_survive_a_change_of_units() -> None:
    line = motions("G01 F254. X25.4\nG70 X2.\nG91 X1.")
    assert [move.end[0] for move in line] == pytest.approx([25.4, 50.8, 76.2])
    assert {move.feed for move in line if isinstance(move, Line)} == {254.0}
    assert ends("G92 X25.4\nG70 G00 X1.", start=(100.0, 0.0, 0.0)) == []
    assert ends("G10 L2 P1 X25.4\nG70 G00 X1.")[0][0] == pytest.approx(50.8)


def test_m_words_act_before_or_after_the_motion() -> None:
    events = run("S500 M03 G00 X1. M00\nX2. M05\nX3. M30")
    kinds = [type(event).__name__ for event in events]
    assert kinds == ["Spindle", "Switch", "Rapid", "ProgramStop", "Rapid", "Switch", "Rapid", "ProgramEnd"]
    # M902 acts before the pre-dress of its own block
    dress = "\nM30\nO9\nG00 X1.\nX2.\nX3.\nM99"
    back = [move for move in motions("M902 G81.1 Y9. E100. P9" + dress) if move.source.value == "retrace"]
    assert [move.end[0] for move in back] == [2.0, 1.0, 0.0]


def test_wheel_and_coolant_switch_in_the_order_of_their_words() -> None:
    def switched(text: str) -> list[tuple[int, bool]]:
        return [(event.turning, event.coolant) for event in run(text) if isinstance(event, Switch)]

    assert switched("S500 M03\nM08\nM09\nM05") == [(True, False), (True, True), (True, False), (False, False)]
    assert switched("M03 M07\nM03 M08\nM30") == [(1, True)]  # already on
    assert switched("M03\nM04\nM05") == [(1, False), (-1, False), (0, False)]  # in the other direction
    assert switched("M03 M05") == [(True, False), (False, False)]
    # switches of a dress program stay after it
    dress = "\nM30\nO9\nM09 G00 X1.\nM99"
    assert switched("M08\nG81.1 Y9. E100. P9" + dress) == [(False, True), (False, False)]


def test_block_numbers_may_repeat() -> None:
    assert ends("N10 G00 X1.\nN10 X2.\nN5 X3.") == [(1.0, 0.0, 0.0), (2.0, 0.0, 0.0), (3.0, 0.0, 0.0)]


def test_words_left_of_the_motion_code_belong_to_it() -> None:
    (line,) = motions("F60. X10. G01 Y5.")
    assert isinstance(line, Line) and line.end == (10.0, 5.0, 0.0)
    (rapid,) = motions("X10. G00 Y5.")
    assert isinstance(rapid, Rapid) and rapid.end == (10.0, 5.0, 0.0)


def test_the_external_offset_applies_again_at_every_start() -> None:
    control = Control(external_offset=(0.5, 0.0, 0.0))
    for _ in range(2):
        moves = [event for event in execute(read("G10 L2 P1 X1.\nG00 X1."), control) if isinstance(event, Motion)]
        assert [move.end[0] for move in moves] == [2.5]

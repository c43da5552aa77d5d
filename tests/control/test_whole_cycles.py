"""Whole cycles: a cycle without possible interruptions is one event, and all other events stay as when stepped."""

import re
from collections.abc import Callable, Iterator
from dataclasses import fields, is_dataclass
from enum import Enum
from typing import Any, NamedTuple

import pytest
from hypothesis import given
from hypothesis import strategies as st

from grind_env.control import Control, ControlError, Interrupt, events, execute, read
from grind_env.control.cycles import RULES, Rules, traverse
from tests.control.harness import COMMON, DRESS, PARKED, run
from tests.examples import examples

CYCLE = "G82 X230. I-30. Y-.03 J-.01 L1 F60. E12000. P9100"


@st.composite
def programs(draw: Any) -> str:
    """Return a program of several cycles, with or without reciprocation between them."""
    inch = draw(st.booleans())

    def length(mm: float) -> str:
        return f"{mm / 25.4:.4f}" if inch else f"{mm:.3f}"

    def one_of(*values: Any) -> Any:
        return draw(st.sampled_from(values))

    lines, depth, z = ["G70" if inch else "G71", "G94 G90 G19"], 0.0, 0.0
    for _ in range(draw(st.integers(1, 4))):
        code = one_of("G82", "G83", "G82.1", "G83.1")
        deeper = draw(st.integers(0, 60)) / 1000.0
        depth += deeper
        words = [f"Y-{length(depth)} J-{length(one_of(0.01, 0.017, 0.05))} F{length(one_of(30, 600, 6000))}"]
        words.append(f"X{length(one_of(60, 230))} I{length(one_of(-30, -12.5))} E{length(one_of(3000, 9000, 60000))}")
        words += one_of([], [f"Q-{length(one_of(0, 0.005, 0.03))}"])
        words.append(f"L{one_of(0, 1, 2)} D{one_of(0, 0, 1, 3)} P9100")
        if code.startswith("G83"):
            lines.append("G00 Z0")
            words.append(f"Z{length(one_of(0, 5, 12))} K{length(one_of(3, 7))}")
            words += one_of([], [f"R{length(one_of(0, 2, 5))}"])
        lines += [f"{code} {' '.join(words)}", one_of("", "G04 P.37", "G80", "M00", f"G01 Z{length(z)} F{length(90)}")]
        lines.append(one_of("", "G80\nM01", f"G80\nG00 X{length(-20)}"))
    return "\n".join([*lines, one_of("M30", "")]) + DRESS


def is_slow(made: list[events.Event], dwell: float) -> bool:
    """Return whether a pick is under way in the middle of the stroke after it."""
    picked = 0.0
    for event in made:
        if isinstance(event, events.Stroke) and picked > event.begin + 0.5 * (event.seconds - dwell):
            return True
        picked = event.finish if isinstance(event, events.Pick) else picked
    return False


def summed(made: list[events.Event]) -> tuple[events.CycleStrokes, float]:
    """Return the whole-cycle event of the stepped events after the pre-dress, and the seconds of the dresses."""
    seconds, finish = 0.0, 0.0
    begins: list[float] = []
    dresses: list[tuple[int, float]] = []
    strokes = [event for event in made if isinstance(event, events.Stroke)]
    for event in made:
        if isinstance(event, events.DressStart):
            dresses.append((len(begins), event.time - seconds))
            seconds -= event.time
        elif isinstance(event, events.DressEnd):
            seconds += event.time
        elif isinstance(event, events.Stroke):
            begins.append(event.begin - seconds)
            finish = event.finish - seconds
    first = strokes[0]
    plunge = first.cycle.plunge_axis
    assert plunge is not None
    one = events.CycleStrokes(
        time=finish,
        plan=first.cycle,
        start=first.start,
        feed=first.feed,
        begins=tuple(begins),
        seconds=tuple(stroke.seconds for stroke in strokes),
        plunge=tuple(stroke.middle[plunge] for stroke in strokes),
        cross=tuple(stroke.middle[3 - plunge - first.axis] for stroke in strokes),
        end=next(event.end for event in reversed(made) if isinstance(event, events.Stroke | events.Pick)),
        dresses=tuple(dresses),
        inch=first.inch,
    )
    return one, seconds


TIMES = ("time", "begin", "begins", "dresses")


def numbers(value: Any, name: str = "", late: float = 0.0) -> Iterator[Any]:
    """Yield all values of an event, with its times reduced by `late` s."""
    if is_dataclass(value):
        yield type(value).__name__
        for item in fields(value):
            yield from numbers(getattr(value, item.name), item.name, late)
    elif isinstance(value, tuple):
        for each in value:
            yield from numbers(each, name, late)
    elif isinstance(value, Enum):
        yield value.value
    else:
        yield value - late if name in TIMES and isinstance(value, float) else value


def require_same(found: events.Event, stepped: events.Event, late: float, exact: bool = True) -> None:
    """Require the same bits or, if dresses have been left out, the same values up to rounding."""
    if late == 0.0 and exact:
        assert found == stepped
        return
    for one, other in zip(numbers(found), numbers(stepped, late=late), strict=True):
        assert one == pytest.approx(other, abs=1e-9) if isinstance(other, float) else one == other


def require_alike(found: list[events.Event], stepped: list[events.Event], dwell: float) -> None:
    """Require whole cycles wherever they are possible, and the stepped events everywhere else."""
    late, at, known = 0.0, 0, False
    for event in found:
        known |= isinstance(event, events.DressEnd)
        first_stroke = isinstance(event, events.Stroke) and event.number == 1
        if first_stroke or isinstance(event, events.CycleStrokes):
            end = next(index for index in range(at, len(stepped)) if isinstance(stepped[index], events.CycleEnd))
            expected, seconds = summed(stepped[at:end])
            can_be_whole = not is_slow(stepped[at:end], dwell) and (known or expected.plan.dresses == 0)
            assert isinstance(event, events.CycleStrokes) == can_be_whole
            if not first_stroke:
                require_same(event, expected, late, exact=dwell == 0.0 and seconds == 0.0)
                at, late = end, late + seconds
                continue
        require_same(event, stepped[at], late)
        at += 1
    assert at == len(stepped)


@examples(150)
@given(
    text=programs(),
    x=st.sampled_from([-30.0, 41.3, 229.0]),
    dwell=st.sampled_from([0.0, 0.15]),
    coverage=st.booleans(),
    acceleration=st.sampled_from([300.0, 2000.0]),
)
def test_whole_cycles_give_the_same_events_as_stepped_strokes(
    text: str, x: float, dwell: float, coverage: bool, acceleration: float
) -> None:
    control: dict[str, Any] = {"start": (x, 0.0, 0.0), "reversal_dwell": dwell, "coverage_pass": coverage}
    control["acceleration"] = acceleration
    require_alike(run(text, whole_cycles=True, **control), run(text, **control), dwell)


def test_a_whole_cycle_ends_with_its_last_pick() -> None:
    text = f"{COMMON}{CYCLE.replace('L1', 'L0').replace('F60.', 'F1.')}\nG04 P1.\nM30{DRESS}"
    control: dict[str, Any] = {"start": PARKED, "coverage_pass": False}
    found = run(text, whole_cycles=True, **control)
    require_alike(found, run(text, **control), dwell=0.0)
    assert isinstance(found[1], events.CycleStrokes) and isinstance(found[2], events.CycleEnd)
    assert found[2].time > found[1].time


class Progress(NamedTuple):
    """Progress of a cycle with one pick of each kind."""

    made: float
    depth: float = 0.0
    crossed: float = 0.0
    forward: bool = True
    dresses: float = 0.0


def test_two_picks_at_a_reversal_are_made_one_after_the_other(monkeypatch: pytest.MonkeyPatch) -> None:
    both = Rules(
        cycle_of=lambda plan, coverage: None,
        begin=lambda cycle: Progress(0.0),
        after_reversal=lambda cycle, along: Progress(along.made + 1.0, depth=0.03, crossed=0.05),
        finished=lambda cycle, along: along.made >= 1.0,
        least_strokes=lambda cycle: 1.0,
        cross=traverse.cross,
    )
    monkeypatch.setitem(RULES, "G83", both)
    text = f"{COMMON}G83 X230. I-30. Y-.03 J-.01 Z.05 K.05 F6. E12000.\nG04 P1.\nM30"
    require_alike(run(text, start=PARKED, whole_cycles=True), run(text, start=PARKED), dwell=0.0)


@given(text=programs(), limit=st.integers(1, 400))
def test_a_whole_cycle_spends_the_block_budget_of_its_strokes(text: str, limit: int) -> None:
    def outcome(**settings: Any) -> str:
        try:
            run(text, start=PARKED, block_budget=limit, **settings)
        except ControlError as error:
            return str(error)
        return "done"

    if not re.search("D[13]", text):
        assert outcome(whole_cycles=True) == outcome()


BETWEEN: dict[str, tuple[str, dict[str, Any]]] = {
    "a dress asked for by time": (CYCLE, {"operator_dress_at": (1e6,)}),
    "an interrupt asked for by time": (CYCLE, {"interrupts": (Interrupt(9100, at=1e6),)}),
    "an auto-dress that has never been executed": (f"{CYCLE} D1", {}),
    "a slow pick": (CYCLE.replace("F60.", "F.1"), {}),
    "a dress that the control takes off the wheel": (CYCLE, {"dress_amount": 0.01}),
}
AFTER_DRESS: dict[str, tuple[str, dict[str, Any]]] = {
    "constant surface speed": ("G96 S20", {"radii": {33: 150.0}}),
    "a message of a worn wheel": ("", {"minimum_radius": 140.0, "radii": {33: 139.0}}),
}
PANEL: dict[str, Callable[[Control], None]] = {
    "a dress asked for at the panel": Control.request_dress,
    "an interrupt asked for at the panel": lambda control: control.interrupt(9100),
    "single block": Control.single_block,
}


@pytest.mark.parametrize(("cycle", "control"), BETWEEN.values(), ids=BETWEEN)
def test_a_cycle_is_stepped_when_something_can_come_between_strokes(cycle: str, control: dict[str, Any]) -> None:
    text = f"{COMMON}{cycle}\nM30{DRESS}"
    found = run(text, start=PARKED, whole_cycles=True, **control)
    assert found == run(text, start=PARKED, **control)
    assert any(
        isinstance(event, events.CycleStrokes) for event in run(f"{COMMON}{CYCLE}\nM30{DRESS}", whole_cycles=True)
    )


@pytest.mark.parametrize("act", PANEL.values(), ids=PANEL)
def test_a_panel_action_at_the_start_of_a_cycle_has_it_stepped(act: Callable[[Control], None]) -> None:
    def produced(**settings: Any) -> Iterator[events.Event]:
        control = Control(start=PARKED, **settings)
        for event in execute(read(f"{COMMON}{CYCLE}\nM30{DRESS}"), control):
            if isinstance(event, events.CycleStart):
                act(control)
            yield event

    assert list(produced(whole_cycles=True)) == list(produced())


@pytest.mark.parametrize("hold", [Control.feedhold, lambda control: control.override(0.0)])
def test_a_hold_at_the_start_of_a_cycle_comes_before_its_first_stroke(hold: Callable[[Control], None]) -> None:
    control = Control(start=PARKED, whole_cycles=True)
    coming = execute(read(f"{COMMON}{CYCLE}\nM30{DRESS}"), control)
    while not isinstance(next(coming), events.CycleStart):
        pass
    hold(control)
    assert isinstance(next(coming), events.Hold)
    control.resume()
    control.override(100.0)
    assert isinstance(next(coming), events.Stroke)


@pytest.mark.parametrize(("block", "control"), AFTER_DRESS.values(), ids=AFTER_DRESS)
def test_dresses_with_messages_or_spindle_events_are_executed(block: str, control: dict[str, Any]) -> None:
    text = f"{COMMON}{block}\n{CYCLE} D2\nG82 Y-.06 D2\nM30{DRESS}"
    assert run(text, start=PARKED, whole_cycles=True, **control) == run(text, start=PARKED, **control)


@pytest.mark.parametrize(("write", "whole"), [("T0202", 1), ("G92 Z7.", 1), ("G28 Y60.", 0), ("G91 G10 L2 P1 Z.5", 0)])
def test_a_dress_program_is_executed_until_it_leaves_the_tables_unchanged(write: str, whole: int) -> None:
    dress = DRESS.replace("G01", f"{write}\nG90 G01")
    text = f"{COMMON}{CYCLE} D3\nG82 Y-.06 D1\nG80\nG00 X0 Y0 Z3.\nM30{dress}"
    found, stepped = run(text, start=PARKED, whole_cycles=True), run(text, start=PARKED)
    assert sum(isinstance(event, events.CycleStrokes) for event in found) == whole
    last, expected = found[-2], stepped[-2]
    assert isinstance(last, events.Rapid) and isinstance(expected, events.Rapid)
    assert last.end == expected.end


@pytest.mark.parametrize(("between", "write"), [("#500=9", ""), ("", "#500=#500+4\n"), ("#501=0", "#501=5\n")])
def test_a_dress_program_is_executed_again_if_its_variables_have_changed(between: str, write: str) -> None:
    dress = DRESS.replace("G01", f"{write}G04 P#500\nG01")
    text = f"#500=1\n#501=1\n{COMMON}{CYCLE} D2\n{between}\nG82 Y-.06 D1\nG04 P#501\nM30{dress}"
    found, stepped = run(text, start=PARKED, whole_cycles=True), run(text, start=PARKED)
    assert [each.seconds for each in found if isinstance(each, events.Dwell)][-2:] == [
        each.seconds for each in stepped if isinstance(each, events.Dwell)
    ][-2:]


def test_a_cycle_without_strokes_gives_no_strokes_event() -> None:
    text = f"{COMMON}G82 X230. I-30. Y0 J-.01 F60. E12000.\nM30"
    kinds = [type(event) for event in run(text, start=PARKED, whole_cycles=True, coverage_pass=False)]
    assert kinds == [events.CycleStart, events.CycleEnd, events.ProgramEnd]

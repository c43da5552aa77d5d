"""Short ways to run a program text and to say what it did."""

import pytest

from grind_env.control import (
    Control,
    ControlError,
    CycleEnd,
    CycleStart,
    DressStart,
    Event,
    Motion,
    Pick,
    Position,
    Source,
    Stroke,
    execute,
    read,
)

DRESS = "\nO9100\nG90 G00 Y50.\nG01 Z5. F100.\nM99\n"
COMMON = "G71 G94 G90 G19\n"
PARKED = (-30.0, 0.0, 0.0)


def run(text: str, **settings: object) -> list[Event]:
    return list(execute(read(text), Control(**settings)))


def cycles(text: str, **settings: object) -> list[Event]:
    """Events of a program set up as in the worked examples: G19, wheel at X-30, O9100 to dress."""
    return run(COMMON + text + DRESS, **{"acceleration": 2000.0, "start": PARKED, **settings})


def motions(text: str, **settings: object) -> list[Motion]:
    return [event for event in run(text, **settings) if isinstance(event, Motion)]


def ends(text: str, **settings: object) -> list[Position]:
    return [motion.end for motion in motions(text, **settings)]


def strokes(events: list[Event]) -> list[Stroke]:
    return [event for event in events if isinstance(event, Stroke)]


def picks(events: list[Event]) -> list[Pick]:
    return [event for event in events if isinstance(event, Pick)]


def plans(events: list[Event]) -> list[CycleStart]:
    return [event for event in events if isinstance(event, CycleStart)]


def cycle_ends(events: list[Event]) -> list[CycleEnd]:
    return [event for event in events if isinstance(event, CycleEnd)]


def story(events: list[Event]) -> str:
    """Strokes as X230, plunges as y-.01, cross picks as z10, dresses by their cause; nothing else."""
    words = []
    for event in events:
        if isinstance(event, Stroke):
            words.append(f"{'XYZ'[event.axis]}{event.end[event.axis]:g}")
        elif isinstance(event, Pick):
            words.append(f"{'xyz'[event.axis]}{round(event.end[event.axis], 9):g}")
        elif isinstance(event, DressStart):
            words.append(event.cause)
    return " ".join(words)


def dress_moves(events: list[Event]) -> list[Motion]:
    return [event for event in events if isinstance(event, Motion) and event.source in (Source.DRESS, Source.RETRACE)]


def refusal(text: str, **settings: object) -> ControlError:
    with pytest.raises(ControlError) as caught:
        run(text, **settings)
    return caught.value

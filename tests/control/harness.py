"""Short functions that run a program and describe its events."""

import pytest

from grind_env import control

DRESS = "\nO9100\nG90 G00 Y50.\nG01 Z5. F100.\nM99\n"
COMMON = "G71 G94 G90 G19\n"
PARKED = (-30.0, 0.0, 0.0)


def run(text: str, **settings: object) -> list[control.Event]:
    return list(control.execute(control.read(text), control.Control(**settings)))


def cycles(text: str, **settings: object) -> list[control.Event]:
    """Return the events of a program set up as in the worked examples: G19, wheel at X-30, O9100 to dress."""
    return run(COMMON + text + DRESS, **{"acceleration": 2000.0, "start": PARKED, **settings})


def motions(text: str, **settings: object) -> list[control.Motion]:
    return [event for event in run(text, **settings) if isinstance(event, control.Motion)]


def path(text: str, radius: float = 2.0, **settings: object) -> list[tuple[float, float]]:
    """Return the ends (Z, X) of the motions of a compensated program."""
    return [(end[2], end[0]) for end in ends(text, radius=radius, **settings)]


def ends(text: str, **settings: object) -> list[control.Position]:
    return [motion.end for motion in motions(text, **settings)]


def strokes(events: list[control.Event]) -> list[control.Stroke]:
    return [event for event in events if isinstance(event, control.Stroke)]


def picks(events: list[control.Event]) -> list[control.Pick]:
    return [event for event in events if isinstance(event, control.Pick)]


def plans(events: list[control.Event]) -> list[control.CycleStart]:
    return [event for event in events if isinstance(event, control.CycleStart)]


def cycle_ends(events: list[control.Event]) -> list[control.CycleEnd]:
    return [event for event in events if isinstance(event, control.CycleEnd)]


def story(events: list[control.Event]) -> str:
    """Return strokes as X230, plunges as y-.01, cross picks as z10 and dresses by their cause."""
    words = []
    for event in events:
        if isinstance(event, control.Stroke):
            words.append(f"{'XYZ'[event.axis]}{event.end[event.axis]:g}")
        elif isinstance(event, control.Pick):
            words.append(f"{'xyz'[event.axis]}{round(event.end[event.axis], 9):g}")
        elif isinstance(event, control.DressStart):
            words.append(event.cause)
    return " ".join(words)


def dress_moves(events: list[control.Event]) -> list[control.Motion]:
    return [
        event
        for event in events
        if isinstance(event, control.Motion) and event.source in (control.Source.DRESS, control.Source.RETRACE)
    ]


def refusal(text: str, **settings: object) -> control.ControlError:
    with pytest.raises(control.ControlError) as caught:
        run(text, **settings)
    return caught.value

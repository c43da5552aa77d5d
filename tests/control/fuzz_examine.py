"""Checks of random programs: the control gives consistent motions or a `ControlError` with line and column."""

import itertools
import math
from collections.abc import Iterator

from grind_env.control import (
    Arc,
    Control,
    ControlError,
    Event,
    Interrupt,
    Line,
    Motion,
    NumberFormat,
    Pick,
    Stroke,
    check,
    execute,
    read,
)
from tests.control.fuzz_cases import Case, case
from tests.soak.limits import TooSlowError, limited
from tests.soak.part import Part, Tried, broken, fallen

SLOW = 2.0  #: processor time permitted for a program, s
#: errors of the settings, the file and the panel; all others point into the program
WITHOUT_PLACE = {"setting", "file", "hold"}
NEGLIGIBLE = 1e-6  #: tolerance above the rounding of coordinates, mm or s
ARC_TOLERANCE = 0.0101  #: permitted difference of the distances of both ends of an arc from its centre, mm


def attempt(seed: int) -> Tried:
    """Check and execute the program of a seed."""
    return examine(case(seed))


def examine(case: Case) -> Tried:
    """Check and execute a program, and count its end as "done" or by the name of its error."""
    shown = f"{case.settings} {case.actions}\n{case.text}"
    try:
        with limited(SLOW):
            errors = _errors(case)
            lost = [each for each in errors if each.name not in WITHOUT_PLACE and None in (each.line, each.column)]
            wrong = f"no place: {lost[0]}" if lost else _broken(case)
    except (TooSlowError, Exception) as error:
        return fallen(error, shown)
    if wrong is not None:
        return broken(wrong.split(":")[0], f"{wrong}\n{shown}")
    return Tried("refused" if errors else "accepted", sums={errors[0].name if errors else "done": 1})


def _control(case: Case) -> Control:
    """Return the settings of a case, with a new panel for one execution."""
    settings = dict(case.settings)
    settings["interrupts"] = tuple(Interrupt(**one) for one in settings.get("interrupts", ()))
    settings["number_format"] = NumberFormat(**settings.get("number_format", {}))
    return Control(**settings)


def _errors(case: Case) -> list[ControlError]:
    try:
        return check(read(case.text), _control(case)).errors
    except ControlError as error:
        return [error]


def _broken(case: Case) -> str | None:
    """Return the first broken promise and its place, or None if the execution breaks none."""
    control = _control(case)
    events: list[Event] = []
    try:
        for event in _watched(case, control):
            events.append(event)
    except ControlError:
        pass  # the events before the faulty block must be right
    for earlier, later in itertools.pairwise(event for event in events if not isinstance(event, Pick)):
        if _moment(later) < _moment(earlier) - NEGLIGIBLE:
            return f"events out of order: {earlier} {later}"
    motions = [event for event in events if isinstance(event, Motion)]
    if sum(isinstance(motion, Stroke) for motion in motions) > control.block_budget:
        return "more strokes than the budget"
    table = any(isinstance(motion, Stroke | Pick) for motion in motions)
    for before, motion in itertools.pairwise(motions):
        if isinstance(motion, Pick) and not isinstance(before, Stroke):
            return f"a pick does not follow a stroke: line {motion.line}, {before} {motion}"
        if not table and math.dist(before.end, motion.start) > NEGLIGIBLE:
            return f"a motion does not begin where the one before ended: line {motion.line}, {before} {motion}"
    for motion in motions:
        if not all(map(math.isfinite, (*motion.start, *motion.end, motion.begin, motion.seconds))):
            return f"a motion has impossible numbers: line {motion.line}, {motion}"
        if motion.seconds < 0.0:
            return f"a motion ends before it begins: line {motion.line}, {motion}"
        if isinstance(motion, Line | Arc | Stroke | Pick) and not 0.0 < motion.feed <= control.maximum_feed * 1.000001:
            return f"a feed is beyond its limits: line {motion.line}, {motion.feed}"
        if isinstance(motion, Arc) and abs(_radius(motion, motion.start) - _radius(motion, motion.end)) > ARC_TOLERANCE:
            return f"the ends of an arc are not equally far from its centre: line {motion.line}, {motion}"
    return None


def _moment(event: Event) -> float:
    """Return the time of an event, or of the end of a motion, s."""
    return event.finish if isinstance(event, Motion) else event.time


def _radius(arc: Arc, point: tuple[float, float, float]) -> float:
    normal = {"G17": 2, "G18": 1, "G19": 0}[arc.plane]
    return math.hypot(*(a - b for axis, (a, b) in enumerate(zip(point, arc.centre, strict=True)) if axis != normal))


def _watched(case: Case, control: Control) -> Iterator[Event]:
    """Yield the events of a case with its panel actions in between; a hold ends after one event."""
    actions = list(case.actions)
    for count, event in enumerate(execute(read(case.text), control)):
        yield event
        control.resume()
        if control.panel.override == 0.0:
            control.override(100.0)
        while actions and actions[0][0] <= count:
            _act(control, actions.pop(0)[1])


def _act(control: Control, action: str) -> None:
    name, _, number = action.rpartition(" ")
    if name == "override":
        control.override(float(number))
    elif name == "interrupt":
        control.interrupt(9000, int(number))
    else:
        {"dress": control.request_dress, "feedhold": control.feedhold, "single block": control.single_block}[action]()


PART = Part(name="texts", attempt=attempt, growth=50.0)

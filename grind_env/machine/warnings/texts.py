"""Warning texts of a run: programs that the control accepts, but that do not grind as they seem to (PD-6)."""

import math

from grind_env.control import Control, CyclePlan, CycleStrokes, Line, Motion, Pick, Position, Rapid, Source
from grind_env.control.cycle_formulas import pick_window
from grind_env.control.motion_paths import AXES
from grind_env.control.motion_profile import ramp_time
from grind_env.control.numbers import MILLIMETRES_PER_INCH
from grind_env.machine.axis_roles import cross_axis, plunge_axis
from grind_env.process.entries import Machine

#: message about a cut without finite numbers
BEYOND_NUMBERS = (
    "forces, heat or wear of a cut are no finite numbers; give the job and the factors of its parts values that occur "
    "in grinding"
)

SLACK = 1.0 + 1e-9  #: factor on a speed limit, because inches and shares of a path are rounded


def slow_pick(pick: Pick, stroke: CycleStrokes, control: Control) -> str:
    """Return the advice on a pick that is still under way in the middle of the next stroke."""
    dwell, (begin, end) = control.reversal_dwell, stroke.ends(0)
    length, seconds = abs(end - begin), stroke.seconds[0] - dwell
    ramp = ramp_time(length, stroke.feed / 60.0, control.acceleration)
    window = pick_window(ramp, dwell, seconds)
    feed = feed_for(math.dist(pick.start, pick.end), window, control.acceleration)
    unit, name, steps = (float(MILLIMETRES_PER_INCH), "inch/min", 10) if pick.inch else (1.0, "mm/min", 1)
    found = (
        f"its picks at F{pick.feed / unit:g} {name} take {pick.seconds:.2f} s and are not finished in the middle of "
        f"the next stroke, which is {window:.2f} s later, so that a part of each is ground one stroke later"
    )
    if feed is None:
        return f"{found}; no F would do, so give a lower E or a smaller pick"
    return f"{found}; F{math.ceil(steps * feed / unit) / steps:g} would do"


def feed_for(length: float, seconds: float, acceleration: float) -> float | None:
    """Return the least feed, mm/min, that covers `length` mm from rest to rest in `seconds`; None if none does."""
    # length/v + v/acceleration = seconds, the inverse of rules.motion_time
    half = 0.5 * acceleration * seconds
    rest = half * half - acceleration * length
    return 60.0 * acceleration * length / (half + math.sqrt(rest)) if rest >= 0.0 else None


def crash(depth: float, move: Motion, part: str = "the part") -> str:
    """Return the warning about a move outside a cycle that takes the wheel `depth` mm into the named part."""
    dressing = move.source in (Source.DRESS, Source.RETRACE)
    remedy = (
        "let it go by way of a point above the part"
        if dressing
        else "come down beside it, and let the strokes of a cycle take the stock off"
    )
    return f"{named_move(move)} takes the wheel {depth:.3g} mm into {part}; {remedy}"


def named_move(move: Motion) -> str:
    """Return a move as messages call it."""
    kind = "rapid" if isinstance(move, Rapid) else "feed move"
    if move.source is Source.RETRACE:
        return f"a {kind} on the way back from the dress"
    return f"a {kind} of the dress program" if move.source is Source.DRESS else f"a {kind} outside a cycle"


def beside_part(what: str, axis: str, swept: tuple[float, float], part: tuple[float, float]) -> str:
    """Return the warning about a cycle, named `what`, whose strokes pass beside the part along an axis."""
    return (
        f"no stroke of {what} touches the part, which lies from {axis}{part[0]:g} to "
        f"{axis}{part[1]:g}; the wheel passes from {axis}{swept[0]:g} to {axis}{swept[1]:g}"
    )


def deep(depths: tuple[float, float]) -> str:
    """Return the text of a depth between two values, mm."""
    low, high = (f"{depth:.4g}" for depth in depths)
    return f"{high} mm deep" if low == high else f"{low} to {high} mm deep"


def missed_diamond(program: int, tip: Position, begin: Position, end: Position, cross: int, width: float) -> str:
    """Return the warning about a pass between two positions, mm, that leaves some of the wheel undressed."""

    def said(place: Position) -> str:
        return " ".join(f"{axis}{coordinate:g}" for axis, coordinate in zip(AXES, place, strict=True))

    return (
        f"dress program O{program} dresses nothing, for the pass from {said(begin)} to {said(end)} does not take the "
        f"whole wheel over the diamond at {said(tip)} (it reaches {width:g} mm from its {AXES[cross]} to plus); "
        "lead it there, or mend [diamond] of the job"
    )


def short_stroke(coordinate: float, axis: str, low: float, high: float) -> str:
    """Return the advice on a reversal point over the part, or at its very end."""
    place, remedy = "over the part", "set the reversal points beyond it"
    if not low < coordinate < high:
        place = "at the end of the part"
        remedy = "without overtravel the table turns in the cut: set the reversal point some 20 mm beyond"
    return f"a stroke turns at {axis}{coordinate:g}, {place}, which lies from {axis}{low:g} to {axis}{high:g}; {remedy}"


def over_table_limits(
    feed: float, length: float, acceleration: float, machine: Machine, inch: bool, word: str
) -> str | None:
    """Return the warning about a stroke of `length` mm at `feed`, mm/min, that is too fast; None if it is not.

    Under G70 (`inch`) a number that would be legal in mm/min is assumed to be meant in mm/min.
    """
    most, written = machine.maximum_table_speed, feed / float(MILLIMETRES_PER_INCH)
    if feed > most * SLACK:
        meant = written / float(MILLIMETRES_PER_INCH)
        unit = (
            f", or write {word}{meant:.1f} if {word}{written:g} is meant in mm/min" if inch and written <= most else ""
        )
        return f"{word}{feed:g} is more than the table of {machine} makes, {most:g} mm/min; lower {word}{unit}"
    reached = 60.0 * math.sqrt(acceleration * length)
    if feed > reached * SLACK:
        return (
            f"the table never comes to {word}{feed:g}: on {length:g} mm it gets no faster than {reached:.0f} mm/min at "
            f"{acceleration:g} mm/s2; set the reversal points farther apart, or lower {word}"
        )
    return None


def over_pick_limits(plan: CyclePlan, machine: Machine) -> str | None:
    """Return the warning about a cycle whose picks are too fast for the machine; None if they are not."""
    if plan.plunge_axis is None:
        return None
    if max(plan.primary_pick, plan.secondary_pick) > 0.0 and plan.pick_feed > machine.maximum_plunge_feed * SLACK:
        return _faster(plan.pick_feed, plan.plunge_axis, machine, machine.maximum_plunge_feed)
    if plan.cross_axis is not None and plan.pick_feed > machine.maximum_cross_feed * SLACK:
        return _faster(plan.pick_feed, plan.cross_axis, machine, machine.maximum_cross_feed)
    return None


def over_feed_limits(move: Line, axis: int, machine: Machine) -> str | None:
    """Return the warning about a feed move that is too fast for an axis; None if it is not."""
    length = math.dist(move.start, move.end)
    limits = {
        axis: machine.maximum_table_speed,
        plunge_axis(axis): machine.maximum_plunge_feed,
        cross_axis(axis): machine.maximum_cross_feed,
    }
    for along, most in limits.items():
        feed = move.feed * abs(move.end[along] - move.start[along]) / length if length > 0.0 else 0.0
        if feed > most * SLACK:
            return _faster(feed, along, machine, most)
    return None


def _faster(feed: float, axis: int, machine: Machine, most: float) -> str:
    return f"a feed of {feed:g} mm/min along {AXES[axis]} is more than {machine} makes, {most:g} mm/min; lower F"


class Notices:
    """Collector of warnings, one for each subject and block; `muted` while warnings only follow from an earlier one."""

    def __init__(self, program: str) -> None:
        self.program = program
        self.sentences: list[str] = []
        self.muted = False
        self._told: set[tuple[str, str, int]] = set()

    def tell(self, line: int, subject: str, text: str | None, file: str | None = None) -> None:
        """Add a warning about a line of the program or of a file, line 0 for all of it; None as text adds nothing."""
        file = file or self.program
        if text is not None and not self.muted and (subject, file, line) not in self._told:
            self._told.add((subject, file, line))
            self.sentences.append(f"{file}:{line}: {text}" if line else f"{file}: {text}")

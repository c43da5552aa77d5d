"""Blocks that move axes outside the cycles: lines, arcs, dwells, reference moves and grooves."""

import functools
import itertools
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from grind_env.control import motion_paths, numbers
from grind_env.control.axis_timeline import Timeline
from grind_env.control.block_decoding import Command
from grind_env.control.compensation.radius_compensation import SIDES, Compensation, Piece
from grind_env.control.control_settings import ORIGIN, Control
from grind_env.control.coordinates import WorkSystems
from grind_env.control.dress_retrace import REMEMBERED, Recorder
from grind_env.control.errors import ControlError, Place
from grind_env.control.events import Event, Hold, Message, Position, Source, Spindle, Switch, placed
from grind_env.control.groove_cycles import INCH_RETRACT, METRIC_RETRACT, groove_legs, least_legs, plan_groove
from grind_env.control.lookahead import Barrier, Outlook, Prospect, in_plane
from grind_env.control.modal_state import Modes
from grind_env.control.modes import PLANES
from grind_env.control.path_geometry import Path, Straight
from grind_env.control.tool_selection import Tooling

#: function that yields the coming motions in the order of execution
Ahead = Callable[[Outlook], Iterator[Prospect | Barrier]]


#: M codes of the wheel and of the coolant
SPINDLE_ON, SPINDLE_OFF, COOLANT_ON, COOLANT_OFF = {3: 1, 4: -1}, {5: 0}, (7, 8), (9,)

LENGTHS = frozenset("EFIJKQRXYZ")  #: letters of lengths and feeds


@dataclass(frozen=True, slots=True)
class MoveSection:
    """A part of the path of a motion block to `goal`, from rest to rest; `feed` is mm/min, None for a rapid."""

    path: Path
    feed: float | None
    source: Source
    goal: Position


class Mover:
    """Conversion of motion blocks to motions of the timeline, by coordinates, tool and radius compensation."""

    def __init__(self, timeline: Timeline, control: Control, place: Place) -> None:
        self.timeline, self.control, self.place = timeline, control, place
        self.modes = Modes()  # modal state in force
        self.work, self.tooling = WorkSystems(control), Tooling(control)
        self.compensation = Compensation(control)
        self.source = Source.PROGRAM  # what commands the motions: the program, a dress or an interrupt
        self.recorder: Recorder | None = None  # moves of the dress or interrupt program under execution
        self.remembered = REMEMBERED  # number of moves that the next recorder remembers
        # speed of the wheel, revolutions per minute, and the surface speed that G96 holds, m/min, 0 under G97; None
        # before the first S
        self.spindle: tuple[float, float] | None = None
        # 1 after M03, -1 after M04 (the other direction), 0 while the wheel stands; whether M07 or M08 is in force
        self.turning, self.coolant = 0, False
        # programmed position after a type 1 interrupt, else None: the next motion counts from there although the axes
        # stand elsewhere, and runs straight to its end (lathe manual 29-6)
        self.detour: Position | None = None
        self.passed: Position | None = None  # the intermediate point of the last G28 or G30, for G29
        self._told: set[tuple[str, Place]] = set()

    @property
    def position(self) -> Position:
        """The programmed position, machine coordinates, mm: without the offset of the compensation."""
        actual, table = self.timeline.position, self._reciprocating
        if self.detour is None:
            return self.compensation.position(actual)
        return self.detour if table is None else _moved(self.detour, actual, [table])

    @property
    def tables(self) -> tuple[object, ...]:
        work = self.work
        shifts = dict(work.offsets), work.external, work.shift, work.local, work.length
        chosen = self.tooling.entry, dict(self.tooling.radii), self.passed, self.remembered
        return *shifts, *chosen, self.turning, self.coolant

    def begin_block(self, command: Command) -> None:
        """Put modes, T, M800, M801 and M900 to M904 of a block in force (mill manual 29-7)."""
        self.modes, self.place = command.modes, command.block.place
        self.timeline.inch = command.modes.inch
        self.compensation.refuse_plane(command)
        length = self.tooling.select(command)
        if length is not None:
            self.work.length = length
        for number in command.m:
            if number in (800, 801):
                self.compensation.detect = number == 801
            elif 900 <= number <= 904:
                self.remembered = number - 900

    def turn_spindle(self) -> Iterator[Event]:
        modes = self.modes
        speed = self.tooling.spindle_speed(modes, self._no_wheel_radius)
        if speed is None or modes.spindle is None:
            return
        spindle = speed, modes.spindle if modes.surface_speed else 0.0
        if spindle != self.spindle:
            self.spindle = spindle
            yield Spindle(self.timeline.time, *spindle)

    def report_clamped_feed(self, command: Command) -> Iterator[Event]:
        """Yield a message, once per block, for a feed that is clamped to the maximum (12-60)."""
        feeds = {"E": command.reciprocation_feed}
        if "F" in command.words and not command.modes.per_revolution:
            feeds["F"] = command.modes.feed
        for letter, feed in feeds.items():
            highest = self.control.maximum_feed
            if feed is None or feed <= highest or ("clamped", self.place) in self._told:
                continue
            self._told.add(("clamped", self.place))
            inch = float(numbers.MILLIMETRES_PER_INCH)
            text = f"line {self.place.line}: {command.words[letter]} is {feed:g} mm/min and clamped to {highest:g}"
            if command.modes.inch and feed / inch <= highest:
                meant = f"{letter}{feed / inch / inch:.1f}"
                text += f"; G70 is in force, so write {meant} if mm/min are meant, or G71 before it"
            yield Message(self.timeline.time, text)

    def report_cut_decimals(self, command: Command) -> Iterator[Event]:
        block, inch, form = command.block, command.modes.inch, command.number_format
        if ("cut", self.place) in self._told:
            return
        for word in command.words.values():
            read = numbers.without_excess(block, word, inch, form) if word.letter in LENGTHS else None
            written = block.source.text[word.column - block.source.column + 1 :].lstrip(" \t+-")
            if read is not None and written[:1] not in ("[", "#"):
                self._told.add(("cut", self.place))
                text = f"line {self.place.line}: {word} has more decimals than are read, and is taken for {read}"
                yield Message(self.timeline.time, text)

    def switch(self, command: Command, on: bool) -> Iterator[Event]:
        before = self.turning, self.coolant
        for number in command.m:
            if number in (senses := SPINDLE_ON if on else SPINDLE_OFF):
                self.turning = senses[number]
            elif number in (COOLANT_ON if on else COOLANT_OFF):
                self.coolant = on
        if (self.turning, self.coolant) != before:
            yield Switch(self.timeline.time, self.turning, self.coolant)

    def follow_wheel(self, amount: float) -> None:
        self.tooling.wheel_radius -= amount
        plan = None if self.timeline.reciprocation is None else self.timeline.reciprocation.plan
        if plan is not None and plan.plunge_axis is not None and plan.depth > 0.0:
            way = amount if plan.depth_target > plan.plunge_start else -amount
            self.timeline.infeed_shift += way
            self.work.follow_wheel(plan.plunge_axis, way)

    def linear(self, command: Command, ahead: Ahead) -> list[MoveSection]:
        table = self.timeline.reciprocation
        letters = "XYZ" if table is None else "XYZ" + motion_paths.INTEGRANDS[table.axis]
        if command.modes.compensation == "G40" and self.compensation.programmed is not None:
            letters += "".join(motion_paths.INTEGRANDS[axis] for axis in PLANES[command.modes.plane])
        strange = next((letter for letter in "IJK" if letter in command.words and letter not in letters), None)
        if table is None and strange is not None:
            message = f"{command.words[strange]} has no meaning in this {command.action} block"
            reason = "for no table reciprocates; give it in the block of the cycle"
            raise command.error("block-format", f"{message}, {reason}", strange)
        command.allow_only(letters, f"this {command.action} block")
        if not command.lengths:
            return []
        start = self.position
        origin = ORIGIN if command.in_machine else self._origin(command)
        path = Straight(start, motion_paths.target(command, start, origin, self._reciprocating))
        return self._sections(command, path, ahead) if path.length > 0.0 or self.detour is not None else []

    def feed_end(self, command: Command) -> Position | None:
        """Return the end of a G01 block from rest, without compensation, mm; None for any other block."""
        stands = self._reciprocating is None and self.recorder is None and self.detour is None
        compensated = command.modes.compensation != "G40" or self.compensation.programmed is not None
        if command.action != "G01" or not command.lengths or not stands or compensated:
            return None
        if "T" in command.words or 98 in command.m:
            return None
        origin = ORIGIN if command.in_machine else self._origin(command)
        return motion_paths.target(command, self.position, origin, None)

    def circular(self, command: Command, ahead: Ahead) -> list[MoveSection]:
        path = motion_paths.arc_path(command, self.position, self._origin(command))
        if path is None:
            return []
        table = self._reciprocating
        if table is not None and path.moves(table):
            raise command.error(
                "axis-conflict",
                f"{command.action} moves {motion_paths.AXES[table]}, which reciprocates; program G80 before the arc",
            )
        return self._sections(command, path, ahead)

    def dwell(self, command: Command) -> Iterator[Event]:
        here = self.timeline.position
        speed = self.tooling.spindle_speed(command.modes, lambda: motion_paths.no_feed_rate(command))
        seconds = motion_paths.dwell_seconds(command, speed)
        yield from self.timeline.move(command.block.place, Straight(here, here), None, self.source, dwell=seconds)

    def reference(self, command: Command) -> list[MoveSection]:
        """G28, G29 and G30: rapid by way of the intermediate point, which cancels the compensation (lathe 21-49)."""
        command.allow_only("XYZP" if command.action == "G30" else "XYZ", f"a {command.action} block")
        axes = [axis for axis, letter in enumerate(motion_paths.AXES) if letter in command.lengths]
        if not axes:
            raise command.error("missing-parameter", f"{command.action} names no axis; X, Y or Z is needed")
        table = self._reciprocating
        if table is not None and table in axes:
            raise command.error(
                "axis-conflict",
                f"{command.action} moves {motion_paths.AXES[table]}, which reciprocates; program G80 before",
            )
        named = motion_paths.target(command, self.position, self._origin(command))
        if command.action == "G29":
            if self.passed is None:
                raise command.error("missing-parameter", "G29 has no intermediate point; G28 or G30 comes before it")
            stops = [self.passed, named]
        else:
            number = 2 if command.action == "G30" else 1
            if "P" in command.words:
                number = numbers.integer(command.block, command.words["P"], 1, len(self.control.reference_points))
            self.passed = named
            stops = [named, self.control.reference_points[number - 1]]
        programmed, here = self.position, self.timeline.position
        owed = [axis for axis in range(3) if axis not in axes and programmed[axis] != here[axis]]
        self.detour = None
        self.compensation.forget()
        goal = _moved(programmed, stops[-1], axes)
        points = [here, *(_moved(_moved(here, programmed, owed), stop, axes) for stop in stops)]
        paths = [Straight(start, end) for start, end in itertools.pairwise(points)]
        return [MoveSection(path, None, self.source, goal) for path in paths if path.length > 0.0]

    def groove(self, command: Command) -> Iterator[Event]:
        if self._reciprocating is not None:
            message = f"{command.action} is programmed during reciprocation; program G80 before"
            raise command.error("axis-conflict", message)
        self.detour = None
        self.refuse_displaced(command)
        origin, place = self._origin(command), command.block.place
        retract = self.control.groove_retract
        if retract is None:
            retract = INCH_RETRACT if command.modes.inch else METRIC_RETRACT
        plan = plan_groove(command, motion_paths.moved_by(self.timeline.position, origin, -1.0), retract)
        feed, groove = self.rate(command), 1
        self.timeline.budget.foresee(least_legs(plan), place)
        for leg in groove_legs(plan):
            self.timeline.budget.spend(place)
            if leg.groove != groove and self.control.panel.single_block:
                yield Hold(self.timeline.time, "single block")
            groove = leg.groove
            path = Straight(self.timeline.position, motion_paths.moved_by(leg.end, origin, 1.0))
            rate, mark = (feed, (plan.axis, leg.groove)) if leg.kind == "infeed" else (None, None)
            yield from self.timeline.move(place, path, rate, Source.CYCLE, groove=mark)
            if self.recorder is not None:
                self.recorder.note(path, rate)

    def refuse_displaced(self, command: Command) -> None:
        if command.modes.compensation == "G40" and self.position != self.timeline.position:
            raise command.error(
                "compensation", f"{command.action} comes before the exit move of the compensation; move to exit first"
            )

    def rate(self, command: Command) -> float:
        modes, missing = command.modes, functools.partial(motion_paths.no_feed_rate, command)
        speed = self.tooling.spindle_speed(modes, missing) if modes.per_revolution else None
        return motion_paths.feed_rate(modes, speed, self.control, missing)

    def retrace(self, recorder: Recorder) -> Iterator[Event]:
        for leg in recorder.way_back(self.timeline.position, self._link_feed):
            path = Straight(self.timeline.position, leg.end)
            if path.length > 0.0:
                yield from self.timeline.move(self.place, path, leg.feed, Source.RETRACE)
                if self.control.panel.single_block:
                    yield Hold(self.timeline.time, "single block")

    @property
    def _reciprocating(self) -> int | None:
        table = self.timeline.reciprocation
        return None if table is None else table.axis

    def _origin(self, command: Command) -> Position:
        return self.work.origin(command.modes.work_system)

    def _link_feed(self) -> float | None:
        if self.modes.motion == "G00":
            return None

        def missing() -> ControlError:
            return self.place.error(
                "no-feedrate", f"the way back under {self.modes.motion} has no F; program it before"
            )

        speed = self.tooling.spindle_speed(self.modes, self._no_wheel_radius)
        return motion_paths.feed_rate(self.modes, speed, self.control, missing)

    def _no_wheel_radius(self) -> ControlError:
        return self.place.error(
            "no-wheel-radius",
            "G96 needs the wheel radius; give grind check or trace the --job, or entry 33 of the radius table, as in "
            "--radius 33=150",
        )

    def _sections(self, command: Command, path: Path, ahead: Ahead) -> list[MoveSection]:
        feed = None if command.action == "G00" else self.rate(command)
        actual = self.timeline.position
        if self.detour is not None:
            self.detour, path = None, Straight(actual, path.end)
        return [
            MoveSection(
                piece.path,
                None if feed is None else feed * piece.share,
                Source.COMPENSATION if piece.generated else self.source,
                path.end,
            )
            for piece in self._pieces(command, path, actual, ahead)
            if piece.path.length > 0.0
        ]

    def _pieces(self, command: Command, path: Path, actual: Position, ahead: Ahead) -> list[Piece]:
        modes, compensation = command.modes, self.compensation
        compensated = modes.compensation in SIDES or compensation.offset is not None
        table = self._reciprocating
        if compensated and table is not None and table in PLANES[modes.plane]:
            raise command.error(
                "axis-conflict",
                f"{motion_paths.AXES[table]} of the plane of {modes.compensation} reciprocates; program G80 before",
            )
        if compensated and in_plane(path, modes.plane):
            outlook = Outlook(command, path.end, self._origin(command), self.work.length, table)
            return compensation.plan(command, path, actual, self.tooling.radius, ahead(outlook))
        if not compensated:
            compensation.programmed = None
        if path.start == actual:
            return [Piece(path)]
        if not isinstance(path, Straight):
            raise command.error(
                "block-format",
                f"{command.action} begins where the lapsed compensation has left the wheel; program a G01 before it",
            )
        axes = [axis for axis in range(3) if not compensated or path.start[axis] != path.end[axis]]
        return [Piece(Straight(actual, _moved(actual, path.end, axes)))]


def _moved(position: Position, goal: Position, axes: list[int]) -> Position:
    return placed(position, {axis: goal[axis] for axis in axes})

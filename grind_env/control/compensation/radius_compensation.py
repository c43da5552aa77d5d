"""The radius compensation from entry to exit: programmed motions become offset paths (chapter 15).

States of `radius-compensation.md` 2.6: without an offset the compensation is off, or armed if G41 or G42 is in
force; with one it is on. A junction is laid out when the motion before it is executed, from the motions ahead.
"""

from collections.abc import Iterator
from dataclasses import dataclass

from grind_env.control.block_decoding import Command
from grind_env.control.compensation.corners import (
    CompensationFault,
    Junction,
    compensated,
    corner,
    feed_share,
    side_change,
)
from grind_env.control.compensation.entry_exit import entry, exit_junction
from grind_env.control.compensation.geometry import NEGLIGIBLE_LENGTH, Element, Offset, PathArc, PathSegment, Point
from grind_env.control.compensation.gouging import GougeCheck
from grind_env.control.control_settings import Control
from grind_env.control.errors import Place
from grind_env.control.events import Position, placed
from grind_env.control.lookahead import REFERENCE_MOVES, Barrier, Prospect
from grind_env.control.modes import PLANES
from grind_env.control.motion_paths import INTEGRANDS
from grind_env.control.path_geometry import Circular, Path, Straight

SIDES = ("G41", "G42")
TOO_SMALL = "circular-departure-too-small"


@dataclass(frozen=True, slots=True)
class Piece:
    """A path to run; `share` is its centre feed as a share of F, `generated` marks a path that is not programmed."""

    path: Path
    generated: bool = False
    share: float = 1.0


class Compensation:
    """Radius compensation of one execution."""

    def __init__(self, control: Control) -> None:
        self.control = control
        self.offset: Offset | None = None  # offset in force where the axes stand; None while it is off or armed
        # the programmed point, machine coordinates; None if it equals the actual one
        self.programmed: Position | None = None
        self.plane = "G18"  # plane in which the programmed point differs from the actual one
        self.detect = True  # whether interference and backwards motion are errors (M801) or not (M800)
        self._gouge_check = GougeCheck()

    def position(self, actual: Position) -> Position:
        return actual if self.programmed is None else _lifted(_point(self.programmed, self.plane), actual, self.plane)

    def forget(self) -> None:
        """Drop the offset without a motion: the next motion in the plane is an entry, if G41 or G42 is in force."""
        self.offset = self.programmed = None

    def plan(
        self, command: Command, path: Path, actual: Position, radius: float, ahead: Iterator[Prospect | Barrier]
    ) -> list[Piece]:
        side = command.modes.compensation
        self.plane = command.modes.plane
        if self.offset is None:
            return self._leave(path, actual) if side == "G40" else self._enter(command, path, actual, radius, ahead)
        coming = None if side == "G40" else next(ahead)
        if coming is None or coming is Barrier.COORDINATES:
            _require_line(command, path, "exit")
            return self._leave(path, actual)
        return self._follow(command, path, actual, Offset.of(radius, side), coming, ahead)

    def refuse_plane(self, command: Command) -> None:
        plane = command.modes.plane
        if self.offset is not None and plane != self.plane and command.modes.compensation != "G40":
            raise command.error(
                "block-format", f"{plane} changes the plane under {command.modes.compensation}; program G40 before"
            )

    def _leave(self, path: Path, actual: Position) -> list[Piece]:
        self.offset = self.programmed = None
        return [Piece(path if path.start == actual else Straight(actual, path.end))]

    def _enter(
        self, command: Command, path: Path, actual: Position, radius: float, ahead: Iterator[Prospect | Barrier]
    ) -> list[Piece]:
        _require_line(command, path, "entry")
        plane, settings = command.modes.plane, self.control
        first, second = PLANES[plane]
        if settings.strict_entry_both_axes and (
            path.start[first] == path.end[first] or path.start[second] == path.end[second]
        ):
            raise command.error("block-format", "the entry move moves one axis of the plane; it must move both")
        coming = next(ahead)
        if coming is Barrier.COORDINATES:
            return self._leave(path, actual)
        following, side = None, command.modes.compensation
        if isinstance(coming, Prospect) and coming.command.modes.plane == plane:
            following = flat(coming.path, plane)
            side = coming.command.modes.compensation if coming.command.modes.compensation in SIDES else side
        offset = Offset.of(radius, side)
        move = PathSegment(_point(actual, plane), _point(path.end, plane))
        if move.length > NEGLIGIBLE_LENGTH:
            elements = entry(move, following, offset, settings.compensation_type, command.modes.corner == "G39.1")
        else:  # a lapsed compensation has left the wheel where this move ends
            to = offset.beside_end(flat(path, plane)) if following is None else offset.beside_start(following)
            elements = (PathSegment(move.start, to),)
        self.offset, self.programmed, self._gouge_check = offset, path.end, GougeCheck()
        paths = _paths(elements, actual, path.end, plane)
        pieces = [Piece(each, generated=index > 0) for index, each in enumerate(paths)]
        return pieces + self._lapse(coming, path.end, plane, elements[-1].end)

    def _follow(
        self,
        command: Command,
        path: Path,
        actual: Position,
        after: Offset,
        coming: Prospect | Barrier,
        ahead: Iterator[Prospect | Barrier],
    ) -> list[Piece]:
        plane, before = command.modes.plane, self.offset
        assert before is not None  # the compensation is on
        element, start = flat(path, plane), _point(actual, plane)
        place = coming.command.block.place if isinstance(coming, Prospect) else command.block.place
        try:
            junction = self._junction(command, element, coming, ahead, after)
            generated = junction.generated
            if before != after and isinstance(element, PathArc):
                arrival = before.beside_end(element)
                generated = (PathSegment(arrival, junction.end), *generated)
                junction = Junction(arrival, generated)
            run: tuple[Element, ...] = (
                (PathSegment(start, junction.end),)
                if before != after and isinstance(element, PathSegment)
                else compensated(element, start, junction.end, before, self.detect)
            )
            share = feed_share(element, before, self.control.minimum_feed_reduction)
        except CompensationFault as fault:
            own = command.block.place if fault.element is element else place
            at = own if fault.name == TOO_SMALL else place
            raise at.error(fault.name, f"{fault.subject}{_seen_from(at, own)} {fault.predicate}") from None
        if self.detect and command.action != "G00":
            self._refuse_gouging(command, path, element, (*run, *generated), before.radius)
        self.programmed = path.end
        pieces = [Piece(each, share=share) for each in _paths(run, actual, path.end, plane)]
        pieces += [Piece(each, generated=True) for each in _paths(generated, path.end, path.end, plane)]
        return pieces + self._lapse(coming, path.end, plane, generated[-1].end if generated else junction.end)

    def _refuse_gouging(
        self, command: Command, path: Path, element: Element, centre: tuple[Element, ...], radius: float
    ) -> None:
        third = 3 - sum(PLANES[command.modes.plane])
        level, own = path.end[third], command.block.place
        if path.start[third] != level:
            return
        gouged = self._gouge_check.follow(own, element, centre, level)
        if gouged is not None:
            raise command.error(
                "interference",
                f"between block {own.block} and block {gouged.block}{_seen_from(own, gouged)} there is no room for a "
                f"wheel of radius {radius:.4f} mm, which cuts into one; use a smaller radius or leave more room",
            )

    def _junction(
        self,
        command: Command,
        element: Element,
        coming: Prospect | Barrier,
        ahead: Iterator[Prospect | Barrier],
        after: Offset,
    ) -> Junction:
        settings, circular = self.control, command.modes.corner == "G39.1"
        self.offset = after
        if isinstance(coming, Barrier) or coming.command.modes.plane != command.modes.plane:
            return Junction(after.beside_end(element), ())
        side, coming_path = coming.command.modes.compensation, flat(coming.path, command.modes.plane)
        leaves = side == "G40" or coming.command.action in REFERENCE_MOVES or next(ahead) is Barrier.COORDINATES
        if leaves and isinstance(coming_path, PathSegment):
            vector = _vector(coming.command) if side == "G40" else None
            return exit_junction(element, coming_path, after, settings.compensation_type, circular, vector)
        if leaves:  # the circular exit is refused when its block is executed
            return Junction(after.beside_end(element), ())
        beyond = Offset.of(after.table_radius, side)
        if beyond.side != after.side:
            self.offset = beyond
            return side_change(element, coming_path, after, beyond)
        try:
            return corner(element, coming_path, after, circular, settings.minimum_generated_block)
        except CompensationFault as fault:
            if self.detect or fault.name == TOO_SMALL:
                raise
            return side_change(element, coming_path, after, after)

    def _lapse(self, coming: Prospect | Barrier, end: Position, plane: str, at: Point) -> list[Piece]:
        """End the compensation where no motion in the plane comes soon enough (15-20, lathe 21-17)."""
        if coming is Barrier.CANCELLED:
            self.offset = self.programmed = None
            return [Piece(solid(PathSegment(at, _point(end, plane)), end, end, plane), generated=True)]
        if isinstance(coming, Barrier) or coming.command.action in REFERENCE_MOVES:
            self.offset = None
        return []


def flat(path: Path, plane: str) -> Element:
    """Return the projection of a path on the plane."""
    start, end = _point(path.start, plane), _point(path.end, plane)
    if isinstance(path, Straight):
        return PathSegment(start, end)
    return PathArc(start, end, _point(path.centre, plane), path.rotation)


def solid(element: Element, start: Position, end: Position, plane: str) -> Path:
    """Return the path in space above an element of the plane; its third coordinate runs from `start` to `end`."""
    foot, head = _lifted(element.start, start, plane), _lifted(element.end, end, plane)
    if isinstance(element, PathSegment):
        return Straight(foot, head)
    return Circular(foot, head, _lifted(element.centre, start, plane), element.rotation, plane)


def _paths(elements: tuple[Element, ...], start: Position, end: Position, plane: str) -> list[Path]:
    return [solid(element, end if index else start, end, plane) for index, element in enumerate(elements)]


def _point(position: Position, plane: str) -> Point:
    first, second = PLANES[plane]
    return position[first], position[second]


def _lifted(point: Point, position: Position, plane: str) -> Position:
    return placed(position, dict(zip(PLANES[plane], point, strict=True)))


def _vector(command: Command) -> Point | None:
    """Return the I, J, K words of an exit block along the plane's axes; None without them or if all are 0 (15-26)."""
    letters = [INTEGRANDS[axis] for axis in PLANES[command.modes.plane]]
    u, v = (command.lengths[letter].mm if letter in command.lengths else 0.0 for letter in letters)
    return (u, v) if u or v else None


def _require_line(command: Command, path: Path, move: str) -> None:
    if not isinstance(path, Straight):
        raise command.error(
            "block-format", f"{command.action} is the {move} move of the radius compensation; it must be G00 or G01"
        )


def _seen_from(place: Place, own: Place) -> str:
    if own.file != place.file:
        return f" in line {own.line} of {own.file}"
    if own.line != place.line:
        return f" in line {own.line}"
    return f" in column {own.column}" if own.column != place.column else ""

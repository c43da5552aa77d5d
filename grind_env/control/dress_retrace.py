"""Record of the moves of a dress or interrupt program, and the retrace along them (22-11)."""

from collections.abc import Callable
from dataclasses import dataclass, field

from grind_env.control.events import Position
from grind_env.control.path_geometry import Circular, Path

REMEMBERED = 4  #: default number of remembered linear moves; M900 to M904 change it


@dataclass(frozen=True, slots=True)
class Leg:
    """A straight move to `end`; `feed` is mm/min, None for a rapid."""

    end: Position
    feed: float | None


@dataclass(slots=True)
class Recorder:
    """Record of the first linear moves of a dress program, up to the first circular one."""

    start: Position
    limit: int
    legs: list[Leg] = field(default_factory=list)
    stopped: bool = False
    moved: bool = False

    def note(self, path: Path, feed: float | None) -> None:
        self.moved = True
        self.stopped |= isinstance(path, Circular)
        if not self.stopped and len(self.legs) < self.limit:
            self.legs.append(Leg(path.end, feed))

    def way_back(self, position: Position, link: Callable[[], float | None]) -> list[Leg]:
        """Return the moves from `position` back to the start.

        A straight link, at a feed that `link` returns in mm/min, leads to the end of the last remembered move, unless
        the axes stand there; then each move is run backwards at its own rate. Without remembered moves the link leads
        to the start itself.
        """
        points = [self.start, *(leg.end for leg in self.legs)]
        back = [Leg(points[-1], link())] if position != points[-1] else []
        return back + [
            Leg(point, leg.feed) for point, leg in zip(reversed(points[:-1]), reversed(self.legs), strict=True)
        ]

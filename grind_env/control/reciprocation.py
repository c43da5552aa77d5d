"""State of the reciprocating axis between and within strokes (chapter 16 of the manual)."""

from dataclasses import dataclass, field
from enum import Enum

from grind_env.control.cycle_formulas import motion_time
from grind_env.control.errors import Place
from grind_env.control.events import CyclePlan, Position
from grind_env.control.execution_limits import Rounds
from grind_env.control.motion_profile import travelled


class Reversal(Enum):
    """The point at which the reciprocating axis rests or from which it set out."""

    START = "start"
    PRIMARY = "primary"
    SECONDARY = "secondary"


@dataclass(slots=True)
class Underway:
    """A stroke that has begun; `middle` is filled in when the axis passes it."""

    start: Position
    origin: float
    target: float
    begin: float
    travel: float
    finish: float
    feed: float
    acceleration: float
    middle: Position | None = None

    @property
    def length(self) -> float:
        return abs(self.target - self.origin)

    @property
    def middle_time(self) -> float:
        return self.begin + 0.5 * self.travel

    def coordinate(self, time: float) -> float:
        if time >= self.begin + self.travel:
            return self.target
        done = travelled(time - self.begin, self.length, self.feed / 60.0, self.acceleration)
        return self.origin + (done if self.target > self.origin else -done)


@dataclass(slots=True)
class Reciprocation:
    """A reciprocating axis."""

    plan: CyclePlan  #: the cycle that started it
    place: Place  #: place of the block of that cycle
    primary: float  #: primary reversal point in force, mm
    secondary: float  #: secondary reversal point in force, mm
    feed: float  #: E of the next stroke, mm/min
    coordinate: float  #: coordinate of the axis at the last point of rest, mm
    free_at: float  #: time from which the next stroke can begin, s
    at: Reversal = Reversal.START  #: the last point of rest
    count: int = 0  #: strokes made since the cycle took over
    dresses: int = 0  #: dresses since the cycle took over
    in_cycle: bool = False  #: whether the strokes belong to a G82 or G83 block under execution
    underway: Underway | None = None  #: the stroke in progress
    feed_reprogrammed: bool = False  #: whether a block after the cycle has set `feed`, even to the same number
    auto_dresses: Rounds = field(init=False)  #: auto-dresses by D of the cycle

    @property
    def axis(self) -> int:
        return self.plan.axis

    @property
    def at_reversal(self) -> bool:
        return self.underway is None and (
            self.at is not Reversal.START or self.coordinate in (self.primary, self.secondary)
        )

    @property
    def at_secondary(self) -> bool:
        """Return whether the axis is at the secondary point, where a new cycle takes over (PD-23)."""
        starts_there = self.at is Reversal.START and self.coordinate == self.secondary
        return self.underway is None and (self.at is Reversal.SECONDARY or starts_there)

    def take_over(self, plan: CyclePlan, place: Place) -> None:
        self.plan, self.place = plan, place
        self.primary, self.secondary, self.feed = plan.primary, plan.secondary, plan.feed
        self.at, self.count, self.dresses, self.feed_reprogrammed = Reversal.SECONDARY, 0, 0, False

    def begin(self, position: Position, feed: float, acceleration: float, dwell: float) -> Underway:
        """Begin a stroke at `feed`, mm/min, to the other reversal point; from the start point, to the primary one."""
        target = self.secondary if self.at is Reversal.PRIMARY else self.primary
        travel = motion_time(abs(target - self.coordinate), feed / 60.0, acceleration)
        finish = self.free_at + travel + dwell
        self.underway = Underway(position, self.coordinate, target, self.free_at, travel, finish, feed, acceleration)
        return self.underway

    def arrive(self) -> None:
        assert self.underway is not None
        self.coordinate, self.free_at = self.underway.target, self.underway.finish
        self.at = Reversal.SECONDARY if self.at is Reversal.PRIMARY else Reversal.PRIMARY
        self.underway = None
        self.count += 1

    def make(self, strokes: int, dresses: int, free_at: float) -> None:
        self.count, self.dresses, self.free_at = strokes, self.dresses + dresses, free_at
        self.at = Reversal.PRIMARY if strokes % 2 else Reversal.SECONDARY
        self.coordinate = self.primary if strokes % 2 else self.secondary

"""Events of a part program: the motions of the machine, in the order in which they end.

Picks are the exception: each follows its stroke. A short pick ends before its stroke, a slow one after later events.

In all programs, positions are machine coordinates (X, Y, Z) in mm, times are s from the start of the program, and
feeds are mm/min.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from typing import TypeAlias

from grind_env.control.block_words import Block
from grind_env.control.modal_state import Modes

Position: TypeAlias = tuple[float, float, float]  #: X, Y, Z in mm


def placed(position: Position, coordinates: Mapping[int, float]) -> Position:
    """Return `position` with the given coordinates on some axes, mm."""
    changed = list(position)
    for axis, coordinate in coordinates.items():
        changed[axis] = coordinate
    return changed[0], changed[1], changed[2]


class Source(str, Enum):
    """Source of a motion: the program, a cycle, a dress, a retrace, the radius compensation or an interrupt."""

    PROGRAM = "program"
    CYCLE = "cycle"
    DRESS = "dress"
    RETRACE = "retrace"
    COMPENSATION = "compensation"
    INTERRUPT = "interrupt"


@dataclass(frozen=True, slots=True, kw_only=True)
class CyclePlan:
    """Parameters of a surface-grinding cycle with every default filled in (table 16.C).

    Axes are 0 = X, 1 = Y, 2 = Z; coordinates are mm; picks are mm, positive, towards their target. A G81 has
    neither plunge nor cross axis and its picks are 0.
    """

    code: str  #: G81, G82 or G83; G01 for a feed move that `machine` takes as a stroke
    pre_dress: bool  #: whether the code was programmed with ``.1``, so that a dress precedes the cycle
    axis: int  #: the reciprocating axis
    plunge_axis: int | None = None  #: None for G81
    cross_axis: int | None = None  #: None for G81 and G82
    primary: float  #: primary reversal point, mm
    secondary: float  #: secondary reversal point, mm
    plunge_start: float = 0.0  #: position of the plunge axis before the cycle, mm
    depth_target: float = 0.0  #: plunge depth (Y in G19) as a coordinate, mm
    primary_pick: float = 0.0  #: J, plunge pick at the primary reversal, mm; in G83 at the cross start
    secondary_pick: float = 0.0  #: Q, plunge pick at the secondary reversal, mm; in G83 at the crossover end
    cross_start: float = 0.0  #: position of the cross axis before the cycle, mm
    cross_end: float = 0.0  #: crossover (Z in G19) as a coordinate, mm
    primary_cross_pick: float = 0.0  #: K, cross pick at the primary reversal, mm
    secondary_cross_pick: float = 0.0  #: R, cross pick at the secondary reversal, mm
    spark_out: int = 0  #: L, the number of spark-out passes
    pick_feed: float = 0.0  #: F, mm/min
    feed: float  #: E, mm/min
    program: int | None  #: P, the dress program; None if none is known
    dresses: int = 0  #: D, the auto-dress executions
    block: int  #: N word of the cycle block, or its line number
    line: int  #: line of the cycle block in the file
    text: str  #: text of the cycle block

    @property
    def plunges(self) -> bool:
        """Return True if the cycle ends at a depth; otherwise the table reciprocates while the program continues."""
        return self.plunge_axis is not None

    @property
    def depth(self) -> float:
        """Total plunge depth, mm."""
        return abs(self.depth_target - self.plunge_start)


@dataclass(frozen=True, slots=True, kw_only=True)
class Motion:
    """A motion or dwell.

    `start` and `end` are mm, `begin` and `seconds` s; `inch` says whether inches are in force for output.
    """

    start: Position
    end: Position
    begin: float
    seconds: float
    block: int
    line: int
    source: Source
    inch: bool

    @property
    def finish(self) -> float:
        """Time at which the motion ends, s."""
        return self.begin + self.seconds


@dataclass(frozen=True, slots=True, kw_only=True)
class Rapid(Motion):
    """G00: a straight line at rapid speed."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Line(Motion):
    """G01: a straight line at `feed`, mm/min along the path.

    `reciprocating` says whether the table reciprocates at the same time.
    """

    feed: float
    reciprocating: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class Arc(Motion):
    """G02 or G03 at `feed`, mm/min, about `centre`, mm.

    `rotation` is 1 for G03, seen from the positive end of the axis normal to the plane.
    """

    feed: float
    centre: Position
    rotation: int
    plane: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Dwell(Motion):
    """G04: a pause."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Stroke(Motion):
    """One pass of the reciprocating axis to its next reversal point.

    `start`, `middle` and `end` are the positions of all axes at those moments, and include a program motion under
    way. A pick under way shows in `middle` only: `start` counts it as complete, and `end` counts the pick of
    its reversal as not yet begun. The reversal dwell is part of `seconds`.
    """

    middle: Position  #: position when the reciprocating axis passes the middle of the stroke, mm
    axis: int  #: the reciprocating axis
    feed: float  #: E, mm/min
    number: int | None  #: 1, 2, ... within a G82 or G83; None for G81 and for reciprocation after a cycle
    cycle: CyclePlan  #: plan of the cycle to which the stroke belongs


@dataclass(frozen=True, slots=True, kw_only=True)
class Pick(Motion):
    """An infeed at a reversal, begun as the reciprocating axis decelerates (PD-22).

    The reciprocating axis is shown at the reversal point; overlap shows in the times only. `kind` is "plunge"
    or "cross", `feed` is F in mm/min.
    """

    axis: int
    feed: float
    kind: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Infeed(Motion):
    """An infeed of a grooving cycle G76 or G77 along `axis` at `feed`, mm/min; `groove` counts from 1."""

    axis: int
    feed: float
    groove: int


@dataclass(frozen=True, slots=True)
class Instant:
    """An event without duration."""

    time: float  #: time of the event, s


@dataclass(frozen=True, slots=True)
class CycleAhead(Instant):
    """A cycle block is about to be executed; `Execution.choose` may still change its E and D words."""

    block: Block


@dataclass(frozen=True, slots=True)
class FeedAhead(Instant):
    """A G01 block without radius compensation is about to be executed with the table at rest.

    The move leads from `start` to `end`, mm. `Execution.choose` may still change its F word.
    """

    block: Block
    start: Position
    end: Position


@dataclass(frozen=True, slots=True)
class CycleStart(Instant):
    """A cycle takes over, before its pre-dress."""

    plan: CyclePlan  #: plan of the cycle
    variables: Mapping[int, float]  #: values of the `#` variables when its dresses begin; no unit of their own
    modes: Modes  #: modal state when its dresses begin
    origins: Mapping[str, Position]  #: origins of the work systems by code when its dresses begin, mm; with every shift


@dataclass(frozen=True, slots=True, kw_only=True)
class CycleStrokes:
    """All strokes and picks of an undisturbed G82 or G83 in one event.

    `machine` also uses this class for a single stroke, of any cycle or of a feed move.
    """

    time: float  #: end of the last stroke, s, without the time of the auto-dresses
    plan: CyclePlan  #: plan of the cycle
    start: Position  #: position of all axes when the table sets out, mm
    feed: float  #: E in force, mm/min
    begins: tuple[float, ...]  #: time at which each stroke begins, s
    seconds: tuple[float, ...]  #: duration of each stroke, s; the first one leads from `start` to the primary point
    plunge: tuple[float, ...]  #: coordinate of the plunge axis in the middle of each stroke, mm
    cross: tuple[float, ...]  #: coordinate of the third axis in the middle of each stroke, mm
    end: Position  #: position of all axes after the last stroke and its picks, mm
    #: for each auto-dress, the number of strokes before it and the time at which the axes stand for it, s; the dresses
    #: have not been executed
    dresses: tuple[tuple[int, float], ...]
    inch: bool  #: whether inches are in force for output

    @property
    def turns(self) -> tuple[float, float]:
        """Coordinates at which the first and the second stroke end, mm; of a single stroke, its end and its start."""
        if len(self.begins) > 1:
            return self.plan.primary, self.plan.secondary
        return self.end[self.plan.axis], self.start[self.plan.axis]

    def ends(self, k: int) -> tuple[float, float]:
        """Coordinates of the reciprocating axis where stroke k, counted from 0, begins and ends, mm."""
        return self.turns[(k + 1) % 2] if k else self.start[self.plan.axis], self.turns[k % 2]


@dataclass(frozen=True, slots=True)
class CycleEnd(Instant):
    """A cycle is complete (G82, G83; reciprocation goes on), or its reciprocation has ended (G81)."""

    plan: CyclePlan
    strokes: int
    dresses: int


@dataclass(frozen=True, slots=True)
class TableStop(Instant):
    """The table stops at a reversal point; only with `announce_cycles`. `Execution.move_axis` may still move it."""

    plan: CyclePlan


@dataclass(frozen=True, slots=True)
class DressStart(Instant):
    """A dress program begins, all axes at rest; `cause` is "pre", "auto" or "operator"."""

    program: int
    cause: str


@dataclass(frozen=True, slots=True)
class DressEnd(Instant):
    """The wheel is back at the point where the dress began."""

    program: int
    cause: str


@dataclass(frozen=True, slots=True)
class InterruptStart(Instant):
    """A program interrupt of type 1 or 2 begins."""

    program: int
    kind: int


@dataclass(frozen=True, slots=True)
class InterruptEnd(Instant):
    """A program interrupt has reached its M99; one of type 2 has also returned to the point where it began."""

    program: int
    kind: int


@dataclass(frozen=True, slots=True)
class ProgramStop(Instant):
    """M00 or M01 after the motion of its block; `reciprocating` says whether the table still reciprocates."""

    code: str
    block: int
    line: int
    reciprocating: bool


@dataclass(frozen=True, slots=True)
class ProgramEnd(Instant):
    """The program ends; `cause` is "M02", "M30" or "text end"."""

    cause: str


@dataclass(frozen=True, slots=True)
class Spindle(Instant):
    """The commanded speed of the wheel changes to `speed`, revolutions per minute.

    `surface` is the surface speed that G96 holds, m/min, and 0 under G97.
    """

    speed: float
    surface: float = 0.0


@dataclass(frozen=True, slots=True)
class Switch(Instant):
    """The wheel or the coolant is switched: `turning` by M03, M04 and M05, `coolant` by M07, M08 and M09.

    `turning` is 1 after M03, -1 after M04 (the other direction) and 0 after M05.
    """

    turning: int
    coolant: bool


@dataclass(frozen=True, slots=True)
class Hold(Instant):
    """All axes wait for the operator; `cause` is "single block", "feedhold" or "override"."""

    cause: str


@dataclass(frozen=True, slots=True)
class Message(Instant):
    """A message of the control to the operator."""

    text: str


Event: TypeAlias = Motion | CycleStrokes | Instant

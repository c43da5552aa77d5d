"""The settings of the control that a part program cannot give, and its operator panel."""

import math
import sys
from collections.abc import Mapping
from dataclasses import dataclass, field

from grind_env.control.errors import ControlError
from grind_env.control.events import Position
from grind_env.control.macro_variables import KINDS, LARGEST_VALUE, LOCALS, is_common
from grind_env.control.numbers import STANDARD, NumberFormat
from grind_env.control.operator_actions import HIGHEST_OVERRIDE, Interrupt, Panel

ORIGIN: Position = (0.0, 0.0, 0.0)
MOST_NON_MOTION_BLOCKS = 999
#: default limit of executed blocks and strokes: enough for 3000 parts of more than a hundred strokes each
BLOCK_BUDGET = 500_000
WHEEL_RADIUS = 33  #: entry of the radius table that the in-process dresser keeps up to date (15-11)


@dataclass(frozen=True, slots=True)
class Control:
    """Machine parameters (AMP), tables and switches; its methods are the operator panel.

    A method acts on the program that the control executes, from the next motion on. The tables hold the values at the
    start: G10 and the dresser change copies that last as long as the execution.

    Raises:
        ControlError: setting, a value outside its range.
    """

    acceleration: float = 1000.0  #: acceleration of every axis, mm/s^2; linear ramps (PD-21)
    rapid_feed: float = 20_000.0  #: speed along the path of G00, mm/min
    maximum_feed: float = 60_000.0  #: F and E above it are clamped to it (12-60), mm/min
    reversal_dwell: float = 0.0  #: rest of the table at every reversal, s; part of the time of the stroke before it
    strokes: int = 10  #: number of strokes of a G81 that still runs at the end of the text (ruling 11)
    coverage_pass: bool = True  #: whether a pass over the part at full depth precedes the L spark-out passes (PD-13)
    block_delete: bool = False  #: whether blocks that begin with ``/`` are skipped
    start: Position = ORIGIN  #: position of the axes X, Y, Z at the start, mm
    operator_dress_at: tuple[float, ...] = ()  #: times at which the operator asks for a dress, s, ascending
    interrupts: tuple[Interrupt, ...] = ()  #: program interrupts requested at given times, ascending
    block_budget: int = BLOCK_BUDGET  #: blocks and strokes, dress programs included, that a program may execute
    number_format: NumberFormat = STANDARD  #: digits of lengths and feeds, and how missing zeros are read
    #: values that ``#`` variables, local or common ones, have at the start; no unit of their own
    variables: Mapping[int, float] = field(default_factory=dict)
    compensation_type: str = "A"  #: "A" or "B", the shape of entry and exit moves of the radius compensation
    radius: float = 0.0  #: radius of dresser or wheel before the first T word and for entries missing in `radii`, mm
    #: radius table by the first two digits of T, mm; negative swaps the sides of G41 and G42 (15-5)
    radii: Mapping[int, float] = field(default_factory=dict)
    #: length offsets by the last two digits of T, mm, added to the work origin
    lengths: Mapping[int, Position] = field(default_factory=dict)
    entire_wheel: bool = False  #: whether the radius replaces the X length offset (15-11)
    non_motion_blocks: int = 2  #: successive blocks without motion in the plane that compensation survives (15-20)
    minimum_generated_block: float = 0.0  #: generated blocks shorter on both axes are dropped, mm (mill manual 21-42)
    minimum_feed_reduction: float = 0.1  #: least share of F on inside arcs (12-55)
    strict_entry_both_axes: bool = False  #: whether an entry move must move both axes of the plane (15-12)
    work_offsets: Mapping[str, Position] = field(default_factory=dict)  #: origins of G54 to G59.3 by their code, mm
    external_offset: Position = ORIGIN  #: shift of all work origins (11-10), mm
    #: reference points of G28 or G30 P1, and of G30 P2 to P4, mm
    reference_points: tuple[Position, Position, Position, Position] = (ORIGIN, ORIGIN, ORIGIN, ORIGIN)
    groove_retract: float | None = None  #: retract amount e of G76 and G77, mm; None for 0.5 mm, or 0.02 in under G70
    dress_amount: float = 0.0  #: depth that one dress removes from the wheel radius of entry 33, mm
    minimum_radius: float = 0.0  #: wheel radius below which the operator is warned, mm
    #: whether a `CycleAhead` comes before every cycle block, and a `TableStop` where the table stops
    announce_cycles: bool = False
    #: whether a `FeedAhead` comes before every G01 block without compensation, with the table at rest
    announce_feeds: bool = False
    #: whether an undisturbed G82 or G83 is one `CycleStrokes` instead of an event for every stroke and pick.
    #: Auto-dresses are included: their program is executed until one execution has left the tables of the control
    #: unchanged.
    whole_cycles: bool = False
    panel: Panel = field(default_factory=Panel, init=False, compare=False, repr=False)

    def __post_init__(self) -> None:
        above_zero, largest, most = math.nextafter(0.0, 1.0), sys.float_info.max, MOST_NON_MOTION_BLOCKS
        retract = () if self.groove_retract is None else ("groove_retract",)
        for low, high, legal, names in (
            (above_zero, largest, "a finite number above 0", ("acceleration", "rapid_feed", "maximum_feed", *retract)),
            (0.0, largest, "0 or more", ("reversal_dwell", "minimum_generated_block")),
            (0.0, largest, "0 or more", ("minimum_radius", "dress_amount")),
            (1, math.inf, "1 or more", ("strokes", "block_budget")),
            (0, most, f"0 to {most}", ("non_motion_blocks",)),
            (above_zero, 1.0, "above 0 and at most 1", ("minimum_feed_reduction",)),
        ):
            for name in names:
                if not low <= getattr(self, name) <= high:
                    raise ControlError("setting", f"{name} is {getattr(self, name)}; it must be {legal}")
        if self.compensation_type not in ("A", "B"):
            raise ControlError("setting", f'compensation_type is {self.compensation_type!r}; it must be "A" or "B"')
        for number, radius in ((None, self.radius), *self.radii.items()):
            if not math.isfinite(radius):
                entry = "radius" if number is None else f"radius {number}"
                raise ControlError("setting", f"{entry} is {radius}; it must be a finite number in mm")
        for number, value in self.variables.items():
            if number not in LOCALS and not is_common(number):
                raise ControlError("setting", f"variable #{number} cannot be set at the start; {KINDS}, which can")
            if not isinstance(value, int | float) or not abs(value) < LARGEST_VALUE:
                legal = f"a number below {LARGEST_VALUE:g} in size"
                raise ControlError("setting", f"variable #{number} is {value!r}; it must be {legal}")
        points = {"start": self.start, "external_offset": self.external_offset}
        points |= {f"the origin of {code}": point for code, point in self.work_offsets.items()}
        points |= {f"length offset {number}": point for number, point in self.lengths.items()}
        points |= {f"reference point {number}": point for number, point in enumerate(self.reference_points, 1)}
        for name, point in points.items():
            if len(point) != 3 or not all(math.isfinite(coordinate) for coordinate in point):
                raise ControlError("setting", f"{name} is {point}; it must be three finite coordinates in mm")
        times = self.operator_dress_at
        if not all(math.isfinite(time) and time >= 0.0 for time in times) or list(times) != sorted(times):
            raise ControlError("setting", f"operator_dress_at is {times}; it must be ascending times in s")
        if list(self.interrupts) != sorted(self.interrupts, key=lambda interrupt: interrupt.at):
            raise ControlError("setting", "the times of interrupts do not ascend; sort them")

    def length_offset(self, entry: int) -> Position:
        """Return the length offset of an entry, mm; X is 0 if the radius replaces it (`entire_wheel`, 15-11)."""
        x, y, z = self.lengths.get(entry, ORIGIN)
        return 0.0 if self.entire_wheel else x, y, z

    def request_dress(self) -> None:
        """Ask for a dress at the next reversal point; several requests before it make one dress (22-11)."""
        self.panel.dress_requested = True

    def override(self, percent: float) -> None:
        """Set the feedrate override of F and E, 0 to 200 %; 0 holds the axes (PD-16).

        Raises:
            ControlError: setting, outside the range.
        """
        if not 0.0 <= percent <= HIGHEST_OVERRIDE:
            legal = f"it must be 0 to {HIGHEST_OVERRIDE:g}"
            raise ControlError("setting", f"an override of {percent} % is impossible; {legal}")
        self.panel.override = percent / 100.0

    def feedhold(self) -> None:
        """Hold the axes before the next motion until `resume` (PD-16)."""
        self.panel.held = True

    def resume(self) -> None:
        """End a feedhold: the cycle start button."""
        self.panel.held = False

    def single_block(self, on: bool = True) -> None:
        """Stop after every block, every leg of a dress and every groove; to go on, take the next event."""
        self.panel.single_block = on

    def interrupt(self, program: int, kind: int = 2) -> None:
        """Request a program interrupt at the end of the latest motion.

        Raises:
            ControlError: setting, no such type of interrupt.
        """
        self.panel.interrupts.append(Interrupt(program, kind, immediate=False))

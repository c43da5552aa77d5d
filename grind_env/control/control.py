"""Settings of the control and its machine that a part program cannot give."""

import math
from dataclasses import dataclass

from grind_env.control.errors import ControlError, Place
from grind_env.control.motions import Position


@dataclass(frozen=True, slots=True)
class Control:
    """Machine parameters (AMP) and switches.

    Attributes:
        acceleration: of every axis, mm/s^2; linear ramps (PD-21).
        rapid_feed: speed along the path of G00, mm/min.
        maximum_feed: F and E above it are clamped to it (12-60), mm/min.
        reversal_dwell: rest of the table at every reversal, s; part of the time of the stroke before it.
        strokes: strokes made of a G81 that the text leaves running at its end (ruling 11).
        coverage_pass: whether a pass over the part at full depth precedes the L spark-out passes (PD-13).
        block_delete: whether blocks that begin with ``/`` are skipped.
        start: position of the axes X, Y, Z at the start, mm.
        operator_dress_at: times at which the operator asks for a dress, s, ascending.
        block_budget: blocks and strokes after which a program is taken to be endless.

    Raises:
        ControlError: a value outside its range.
    """

    acceleration: float = 1000.0
    rapid_feed: float = 20_000.0
    maximum_feed: float = 60_000.0
    reversal_dwell: float = 0.0
    strokes: int = 10
    coverage_pass: bool = True
    block_delete: bool = False
    start: Position = (0.0, 0.0, 0.0)
    operator_dress_at: tuple[float, ...] = ()
    block_budget: int = 1_000_000

    def __post_init__(self) -> None:
        """Refuse values that no machine has."""
        for name in ("acceleration", "rapid_feed", "maximum_feed"):
            value = getattr(self, name)
            if not 0.0 < value < math.inf:
                raise ControlError("setting", f"{name} is {value}; it must be a finite number above 0")
        if not 0.0 <= self.reversal_dwell < math.inf:
            raise ControlError("setting", f"reversal_dwell is {self.reversal_dwell}; it must be 0 s or more")
        for name in ("strokes", "block_budget"):
            if getattr(self, name) < 1:
                raise ControlError("setting", f"{name} is {getattr(self, name)}; it must be 1 or more")
        if len(self.start) != 3 or not all(math.isfinite(coordinate) for coordinate in self.start):
            raise ControlError("setting", f"start is {self.start}; it must be three finite coordinates in mm")
        times = self.operator_dress_at
        if not all(math.isfinite(time) and time >= 0.0 for time in times) or list(times) != sorted(times):
            raise ControlError("setting", f"operator_dress_at is {times}; it must be ascending times in s")


class Budget:
    """Counts blocks and strokes, so that no program runs without end."""

    def __init__(self, limit: int) -> None:
        self.limit = self.left = limit

    def spend(self, place: Place) -> None:
        """Count one; a `ControlError` says where the limit was passed."""
        self.left -= 1
        if self.left < 0:
            raise place.error(
                "block-budget",
                f"more than {self.limit} blocks and strokes were executed; a program must come to its M30",
            )

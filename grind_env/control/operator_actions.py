"""Operator actions at the panel while a program runs, and program interrupts."""

from collections import deque
from dataclasses import dataclass, field

from grind_env.control.errors import ControlError

HIGHEST_OVERRIDE = 200.0  #: highest feedrate override, percent of the programmed feed


@dataclass(frozen=True, slots=True)
class Interrupt:
    """A request to run a program in the middle of another one (lathe manual 29-6, 29-7).

    Raises:
        ControlError: setting, no such kind or a negative time.
    """

    program: int  #: O number of the interrupt program
    kind: int = 2  #: 1 goes on from where the interrupt program ends; 2 returns to the point of interruption first
    #: whether it may interrupt a motion of the part program, rather than wait for the end of the block
    immediate: bool = True
    at: float = 0.0  #: time of the request, s

    def __post_init__(self) -> None:
        if self.kind not in (1, 2):
            raise ControlError("setting", f"an interrupt of type {self.kind} is unknown; it must be 1 or 2")
        if not self.at >= 0.0:
            raise ControlError("setting", f"an interrupt at {self.at} s is impossible; the time must be 0 or more")


@dataclass(slots=True)
class Panel:
    """The operator's switches and requests, read by the control between two motions."""

    dress_requested: bool = False
    held: bool = False  #: feedhold
    single_block: bool = False
    override: float = 1.0  #: factor on every feed; 0 holds the axes
    interrupts: deque[Interrupt] = field(default_factory=deque)  #: requests not yet served

    @property
    def holding(self) -> str | None:
        """Return why the axes are held; None if they may move."""
        if self.held:
            return "feedhold"
        return "override" if self.override == 0.0 else None

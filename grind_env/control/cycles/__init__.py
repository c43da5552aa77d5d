"""The grinding cycles: one module with the rules of each cycle.

A cycle is a named tuple of numbers. Three functions handle its progress: `begin`, `after_reversal` (picks and dresses
after a stroke) and `finished`. The interpreter calls them as plain Python and `machine` compiles them, so they take
and return numbers and contain conditional expressions only. With `least_strokes` the control refuses a cycle of too
many strokes before it begins.
"""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple, Protocol

from grind_env.control.cycles import plunge, reciprocate, traverse
from grind_env.control.events import CyclePlan


class Progress(Protocol):
    """Progress of a cycle, as the interpreter reads it."""

    @property
    def depth(self) -> float:
        """Depth reached since the start of the plunge, mm."""

    @property
    def dresses(self) -> float:
        """Number of dresses at this reversal, before the next stroke."""


class Rules(NamedTuple):
    """The rules of a cycle."""

    #: function from the plan of a block, and whether there is a coverage pass (PD-13), to the numbers of the cycle
    cycle_of: Callable[[CyclePlan, bool], Any]
    begin: Callable[[Any], Progress]
    after_reversal: Callable[[Any, Any], Progress]
    finished: Callable[[Any, Any], bool]
    least_strokes: Callable[[Any], float]  #: function from a cycle to its least number of strokes
    #: function from progress and both ends of the crossover, mm, to the cross coordinate of the next stroke, mm; None
    #: for a cycle that does not cross
    cross: Callable[[Any, float, float], float] | None = None
    #: True if the cycle ends at a depth (G82, G83); False if its strokes continue during the next blocks (G81)
    plunges: bool = True


def _of(module: Any, **more: Any) -> Rules:
    return Rules(**{name: getattr(module, name) for name in Rules._fields if name not in Rules._field_defaults}, **more)


#: rules of every cycle, by its code without .1
RULES: Mapping[str, Rules] = {
    "G81": _of(reciprocate, plunges=False),
    "G82": _of(plunge),
    "G83": _of(traverse, cross=traverse.cross),
}


def list_codes(conjunction: str) -> str:
    """Return the codes of all cycles for a message, with "and" or "or" before the last."""
    *others, last = RULES
    return f"{', '.join(others)} {conjunction} {last}"

"""The grinding cycles: a module with the rules of each.

A cycle is a named tuple of numbers, and three functions of it and of how far it has come: `begin`, `after_reversal`
(what follows a stroke: picks, and the dresses that fall due) and `finished`. The interpreter calls them as they stand,
`machine` compiles them; so they take and give numbers and hold conditional expressions only. By `least_strokes` the
control refuses what is too much before it begins.
"""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple, Protocol

from grind_env.control.cycles import plunge, reciprocate, traverse
from grind_env.control.motions import CyclePlan


class Progress(Protocol):
    """Progress of a cycle, as the interpreter reads it."""

    @property
    def depth(self) -> float:
        """Depth reached since the start of the plunge, mm."""

    @property
    def dresses(self) -> float:
        """Executions to run at this reversal, before the next stroke."""


class Rules(NamedTuple):
    """The rules of a cycle."""

    cycle_of: Callable[[CyclePlan, bool], Any]
    """Its numbers from a block, with or without a coverage pass (PD-13)."""
    begin: Callable[[Any], Progress]
    after_reversal: Callable[[Any, Any], Progress]
    finished: Callable[[Any, Any], bool]
    least_strokes: Callable[[Any], float]
    """How many strokes it makes at least, of those of its own."""
    cross: Callable[[Any, float, float], float] | None = None
    """From its progress and the ends of the crossover, mm: cross coordinate of the next stroke; None if it does not
    cross."""
    plunges: bool = True
    """Whether it plunges to a depth of its own and then is done; if not, its strokes go on beside the program."""


def _of(module: Any, **more: Any) -> Rules:
    return Rules(**{name: getattr(module, name) for name in Rules._fields if name not in Rules._field_defaults}, **more)


RULES: Mapping[str, Rules] = {
    "G81": _of(reciprocate, plunges=False),
    "G82": _of(plunge),
    "G83": _of(traverse, cross=traverse.cross),
}
"""Rules of every cycle, by its code without .1."""


def codes_said(conjunction: str) -> str:
    """The codes of all cycles as a message lists them, with "and" or "or" before the last."""
    *others, last = RULES
    return f"{', '.join(others)} {conjunction} {last}"

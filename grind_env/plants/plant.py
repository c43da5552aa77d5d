"""A plant: the process and gauges of an out-of-model machine, and its numbers."""

import functools
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from grind_env.errors import GrindError
from grind_env.message_text import reason
from grind_env.plants.family import SEED, Family, word_of
from grind_env.process.gauge_readings import TRUTH, Gauge, chain_gauges
from grind_env.process.process_interface import PROCESS, Process, composed, joined


class PlantError(GrindError):
    """Unknown name of a machine, or an impossible machine."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Plant:
    """An out-of-model machine.

    Raises:
        PlantError: `own` has more or fewer numbers than process and gauge have fields.
    """

    name: str  #: name for `find_plant`
    process: Process = PROCESS  #: the grinding process, with its hooks before every block
    gauge: Gauge = TRUTH  #: gauge that gives the shown readings, to which the tasks add noise
    #: memory of process and gauge at the start of a shift, in this order and in the fields' units; () for the defaults
    own: tuple[float, ...] = ()
    anew: tuple[str, ...] = ()  #: fields that restart with every shift

    def __post_init__(self) -> None:
        fields = self.remembers._fields
        if not self.own:
            object.__setattr__(self, "own", tuple(self.remembers()))
        if len(self.own) != len(fields):
            raise PlantError(
                f"{self.name}: own has {len(self.own)} numbers, but process and gauge remember {len(fields)}: give one "
                f"for each of {', '.join(fields)}"
            )

    @property
    def remembers(self) -> type[Any]:
        """Return the record type whose fields `own` fills."""
        return joined(self.process.own, self.gauge.own)

    @property
    def of_process(self) -> tuple[float, ...]:
        """Return the process part of the memory, as a `Job` takes it."""
        return self.own[: len(self.process.own._fields)]

    def after(self, own: tuple[float, ...], shift: int) -> "Plant":
        """Return the same machine at the start of another shift, with new random events.

        Args:
            own: memory of process and gauge at the end of the shift before, in the order and the units of `own`.
            shift: a number of 32 bits, new for every shift.
        """

        def begins(name: str, first: float, last: float) -> float:
            if name.endswith(SEED):
                return float(word_of(int(first), shift, name))
            # PROCESS remembers only the heat of a part, and a shift begins with a new part
            return first if name in (*self.anew, *PROCESS.own._fields) else last

        return replace(self, own=tuple(map(begins, self.remembers._fields, self.own, own)))


def mixed(name: str, families: tuple[Family, ...], numbers: Mapping[str, float]) -> Plant:
    """Return a machine of some families with these numbers by field, in their units; the other fields stay neutral.

    Raises:
        PlantError: a family draws a number that is no field of its memory, or two families have fields of one name.
    """
    try:
        process, gauge = _made(families)
        own = joined(process.own, gauge.own)(**numbers)
    except (TypeError, ValueError) as error:
        raise PlantError(f"{name}: {reason(error)}; let what a family draws be fields of what it remembers") from None
    anew = tuple(field for family in families for field in family.anew)
    return Plant(name=name, process=process, gauge=gauge, own=tuple(own), anew=anew)


@functools.cache
def _made(families: tuple[Family, ...]) -> tuple[Process, Gauge]:
    """Return process and gauge of some families, cached so that their functions compile once."""
    process = functools.reduce(lambda inner, each: each.wraps(inner) if each.wraps else inner, families, PROCESS)
    hooks = [each.hook for each in families if each.hook is not None]
    gauges = [each.gauge for each in families if each.gauge is not None]
    return composed(process, *hooks), chain_gauges(*gauges)

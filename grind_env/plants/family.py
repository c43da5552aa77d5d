"""Families of machines: changed laws, and the random numbers of their members.

Each drawn number is a field in the memory of process, hook or gauge; its name begins with the name of the family. The
default values change no bit of a result. All members of a family share their compiled code.
"""

import functools
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from zlib import crc32

from grind_env.evidence import Basis, Evidence
from grind_env.kernel import exp, log
from grind_env.kernel.random import philox, uniform
from grind_env.process.gauge_readings import Gauge
from grind_env.process.process_interface import Hook, Process
from grind_env.toml import read_toml

#: streams of random numbers without a common number: for development machines and for held-out test machines
PUBLIC, HELD_OUT = 1, 2
SEED = "_seed"  #: suffix of the field that holds the seed of random events
FACTOR = "factor"  #: value of `spread` in `ranges.toml` for a number whose logarithm is drawn uniformly


@dataclass(frozen=True, slots=True, kw_only=True)
class Range:
    """Range of a drawn number of a machine."""

    field: str  #: field of the machine's memory
    what: str  #: meaning of the number
    unit: str = ""  #: unit of the number; "" for a number without a unit
    low: float  #: the smallest number, in this unit
    high: float  #: the largest number, in this unit
    #: smallest and largest number of held-out machines, in this unit; None for `low` and `high`
    held_out: tuple[float, float] | None = None
    factor: bool = False  #: whether the logarithm of the number is drawn uniformly instead of the number
    basis: Basis  #: source of the range

    def ends(self, stream: int) -> tuple[float, float]:
        """Return the least and the largest number of a stream."""
        return self.held_out if stream == HELD_OUT and self.held_out is not None else (self.low, self.high)

    def at(self, share: float, stream: int = PUBLIC) -> float:
        """Return the number below which a share, from 0 to 1, of all drawn numbers lies."""
        least, largest = self.ends(stream)
        low, high = (log(least), log(largest)) if self.factor else (least, largest)
        number = low + share * (high - low)
        return min(max(exp(number) if self.factor else number, least), largest)


@dataclass(frozen=True, slots=True, kw_only=True)
class Family:
    """Machines that differ from the package's model in one respect."""

    name: str  #: prefix of its memory fields
    what: str  #: the difference, in a sentence
    ranges: tuple[Range, ...]  #: ranges of the drawn numbers
    chances: bool = False  #: whether a seed of random events is drawn into the field `<name>_seed`
    #: function from a process to the changed process, the same object at each call; None to change nothing
    wraps: Callable[[Process], Process] | None = None
    hook: Hook | None = None  #: hook that runs before every block, or None
    gauge: Gauge | None = None  #: gauge from true readings to shown readings, without noise, or None
    #: fields that restart with every shift, because the shift has another wheel, temperature or gauge zero
    anew: tuple[str, ...] = ()

    def drawn(self, seed: int, stream: int = PUBLIC) -> dict[str, float]:
        """Return the numbers of a member by field, in the units of `ranges`; every computer gives equal numbers."""
        numbers = {each.field: each.at(share_of(seed, stream, each.field), stream) for each in self.ranges}
        own_seed = f"{self.name}{SEED}"
        return numbers | ({own_seed: float(word_of(seed, stream, own_seed))} if self.chances else {})


def word_of(seed: int, stream: int, what: str) -> int:
    """Return the random 32-bit integer of the label `what`, from a 32-bit seed and a stream."""
    return philox(seed, stream, crc32(what.encode()), 0, 0, 0)[0]


def share_of(seed: int, stream: int, what: str) -> float:
    """Return the random number of the label `what` between 0 and 1."""
    return uniform(word_of(seed, stream, what))


def ranges_of(family: str) -> tuple[Range, ...]:
    """Return the ranges of a family of the package."""
    return tuple(
        Range(
            field=f"{family}_{name}",
            what=row["what"],
            unit=row.get("unit", ""),
            low=row["range"][0],
            high=row["range"][1],
            held_out=tuple(row["held_out"]) if "held_out" in row else None,
            factor=row.get("spread") == FACTOR,
            basis=Basis(Evidence[row["evidence"].upper()], row["basis"]),
        )
        for name, row in _ranges()[family].items()
    )


@functools.cache
def _ranges() -> Mapping[str, Any]:
    return read_toml(Path(__file__).with_name("ranges.toml"))

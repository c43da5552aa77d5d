"""Uncertainty of a machine: how far its numbers may be from the numbers of a job."""

import sys
from dataclasses import dataclass

import numpy as np

from grind_env.array_types import Array
from grind_env.message_text import did_you_mean, quoted
from grind_env.process.catalogue import KINDS, UNCERTAINTY
from grind_env.process.entries import CatalogueError, Quantity, quantities
from grind_env.process.toml_tables import TomlTable

MOST = 3.0  #: highest legal spread; a higher value is a mistake
JITTER = 1e-9  #: least number added to the diagonal of a correlation, which may be singular


@dataclass(frozen=True, slots=True, kw_only=True)
class Uncertainty:
    """Uncertainty of the numbers of a machine.

    Attributes:
        names: names of numbers in the entries of the job, such as `material.ploughing_pressure`.
        spread: standard deviation of the logarithm of each number; of the number, in its unit, if it may be below 0.
        correlation: correlation of the numbers, a row for each, from -1 to 1 without a unit.
        residual: logarithmic standard deviation, without a unit, of forces that these numbers do not explain.
        drift: logarithmic standard deviation, without a unit, of a step of the forces from part to part; steps add up.
        source: its source; empty for the catalogue's own.

    Raises:
        GrindError: a value is not legal.
    """

    names: tuple[str, ...]
    spread: tuple[float, ...]
    correlation: tuple[tuple[float, ...], ...]
    residual: float = 0.0
    drift: float = 0.0
    source: str = ""

    def __post_init__(self) -> None:
        known = [
            f"{kind}.{key}"
            for kind, entry in KINDS.items()
            for key, quantity in quantities(entry).items()
            if isinstance(quantity, Quantity)
        ]
        for name in self.names:
            if name not in known:
                raise _wrong("names", f"there is no number {quoted(name)}{did_you_mean(str(name), known)}")
        if len({*self.names}) < len(self.names):
            raise _wrong("names", "a number is named twice")
        count = len(self.names)
        if len(self.spread) != count:
            raise _wrong("spread", f"it has {len(self.spread)} numbers, but must have one for each of {count} names")
        of_forces = ("residual", self.residual), ("drift", self.drift)
        for key, value in (*(("spread", each) for each in self.spread), *of_forces):
            if not (_is_number(value) and 0.0 <= value <= MOST):
                raise _wrong(key, f"{quoted(value)} must be a number from 0 to {MOST:g}")
        rows = self.correlation
        if [len(row) for row in rows] != [count] * count or not all(_is_number(each) for row in rows for each in row):
            raise _wrong("correlation", f"it must have {count} rows of {count} numbers, as many as there are names")
        table = np.array(rows, float).reshape(count, count)
        if not (np.allclose(table, table.T, atol=1e-6) and np.allclose(np.diag(table), 1.0, atol=1e-6)):
            raise _wrong("correlation", "it must be symmetric, with 1 in its diagonal")
        if count and np.linalg.eigvalsh(table)[0] < -1e-6:
            raise _wrong("correlation", "no numbers are correlated so: it has an eigenvalue below 0")

    @property
    def is_certain(self) -> bool:
        """Return whether the machine is known: all spreads are 0."""
        return not any((*self.spread, self.residual, self.drift))

    @property
    def root(self) -> Array:
        """Return the matrix from standard normal numbers to deviations, in units of the spreads.

        Shape (names, names); lower triangular.
        """
        table = np.array(self.correlation, float).reshape(len(self.names), len(self.names))
        table = table + 2.0 * max(JITTER, -float(min(np.linalg.eigvalsh(table), default=0.0))) * np.eye(len(table))
        return np.asarray(np.linalg.cholesky(table))


def uncertainty_of(table: TomlTable) -> Uncertainty:
    """Return the table `[uncertainty]` of a catalogue file; errors as for `Uncertainty`."""
    keys = tuple(Uncertainty.__dataclass_fields__)
    for key in table:
        if key not in keys:
            raise _wrong(
                str(key), f"there is no such key{did_you_mean(str(key), keys)}; the keys are {', '.join(keys)}"
            )
    for key in ("names", "spread", "correlation"):
        if not isinstance(table.get(key), list):
            raise _wrong(key, "it must be a list")
    if not all(isinstance(row, list) for row in table["correlation"]):
        raise _wrong("correlation", "it must be a list of rows")
    if not isinstance(table.get("source", ""), str):
        raise _wrong("source", "it must be a text")
    return Uncertainty(
        names=tuple(table["names"]),
        spread=tuple(table["spread"]),
        correlation=tuple(tuple(row) for row in table["correlation"]),
        **{key: table[key] for key in ("residual", "drift", "source") if key in table},
    )


def _is_number(value: object) -> bool:
    # an integer of TOML may be too long for a float
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= sys.float_info.max


def _wrong(key: str, message: str) -> CatalogueError:
    return CatalogueError(f"{UNCERTAINTY}.{key}: {message}")


#: uncertainty of a known machine
CERTAIN = Uncertainty(names=(), spread=(), correlation=(), source="the machine itself")

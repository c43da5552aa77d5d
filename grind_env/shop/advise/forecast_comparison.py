"""The shadow mode: forecasts beside readings, and the part from which on forecasts are right."""

from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from grind_env.policies.mismatch_alarms import HOLDS, NAMES, SIZE, UNITS, Watch

LAST = 10  #: number of parts in the output, the last ones
RIGHT = 0.9  #: least share of forecasts that hold if the model is right; 95 % hold with normal errors


class ComparedReading(NamedTuple):
    """Reading of a part beside its forecast, in `unit`."""

    part: int
    name: str
    unit: str
    read: float
    forecast: float
    spread: float  #: standard deviation of the error of the forecast

    @property
    def holds(self) -> bool:
        return abs(self.read - self.forecast) <= HOLDS * self.spread

    def text(self) -> str:
        read, forecast = f"{self.read:.2f} {self.unit}", f"{self.forecast:.2f} +/- {self.spread:.2f}"
        return f"part {self.part + 1}: {self.name} {read}, forecast {forecast}{'' if self.holds else ', off'}"


@dataclass
class Shadow:
    """Comparison of forecasts with readings so far."""

    rows: list[ComparedReading] = field(default_factory=list)

    def add(self, watch: Watch, part: int) -> None:
        """Add the comparisons of a block; `part` is its part, from 0; Ra is of the part before."""
        seen = watch.seen
        for k, (name, unit) in enumerate(zip(NAMES, UNITS, strict=True)):
            if not seen.new[0, k]:
                continue
            read, forecast, spread = (float(values[0, k]) for values in (seen.read, seen.forecast, seen.spread))
            if k == SIZE:
                sign = float(seen.sign[0, k])
                row = sign * read, sign * forecast, spread
            else:
                scale = 1.0 if unit.startswith("of") else 0.001
                middle = float(np.exp(forecast)) * scale
                row = float(np.exp(read)) * scale, middle, middle * spread
            self.rows.append(ComparedReading(part if name != "Ra" else part - 1, name, unit, *row))

    def right_from(self) -> int | None:
        """Return the first part, from 0, from which on forecasts are right; None if they are not right yet."""
        for part in sorted({row.part for row in self.rows}):
            later = [row.holds for row in self.rows if row.part >= part]
            if np.mean(later) >= RIGHT and all(row.holds for row in self.rows if row.part == part):
                return part
        return None

    def document(self) -> dict[str, Any]:
        """Return all comparisons, parts counted from 1, and the part from which forecasts held; None for not yet."""
        right = self.right_from()
        rows = [row._asdict() | {"part": row.part + 1, "holds": row.holds} for row in self.rows]
        return {"compared": rows, "right_from": None if right is None else right + 1}

    def lines(self) -> list[str]:
        """Return lines of text: forecasts beside readings of the last parts, and the part from which on they hold."""
        if not self.rows:
            return ["nothing was read that could be compared with a forecast"]
        last = max(row.part for row in self.rows) - LAST
        table = [f"  {row.text()}" for row in self.rows if row.part > last]
        right, held = self.right_from(), np.mean([row.holds for row in self.rows])
        verdict = "they are not right yet" if right is None else f"they are right from part {right + 1} on"
        return ["forecasts beside readings:", *table, f"{100.0 * held:.0f} % of the forecasts held; {verdict}"]

"""The checks of `checks.csv`, and the evaluation of their numbers.

The column `wheel` names the method of `Rig` that makes the wheel. `setups` are its arguments, `name: value` separated
by `; `, with `kind.field` for an entry of the catalogue; several values make one set-up each. `quantity` is a field of
a stroke, or a function with its arguments: of `quantities`, or of `comparisons` without a `wheel`. `number` is the
function in `NUMBERS` of the quantities of all set-ups.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from grind_env.evidence import Basis, Evidence
from grind_env.process.stroke_types import StrokeResult
from grind_env.validation import measured_data, quantities, wheel_comparisons
from grind_env.validation.check import Check, band_of
from grind_env.validation.fitted_slopes import exponent, largest_step, smallest_step
from grind_env.validation.rig import Rig

NUMBERS: dict[str, Callable[[list[float], Sequence[float]], float]] = {
    "": lambda found, swept: found[0],
    "quotient": lambda found, swept: found[0] / found[1],
    "difference": lambda found, swept: found[0] - found[1],
    "over_least": lambda found, swept: found[0] / min(found[1:]),
    "over_most": lambda found, swept: found[0] / max(found[1:]),
    "spread": lambda found, swept: max(found) / min(found),
    "largest_step": lambda found, swept: largest_step(found),
    "smallest_step": lambda found, swept: smallest_step(found),
    "exponent": lambda found, swept: exponent(swept, found),
    "minus_exponent": lambda found, swept: -exponent(swept, found),
}


@dataclass(frozen=True, slots=True)
class Measurement:
    """A number of the model; its fields are the columns of `checks.csv`."""

    quantity: str
    wheel: str = ""
    setups: str = ""
    number: str = ""

    def __call__(self, rig: Rig) -> float:
        """Return the number, measured on a rig."""
        columns = {name: values for part in self.setups.split("; ") if part for name, *values in [_words(part)]}
        swept: list[Any] = next((values for values in columns.values() if len(values) > 1), [])
        found = []
        for k in range(max(len(swept), 1)):
            setup: dict[str, Any] = {}
            for name, values in columns.items():
                kind, _, field = name.rstrip(":").rpartition(".")
                place = setup.setdefault("changes", {}).setdefault(kind, {}) if kind else setup
                place[field] = values[k] if len(values) > 1 else values[0]
            found.append(self._measured(rig, setup))
        return NUMBERS[self.number](found, swept)

    def _measured(self, rig: Rig, setup: dict[str, Any]) -> float:
        name, *arguments = _words(self.quantity)
        if not self.wheel:
            return float(getattr(wheel_comparisons, name)(rig, *arguments, **setup))
        make, *how = _words(self.wheel)
        grinder = getattr(rig, make)(*how, **setup)
        if name in StrokeResult._fields:
            (number,) = arguments or (quantities.STEADY,)
            return float(getattr(grinder.grind(int(number)), name))
        return float(getattr(quantities, name)(grinder, *arguments))


def _words(text: str) -> list[Any]:
    """Return the words of a text, with numbers as floats."""
    return [float(word) if word[0].isdigit() else word for word in text.split()]


CHECKS = tuple(
    Check(
        **{name: row[name] for name in ("name", "what", "at", "unit")},
        group=int(row["group"]),
        band=band_of(row["band"]),
        measure=Measurement(row["quantity"], row["wheel"], row["setups"], row["number"]),
        reference=float(row["reference"]) if row["reference"] else None,
        basis=Basis(Evidence[row["evidence"].upper()], row["source"]),
    )
    for row in measured_data.rows("checks", Path(__file__).parent)
)

"""The trends a step away from the conditions of their rows: how narrow the calibration is.

Constants were calibrated on the bands under the usual conditions. A band that holds there and fails a step away is a
number of those conditions, and no law.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from grind_env.process.catalogue import Catalogue
from grind_env.validation.check import Check, Row, row_of
from grind_env.validation.rig import Rig

STEPS: Mapping[str, Mapping[str, float]] = MappingProxyType(
    {
        "table 7.2 m/min": {"table_speed": 120.0},
        "table 20 m/min": {"table_speed": 1000.0 / 3.0},
        "downfeed 5 um": {"downfeed": 0.005},
        "downfeed 20 um": {"downfeed": 0.020},
        "10 mm wide": {"width": 10.0},
        "40 mm wide": {"width": 40.0},
        "60 mm long": {"length": 60.0},
        "wheel 22 m/s": {"wheel_speed": 22.0},
        "wheel 40 m/s": {"wheel_speed": 40.0},
        "wheel 240 mm": {"diameter": 240.0},
        "dress lead .05 mm": {"lead": 0.05},
        "dress lead .18 mm": {"lead": 0.18},
        "dress depth .01 mm": {"depth": 0.010},
    }
)
"""What takes the place of the usual set-up, where a row does not say otherwise."""


@dataclass(frozen=True, slots=True)
class Step:
    """A step away from the usual conditions, and the rows that pass there no more."""

    change: str
    failing: tuple[Row, ...]


def neighbours(catalogue: Catalogue, rows: list[Row]) -> list[Step]:
    """Take the numbers of the rows that pass, of groups 1 to 9, a step away in each direction."""
    checks: list[Check] = [row.check for row in rows if row.passed and row.check.group < 10]
    steps = []
    for change, usual in STEPS.items():
        rig = Rig(catalogue, usual)
        moved = [row_of(check, rig) for check in checks]
        steps.append(Step(change, tuple(row for row in moved if not row.passed)))
    return steps

"""The trends a step away from the conditions of their rows: how narrow the calibration is.

Constants were calibrated on the bands under the usual conditions. A band that holds there and fails a step away is a
number of those conditions, and no law.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from grind_env.process.catalogue import Catalogue
from grind_env.validation.check import Check, Row, row_of
from grind_env.validation.rig import Beyond, Rig

STEPS: Mapping[str, Mapping[str, float]] = MappingProxyType(
    {
        "the table at 7.2 m/min": {"table_speed": 120.0},
        "the table at 20 m/min": {"table_speed": 1000.0 / 3.0},
        "a downfeed of 5 um": {"downfeed": 0.005},
        "a downfeed of 20 um": {"downfeed": 0.020},
        "a part 10 mm wide": {"width": 10.0},
        "a part 40 mm wide": {"width": 40.0},
        "a part 60 mm long": {"length": 60.0},
        "the wheel at 22 m/s": {"wheel_speed": 22.0},
        "the wheel at 40 m/s": {"wheel_speed": 40.0},
        "a wheel of 240 mm": {"diameter": 240.0},
        "a dress lead of .05 mm": {"lead": 0.05},
        "a dress lead of .18 mm": {"lead": 0.18},
        "a dress depth of .01 mm": {"depth": 0.010},
    }
)
"""What takes the place of the usual set-up, where a row does not say otherwise."""


@dataclass(frozen=True, slots=True)
class Neighbour:
    """A step away from the usual conditions.

    Attributes:
        change: what is other than usual.
        rows: of groups 1 to 9, those that pass under the usual conditions, as they come out here.
        outside: what the step asks of the usual wheel and machine beyond the limits of the catalogue.
    """

    change: str
    rows: tuple[Row, ...]
    outside: tuple[Beyond, ...] = ()

    @property
    def failing(self) -> tuple[Row, ...]:
        """The rows that pass no more."""
        return tuple(row for row in self.rows if not row.passed)


def neighbours(catalogue: Catalogue, rows: list[Row]) -> list[Neighbour]:
    """Take the numbers of the rows that pass, of groups 1 to 9, a step away in each direction."""
    checks: list[Check] = [row.check for row in rows if row.passed and row.check.group < 10]
    steps = []
    for change, usual in STEPS.items():
        rig = Rig(catalogue, usual)
        rig.fresh()
        outside = tuple(rig.outside.values())
        steps.append(Neighbour(change, tuple(row_of(check, rig) for check in checks), outside))
    return steps

"""Modal state of the control, and the codes that change it (10-23)."""

from dataclasses import dataclass
from typing import Any

PLANES = {"G17": (0, 1), "G18": (2, 0), "G19": (1, 2)}
"""First and second axis of each plane (PD-2); axes are 0 = X, 1 = Y, 2 = Z."""

MOTIONS = ("G00", "G01", "G02", "G03")
CYCLES = ("G81", "G81.1", "G82", "G82.1", "G83", "G83.1")

SWITCHES: dict[str, tuple[str, Any]] = {
    **{plane: ("plane", plane) for plane in PLANES},
    "G70": ("inch", True),
    "G71": ("inch", False),
    "G90": ("incremental", False),
    "G91": ("incremental", True),
    "G94": ("per_revolution", False),
    "G95": ("per_revolution", True),
}
"""Modal codes outside the motion group: the field of `Modes` they set, and its value."""

WITHOUT_EFFECT = frozenset({"G07", "G39", "G40", "G54", "G97"})
"""Codes that name the state the control is always in for now."""

LATER = frozenset({
    "G08", "G09", "G10", "G20", "G28", "G29", "G30", "G33", "G34", "G39.1", "G41", "G42",
    "G55", "G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3", "G76", "G77",
    "G84", "G84.1", "G85", "G85.1", "G86", "G86.1", "G92", "G92.1", "G92.2", "G96",
})  # fmt: skip
"""Codes of the 9/Series control that this simulator does not support."""


@dataclass(frozen=True, slots=True)
class Modes:
    """What a block leaves in force for the next one; the defaults are those at power-up.

    Attributes:
        motion: G00, G01, G02 or G03.
        plane: G17, G18 or G19.
        incremental: G91 rather than G90.
        per_revolution: G95 rather than G94.
        inch: G70 rather than G71.
        feed: F, mm per minute or mm per revolution; None before the first F.
        spindle: S; revolutions per minute; None before the first S.
    """

    motion: str = "G00"
    plane: str = "G18"
    incremental: bool = False
    per_revolution: bool = False
    inch: bool = False
    feed: float | None = None
    spindle: float | None = None

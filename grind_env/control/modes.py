"""The codes that change the modal state of the control, and those that act in their block alone (10-23)."""

import itertools
from collections.abc import Collection
from typing import Any, Literal, TypeAlias, get_args

from grind_env.control.cycles import RULES

#: first and second axis of each plane (PD-2); axes are 0 = X, 1 = Y, 2 = Z
PLANES = {"G17": (0, 1), "G18": (2, 0), "G19": (1, 2)}

MOTIONS = ("G00", "G01", "G02", "G03")
CYCLES = tuple(code + form for code in RULES for form in ("", ".1"))

WorkSystem: TypeAlias = Literal["G54", "G55", "G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3"]
WORK_SYSTEMS = get_args(WorkSystem)

#: modal codes outside the motion group: the field of `Modes` they set, and its value
SWITCHES: dict[str, tuple[str, Any]] = {
    **{plane: ("plane", plane) for plane in PLANES},
    **{system: ("work_system", system) for system in WORK_SYSTEMS},
    **{code: ("compensation", code) for code in ("G40", "G41", "G42")},
    **{code: ("corner", code) for code in ("G39", "G39.1")},
    "G07": ("diameter", False),
    "G08": ("diameter", True),
    "G70": ("inch", True),
    "G71": ("inch", False),
    "G90": ("incremental", False),
    "G91": ("incremental", True),
    "G94": ("per_revolution", False),
    "G95": ("per_revolution", True),
    "G96": ("surface_speed", True),
    "G97": ("surface_speed", False),
}

#: codes that act in their own block only
ONE_SHOT = ("G04", "G10", "G28", "G29", "G30", "G52", "G76", "G77", "G92", "G92.1")

ACTIONS = frozenset((*MOTIONS, *CYCLES, *ONE_SHOT, "G80"))  #: codes of which a block may hold only one

MACHINE_COORDINATES = "G53"  #: code that makes the axis words of its own block machine coordinates

MACRO_CALL = "G65"  #: code that makes the words of its block arguments of a macro

#: codes of the 9/Series control that this simulator does not support
UNSUPPORTED_CODES = frozenset(
    {"G09", "G20", "G33", "G34", "G84", "G84.1", "G85", "G85.1", "G86", "G86.1", "G92.2"}.difference(CYCLES)
)
MODAL_MACROS = frozenset({"G66", "G66.1", "G67"})  #: unsupported codes of macros that are called after every motion


def listed(codes: Collection[str]) -> str:
    """Return codes in ascending order; three or more successive numbers become a range such as ``G00 to G04``."""
    numbers = sorted({int(code[1:3]) for code in codes})
    parts: list[str] = []
    for _, run in itertools.groupby(enumerate(numbers), lambda pair: pair[1] - pair[0]):
        successive = [number for _, number in run]
        members = sorted(code for code in codes if int(code[1:3]) in successive)
        parts += [f"{members[0]} to {members[-1]}"] if len(successive) > 2 else members
    return ", ".join(parts)

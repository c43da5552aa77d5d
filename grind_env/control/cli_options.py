"""Conversion of command-line options into settings of the control."""

import re
from collections.abc import Mapping, Sequence

from grind_env.control.errors import ControlError
from grind_env.control.operator_actions import Interrupt
from grind_env.message_text import shortened

HIGHEST_ENTRY = 99  #: highest entry of the radius table; two digits of a T word select an entry

#: commands that have the options --max-blocks and --groove-retract, which errors recommend
CHECK_COMMANDS = "grind check, trace, run or report"

_NUMBER = r"[0-9]+\.?[0-9]*|\.[0-9]+"
_ASSIGNMENT = re.compile(rf"#?([0-9]+)=([-+]?(?:{_NUMBER}))")
_INTERRUPT = re.compile(rf"[Oo]?([0-9]+)@({_NUMBER})(?::([0-9]+))?")


def radii_of(options: Sequence[str]) -> tuple[float, dict[int, float]]:
    """Return the default radius and the radii by entry, mm, from texts such as 2.5 and 1=2.5."""
    every, radii = 0.0, {}
    for option in options:
        entry, _, size = option.rpartition("=")
        try:
            number, radius = int(entry) if entry else None, float(size)
        except ValueError:
            message = f"--radius {shortened(option)} is no radius; write R or T=R, such as 2.5 or 1=2.5"
            raise ControlError("setting", message) from None
        if number is None:
            every = radius
        elif number in range(HIGHEST_ENTRY + 1):
            radii[number] = radius
        else:
            raise ControlError("setting", f"--radius {shortened(option)} names no entry; T is 0 to {HIGHEST_ENTRY}")
    return every, radii


def variables_of(options: Sequence[str], name: str = "--set") -> Mapping[int, float]:
    """Return ``#`` variables by number from texts such as #101=15000; errors name the option `name`."""
    variables = {}
    for option in options:
        match = _ASSIGNMENT.fullmatch("".join(option.split()))
        if match is None:
            message = f"{name} {shortened(option)} is no assignment; write a number for a variable, as in '#101=15000'"
            raise ControlError("setting", message)
        variables[int(match[1])] = float(match[2])
    return variables


def interrupts_of(options: Sequence[str]) -> tuple[Interrupt, ...]:
    """Return program interrupts in the order of their times, from texts such as 9200@12.5 and 9200@12.5:1."""
    found = []
    for option in options:
        match = _INTERRUPT.fullmatch(option.strip())
        if match is None:
            legal = "write O number and seconds, and the type if it is not 2, as in 9200@12.5 or 9200@12.5:1"
            raise ControlError("setting", f"--interrupt {shortened(option)} is no request; {legal}")
        found.append(Interrupt(int(match[1]), kind=int(match[3] or 2), at=float(match[2])))
    return tuple(sorted(found, key=lambda interrupt: interrupt.at))

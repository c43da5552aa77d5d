"""Texts of options of the command line -> settings of the control."""

import re
from collections.abc import Mapping, Sequence

from grind_env.control.errors import ControlError
from grind_env.control.operator import Interrupt
from grind_env.errors import shortened

HIGHEST_ENTRY = 99
"""Of the radius table, which two digits of a T word select from."""

_ASSIGNMENT = re.compile(r"#?([0-9]+)=([-+0-9.]+)")
_INTERRUPT = re.compile(r"[Oo]?([0-9]+)@([0-9.]+)(?::([0-9]+))?")


def radii_of(options: Sequence[str]) -> tuple[float, dict[int, float]]:
    """The radius of every entry, and those of single entries of the radius table, from texts such as 2.5 and 1=2.5.

    Raises:
        ControlError: setting, one says no radius.
    """
    every, radii = 0.0, {}
    for option in options:
        entry, _, size = option.rpartition("=")
        try:
            if entry and int(entry) not in range(HIGHEST_ENTRY + 1):
                raise ControlError("setting", f"--radius {shortened(option)} names no entry; T is 0 to {HIGHEST_ENTRY}")
            if entry:
                radii[int(entry)] = float(size)
            else:
                every = float(size)
        except ValueError:
            message = f"--radius {shortened(option)} is no radius; write R or T=R, such as 2.5 or 1=2.5"
            raise ControlError("setting", message) from None
    return every, radii


def variables_of(options: Sequence[str]) -> Mapping[int, float]:
    """Values of ``#`` variables from texts such as #101=15000.

    Raises:
        ControlError: setting, one is no assignment.
    """
    variables = {}
    for option in options:
        match = _ASSIGNMENT.fullmatch("".join(option.split()))
        try:
            if match is None:
                raise ValueError
            variables[int(match[1])] = float(match[2])
        except ValueError:
            message = f"--set {shortened(option)} is no assignment; write a number for a variable, as in '#101=15000'"
            raise ControlError("setting", message) from None
    return variables


def interrupts_of(options: Sequence[str]) -> tuple[Interrupt, ...]:
    """Program interrupts in the order of their times, from texts such as 9200@12.5 and 9200@12.5:1.

    Raises:
        ControlError: setting, one is no request.
    """
    found = []
    for option in options:
        match = _INTERRUPT.fullmatch(option.strip())
        try:
            if match is None:
                raise ValueError
            found.append(Interrupt(int(match[1]), kind=int(match[3] or 2), at=float(match[2])))
        except ControlError:
            raise
        except ValueError:
            legal = "write O number and seconds, and the type if it is not 2, as in 9200@12.5 or 9200@12.5:1"
            raise ControlError("setting", f"--interrupt {shortened(option)} is no request; {legal}") from None
    return tuple(sorted(found, key=lambda interrupt: interrupt.at))

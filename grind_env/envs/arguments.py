"""Checks of constructor arguments of the environments."""

import os
from typing import Any

import numpy as np

from grind_env.envs.tasks import TaskError
from grind_env.message_text import quoted

SHOWN = ("measured", "full")  #: values of `observation` and `info`: what a shop knows, or also the hidden state


def check_count(name: str, count: object, otherwise: str = "") -> int:
    """Return a number of sub-environments, threads or steps after checking it."""
    if isinstance(count, bool) or not isinstance(count, int | np.integer) or count < 1:
        raise TaskError(f"{name} is {count!r}, but must be a whole number of at least 1{otherwise}")
    return int(count)


def check_parts(parts: object, most: int) -> None:
    """Check the number of parts of a batch."""
    if isinstance(parts, bool) or not isinstance(parts, int | np.integer) or not 1 <= parts <= most:
        raise TaskError(f"parts is {parts!r}, but must be a whole number from 1 to {most}")


def check_flags(**flags: object) -> None:
    """Check arguments that are either true or false; a text such as "no" would count as true."""
    for name, value in flags.items():
        if not isinstance(value, bool | np.bool_):
            raise TaskError(f"{name} is {value!r}, but must be True or False")


def check_number(name: str, value: object, low: float, high: float) -> None:
    """Check that a value is a number from `low` to `high`."""
    is_number = isinstance(value, int | float | np.integer | np.floating) and not isinstance(value, bool)
    number: Any = value  # not as a float, which cannot be as large as an int
    if not (is_number and low <= number <= high):
        raise TaskError(f"{name} is {quoted(value)}, but must be a number from {low:g} to {high:g}")


def check_file(name: str, value: object) -> None:
    """Check the name of a file or None; the name must be a text, because Gymnasium writes it into the spec."""
    if value is None:
        return
    if isinstance(value, os.PathLike):
        raise TaskError(f"{name} is {value!r}, but must be the name of a file as a text: write str({name})")
    if not isinstance(value, str) or not _can_name_a_file(value):
        raise TaskError(f"{name} is {value!r}, but must be the name of a file, or left out")


def check_variables(variables: object) -> list[str]:
    """Return the assignments in a text such as "#500=0, #101=15000", which may be left out."""
    if variables is None:
        return []
    if not isinstance(variables, str):
        raise TaskError(f"variables is {variables!r}, but must be a text such as '#500=0, #101=15000', or left out")
    return [each for each in variables.split(",") if each.strip()]


def is_full(shown: object, name: str = "observation") -> bool:
    """Return whether the value asks for the hidden state, too."""
    if not isinstance(shown, str) or shown not in SHOWN:
        raise TaskError(f"{name} is {shown!r}, but must be one of {', '.join(SHOWN)}")
    return shown == "full"


def check_render(render_mode: object, known: tuple[str, ...]) -> None:
    """Check the render mode."""
    if render_mode is not None and not (isinstance(render_mode, str) and render_mode in known):
        modes = ", ".join(map(repr, known))
        raise TaskError(f"render_mode is {render_mode!r}, but the environment has {modes}")


def _can_name_a_file(name: str) -> bool:
    try:
        return b"\0" not in os.fsencode(name)
    except UnicodeEncodeError:
        return False

"""The parts of the docstring of an environment."""

import inspect
import re
from collections.abc import Callable
from typing import Any

from grind_env.envs.docstrings import meanings

HEADING = re.compile(r"^## (.+)$", re.MULTILINE)


def prose(make: Callable[..., Any]) -> dict[str, str]:
    """The text of a docstring by section, that is by `## Heading`; its first line is the section ""."""
    text = re.split(r"^(?:Args|Raises):$", inspect.cleandoc(make.__doc__ or ""), flags=re.MULTILINE)[0]
    first, *parts = HEADING.split(text)
    return {"": first.strip(), **{name: body.strip() for name, body in zip(parts[::2], parts[1::2], strict=True)}}


def arguments(make: Callable[..., Any]) -> list[tuple[str, str, str]]:
    """Name, default and meaning of every argument; the meaning is that of the docstring's `Args:`."""
    said = meanings(make, "Args")
    parameters = inspect.signature(make).parameters.values()
    return [
        (each.name, "" if each.default is each.empty else repr(each.default), said.get(each.name, ""))
        for each in parameters
    ]

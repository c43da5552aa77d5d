"""Sections of docstrings by name, from which pages and schemas are made."""

import inspect
import re
from collections.abc import Callable
from typing import Any

NAMED = re.compile(r"^    (\w+): (.+)$")


def meanings(of: Callable[..., Any], heading: str) -> dict[str, str]:
    """Return the names under a heading such as `Args` of a docstring, each with its meaning in one line."""
    _, _, text = inspect.cleandoc(of.__doc__ or "").partition(f"\n{heading}:\n")
    found: dict[str, str] = {}
    name = ""
    for line in text.splitlines():
        if match := NAMED.match(line):
            name = match[1]
            found[name] = match[2]
        elif name and line.startswith("        "):
            found[name] += f" {line.strip()}"
        else:
            break
    return found

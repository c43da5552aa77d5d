"""Documents in TOML, by the reader of the standard library or, before Python 3.11, by the package it came from."""

import re
import sys
from pathlib import Path
from typing import Any

from grind_env.errors import GrindError, reason
from grind_env.files import read_bytes

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

__all__ = ["TomlError", "read_toml", "tomllib"]

MOST_BYTES = 1_000_000
MOST_DOTS = 500
"""Points in a key; of one of thousands of names the reader would keep the beginnings of every length."""
TEXT = re.compile(rb"\"[^\"]*\"|'[^']*'|#.*")
"""Strings and remarks in a line, whose points are none of a key."""
BETWEEN_KEYS = re.compile(rb"[^\w\s.-]")


class TomlError(GrindError):
    """A text that is no TOML; the message says why."""


def read_toml(path: Path) -> dict[str, Any]:
    """The document in a file of the user, with or without a byte order mark.

    Raises:
        ReadError: the file cannot be read.
        TomlError: it is not TOML, not in UTF-8, or nested too deeply.
    """
    data = read_bytes(path, MOST_BYTES)
    for number, line in enumerate(data.splitlines(), 1):
        if any(key.count(b".") > MOST_DOTS for key in BETWEEN_KEYS.split(TEXT.sub(b"text", line))):
            raise TomlError(f"the key in line {number} has more than {MOST_DOTS} points; two or three are enough")
    try:
        return tomllib.loads(data.decode("utf-8-sig"))
    except RecursionError:
        raise TomlError("it is nested too deeply") from None
    except ValueError as error:
        raise TomlError(reason(error)) from None

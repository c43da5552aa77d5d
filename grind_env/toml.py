"""Documents in TOML, by the reader of the standard library or, before Python 3.11, by the package it came from."""

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
"""Points in a line; of a key of thousands of names the reader would keep the beginnings of every length."""


class TomlError(GrindError):
    """A text that is no TOML; the message says why."""


def read_toml(path: Path) -> dict[str, Any]:
    """The document in a file of the user, with or without a byte order mark.

    Raises:
        ReadError: the file cannot be read.
        TomlError: it is not TOML, not in UTF-8, or nested too deeply.
    """
    data = read_bytes(path, MOST_BYTES)
    if any(line.count(b".") > MOST_DOTS for line in data.splitlines()):
        raise TomlError(f"a line has more than {MOST_DOTS} points; keys are nested two or three deep")
    try:
        return tomllib.loads(data.decode("utf-8-sig"))
    except RecursionError:
        raise TomlError("it is nested too deeply") from None
    except ValueError as error:
        raise TomlError(reason(error)) from None

"""Read TOML by the standard library or, before Python 3.11, by tomli."""

import json
import re
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from grind_env.errors import GrindError
from grind_env.files import EncodingError, decoded, read_bytes
from grind_env.message_text import reason

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

__all__ = ["TomlError", "files_named", "read_toml", "toml_text", "toml_value", "tomllib"]

MOST_BYTES = 1_000_000
#: greatest number of dots in a key; of a key with thousands of names the TOML reader would keep every prefix
MOST_DOTS = 500
TEXT = re.compile(rb"\"[^\"]*\"|'[^']*'|#.*")  #: strings and comments of a line, whose dots belong to no key
COMMA = re.compile(rb"=\s*([-+]?\d+),(\d+)")
BETWEEN_KEYS = re.compile(rb"[^\w\s.-]")


class TomlError(GrindError):
    """Text that is no TOML; the message says why."""


def read_toml(path: Path) -> dict[str, Any]:
    """Return the document in a file of the user, with or without a byte order mark.

    Raises:
        ReadError: the file cannot be read.
        TomlError: the text is not TOML, not in UTF-8, or nested too deeply.
    """
    data = read_bytes(path, MOST_BYTES)
    for number, line in enumerate(data.splitlines(), 1):
        if any(key.count(b".") > MOST_DOTS for key in BETWEEN_KEYS.split(TEXT.sub(b"text", line))):
            raise TomlError(f"the key in line {number} has more than {MOST_DOTS} points; two or three are enough")
    try:
        return tomllib.loads(decoded(data))
    except RecursionError:
        raise TomlError("it is nested too deeply") from None
    except (EncodingError, ValueError) as error:
        place = re.search(r"at line (\d+)", said := reason(error))
        if place and (comma := COMMA.search(data.splitlines()[int(place[1]) - 1])):
            said = f"in line {place[1]} write {comma[1].decode()}.{comma[2].decode()}, with a decimal point"
        raise TomlError(said) from None


def files_named(path: Path) -> Iterator[Path]:
    """Yield a TOML file, its bases and their catalogue files, each once; some may be missing."""
    waiting = [path]
    for each in waiting:
        yield each
        try:
            document = read_toml(each)
        except GrindError:  # the function that needs the file reports the error
            continue
        catalogue = document.get("catalogue")
        files = catalogue.get("files") if isinstance(catalogue, dict) else None
        names = [document.get("base"), *(files if isinstance(files, list) else ())]
        waiting += {each.parent / name for name in names if isinstance(name, str)}.difference(waiting)


def toml_text(content: Mapping[str, Any], heading: str = "") -> str:
    """Return a document as TOML."""
    tables = {key: value for key, value in content.items() if _is_table(value)}
    lines = [f"{key} = {toml_value(value)}" for key, value in content.items() if key not in tables]
    blocks = ["\n".join(lines)] if lines else []
    for key, value in tables.items():
        name = f"{heading}{key if key.isidentifier() else json.dumps(key)}"
        for each in value if isinstance(value, list) else [value]:
            inner = toml_text(each, f"{name}.")
            title = f"[[{name}]]" if isinstance(value, list) else f"[{name}]"
            bare = isinstance(value, list) or any(not _is_table(entry) for entry in each.values())
            blocks.append(f"{title}\n{inner}" if bare else inner)
    return "\n\n".join(blocks)


def _is_table(value: Any) -> bool:
    return isinstance(value, Mapping) or (isinstance(value, list) and bool(value) and isinstance(value[0], Mapping))


def toml_value(value: Any) -> str:
    """Return a value as TOML."""
    if isinstance(value, tuple | list):
        return f"[{', '.join(map(toml_value, value))}]"
    return json.dumps(value)

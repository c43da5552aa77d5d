"""Catalogue fields: the meaning of each key of an entry, and the source of its numbers."""

import inspect
import re
from collections.abc import Sequence
from dataclasses import MISSING, fields
from pathlib import Path
from typing import NamedTuple

from grind_env.files import read_text
from grind_env.process.catalogue import BUILT_IN
from grind_env.process.entries import Entry, Quantity, quantities

#: a field of an entry class with the comment behind it
_COMMENTED = re.compile(r"^    (\w+): Annotated\[.*#\s*(.+)$", re.MULTILINE)


class EntryKey(NamedTuple):
    """A key of an entry."""

    key: str
    symbol: str  #: symbol in the process model and the literature
    unit: str
    legal: str  #: legal range, or the legal words
    default: str  #: default; empty if an entry must give the key, itself or by its base
    meaning: str  #: meaning; empty if the name says it


def keys_of(kind: type[Entry]) -> list[EntryKey]:
    """Return the keys of the entries of a kind."""
    remarks = dict(_COMMENTED.findall(inspect.getsource(kind)))
    own = fields(kind)[len(fields(Entry)) :]
    defaults = {each.name: "" if each.default is MISSING else f"{each.default:g}" for each in own}
    found = []
    for key, legal in quantities(kind).items():
        symbol, unit, span = "", "", str(legal)
        if isinstance(legal, Quantity):
            symbol, unit, span = legal.symbol, legal.unit, f"{legal.low:g} to {legal.high:g}"
        found.append(EntryKey(key, symbol, unit, span, defaults[key], remarks.get(key, "")))
    return found


def remark_on(kind: str, name: str, files: Sequence[Path] = ()) -> str:
    """Return the catalogue comments on an entry, from the last file with the entry."""
    heading = re.compile(rf"^\[{kind}\.\"?{re.escape(name)}\"?\]\s*(?:#\s*(.*))?\n((?:#.*\n)*)", re.MULTILINE)
    found = ""
    for path in (BUILT_IN / f"{kind}s.toml", *files):
        if match := heading.search(read_text(path)):
            found = " ".join(filter(None, (match[1] or "", _text(match[2]))))
    return found


def preface(kind: str) -> str:
    """Return the comments at the top of a kind's built-in file; empty for none."""
    return _text("".join(re.findall(r"\A((?:#.*\n)*)", read_text(BUILT_IN / f"{kind}s.toml"))))


def _text(comment: str) -> str:
    return " ".join(line.lstrip("# ").rstrip() for line in comment.splitlines())

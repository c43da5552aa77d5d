"""The catalogue as `grind catalogue` shows it."""

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from grind_env.data_table import Column, table_of
from grind_env.errors import GrindError
from grind_env.message_text import did_you_mean, printable, quoted
from grind_env.pages.catalogue_fields import keys_of, preface, remark_on
from grind_env.process.catalogue import KINDS, load_catalogue

if TYPE_CHECKING:
    from rich.console import Console


def catalogue_data(kind: str | None, name: str | None, files: Sequence[Path]) -> dict[str, Any]:
    """Return names and remarks of all entries, or of one kind, or one entry with its values, in JSON types."""
    known = load_catalogue(*files)
    if kind is None or name is None:
        return {
            each: {entry: remark_on(each, entry, files) for entry in getattr(known, f"{each}s")}
            for each in (KINDS if kind is None else [_checked(kind)])
        }
    entry = getattr(known, _checked(kind))(name)
    return {"kind": kind, "remark": remark_on(kind, entry.name, files), **asdict(entry)}


def print_catalogue(kind: str | None, name: str | None, files: Sequence[Path], console: "Console") -> None:
    """Print the `catalogue_data` as a table."""
    data = catalogue_data(kind, name, files)
    if kind is None or name is None:
        rows = [(each, entry, remark) for each, remarks in data.items() for entry, remark in remarks.items()]
        table_of((Column("kind"), Column("entry"), Column("what it is", wrap=True)), rows).print(console)
        console.print("grind catalogue KIND NAME shows the values of an entry.")
        return
    columns = (
        Column("key", "key"),
        Column("symbol", "symbol"),
        Column("value", lambda key: f"{x:g}" if isinstance(x := data[key.key], float) else str(x), right=True),
        Column("unit", "unit"),
        Column("legal", "legal", wrap=True),
        Column("meaning", "meaning", wrap=True),
    )
    also = f" ({', '.join(data['aliases'])})" if data["aliases"] else ""
    console.print(printable(f"{kind} {data['name']}{also}: {data['remark'] or 'no remark'}"))
    table_of(columns, keys_of(KINDS[kind])).print(console)
    console.print(preface(kind))


def _checked(kind: str) -> str:
    if kind not in KINDS:
        hint = did_you_mean(kind, KINDS)
        raise GrindError(f"there is no kind of entry {quoted(kind)}{hint}; kinds are {', '.join(KINDS)}")
    return kind

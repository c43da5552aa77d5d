"""The schema of task files, and a complete file of a task.

The schema comes from the dataclasses: annotations give legal values, docstrings the meaning.
"""

import itertools
from collections.abc import Iterator, Mapping
from dataclasses import MISSING, dataclass, fields
from typing import Any

from grind_env.envs.docstring_sections import meanings
from grind_env.envs.task_names import shipped_names
from grind_env.envs.tasks.definition import Task
from grind_env.envs.tasks.reading import DERIVED, PLAIN, TABLES
from grind_env.envs.tasks.tables import Kind
from grind_env.process.catalogue import KINDS, load_catalogue
from grind_env.process.entries import Choice, quantities
from grind_env.process.toml_tables import Content, contents
from grind_env.toml import toml_text, toml_value

__all__ = ["SchemaRow", "document", "json_schema", "rows", "rows_of", "schema_text", "toml_text"]

TYPES = {float: "number", int: "whole number", bool: "true or false", str: "text", tuple: "list", Mapping: "table"}
JSON_TYPES = {float: "number", int: "integer", bool: "boolean", str: "string", tuple: "array", Mapping: "object"}
BASE = f"task that supplies the keys missing in this file: a file beside it, or {', '.join(shipped_names())}"
FILES = "files of catalogue entries, added to those of the package; an entry may name another as `base`"


@dataclass(frozen=True, slots=True)
class SchemaRow:
    """Schema of one key."""

    table: str  #: its table; "" above all tables
    key: str  #: the key
    content: Content  #: legal values
    meaning: str  #: what it means
    default: Any = None  #: default value; None for none
    derived: str = ""  #: keys that decide its default; "" for a key with a fixed default or none
    required: bool = False  #: whether the key is required

    @property
    def holds(self) -> str:
        """Return type, range and unit: `number, 0 to 86400 s`."""
        content = self.content
        holds = " or ".join(content.choices) or TYPES[content.type]
        if content.type in (tuple, Mapping):
            holds = " ".join(filter(None, (holds, "of", str(content.count or ""), f"{TYPES[content.item]}s")))
        return f"{holds}{f', {content.quantity}' if content.quantity else ''}"

    @property
    def otherwise(self) -> str:
        """Return the effect of leaving the key out: `required`, `default 20.0`."""
        default = self.derived or ("none" if self.default is None else toml_value(self.default))
        return "required" if self.required else f"default {default}"

    def __str__(self) -> str:
        return f"{self.key}: {self.holds}; {self.otherwise}"


def rows() -> list[SchemaRow]:
    """Return all keys of a task file but those of catalogue entries, which `process.entries` has."""
    tables = {**TABLES, "kind": Kind}
    return [
        SchemaRow("", "base", Content(str, str), BASE),
        *(row for row in rows_of("", Task) if row.key in PLAIN),
        *(row for name, kind in tables.items() for row in rows_of(name, kind)),
        SchemaRow("catalogue", "files", Content(tuple, str), FILES),
    ]


def rows_of(table: str, kind: Any) -> Iterator[SchemaRow]:
    """Return the keys of a table, from the annotations and the docstring of its dataclass."""
    known, said = contents(kind), meanings(kind, "Attributes")
    for item in fields(kind):
        if item.name not in known:
            continue
        value = None if item.default in (MISSING, ()) else item.default
        derived = DERIVED.get(item.name, "") if kind is Task else ""
        required = not derived and item.default is MISSING and item.default_factory is MISSING
        yield SchemaRow(table, item.name, known[item.name], said[item.name].rstrip("."), value, derived, required)


def schema_text() -> str:
    """Return all keys with type, unit, range, default and meaning, table by table."""
    lines = ["Above all tables"]
    for table, listed in itertools.groupby(rows(), key=lambda row: row.table):
        if table:
            lines += ["", "[[kind]], once for each kind of cycle block" if table == "kind" else f"[{table}]"]
        for row in listed:
            lines += [f"  {row}", f"      {row.meaning}"]
    kinds = ", ".join(f"[{kind}.NAME]" for kind in KINDS)
    lines += [
        "",
        f"{kinds}",
        "  entries of a catalogue, as `--json` has them; a `base` in one supplies what it leaves out",
    ]
    return "\n".join(lines)


def json_schema() -> dict[str, Any]:
    """Return the JSON Schema (2020-12) of task files, catalogue entries included."""
    listed = rows()
    tables = {name: _object([row for row in listed if row.table == name]) for name in {row.table for row in listed}}
    top = tables.pop("")
    kind = tables.pop("kind")
    entries = {
        name: {"type": "object", "additionalProperties": _entry_schema(name), "description": f"{name} entries by name"}
        for name in KINDS
    }
    top["properties"] |= tables | {"kind": {"type": "array", "items": kind, "minItems": 1}} | entries
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", "title": "A task of grind_env", **top}


def _entry_schema(kind: str) -> dict[str, Any]:
    values = {
        key: {"enum": list(each.words)}
        if isinstance(each, Choice)
        else {"type": "number", "minimum": each.low, "maximum": each.high, "unit": each.unit}
        for key, each in quantities(KINDS[kind]).items()
    }
    names = {"base": {"type": "string"}, "aliases": {"type": "array", "items": {"type": "string"}}}
    return {"type": "object", "properties": names | values, "additionalProperties": False}


def _object(listed: list[SchemaRow]) -> dict[str, Any]:
    schema: dict[str, Any] = {
        "type": "object",
        "properties": {row.key: _property(row) for row in listed},
        "additionalProperties": False,
    }
    required = [row.key for row in listed if row.required]
    return schema | ({"required": required} if required else {})


def _property(row: SchemaRow) -> dict[str, Any]:
    content, item = row.content, _item_schema(row.content)
    derived = f"; {row.derived} if left out" if row.derived else ""
    schema: dict[str, Any] = {"description": f"{row.meaning}{derived}"}
    if row.default is not None:
        schema["default"] = row.default
    if content.quantity and content.quantity.unit:
        schema["unit"] = content.quantity.unit
    if content.type is tuple:
        count = {"minItems": content.count, "maxItems": content.count} if content.count else {}
        return schema | {"type": "array", "items": item} | count
    if content.type is Mapping:
        return schema | {"type": "object", "additionalProperties": item}
    return schema | item


def _item_schema(content: Content) -> dict[str, Any]:
    schema: dict[str, Any] = {"type": JSON_TYPES[content.item]}
    if content.choices:
        schema["enum"] = list(content.choices)
    if content.quantity:
        schema |= {"minimum": content.quantity.low, "maximum": content.quantity.high}
    return schema


def document(task: Task) -> dict[str, Any]:
    """Return the document of a task with nothing left out: read again, it is the same task."""
    known = load_catalogue()
    own = {
        kind: {
            name: {key: getattr(entry, key) for key in quantities(KINDS[kind])}
            for name, entry in getattr(task.catalogue, f"{kind}s").items()
            if getattr(known, f"{kind}s").get(name) != entry
        }
        for kind in KINDS
    }
    return {
        **{key: _plain(getattr(task, key)) for key in PLAIN if getattr(task, key) not in ((), {}, "")},
        **{key: _said(getattr(task, key)) for key in TABLES if getattr(task, key) is not None},
        "kind": [_said(kind) for kind in task.kinds],
        **{kind: entries for kind, entries in own.items() if entries},
    }


def _said(table: Any) -> dict[str, Any]:
    values = {item.name: getattr(table, item.name) for item in fields(table)}
    return {key: _plain(value) for key, value in values.items() if value is not None and value != {}}


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return dict(value)
    return list(value) if isinstance(value, tuple) else value

"""Task files: TOML, with the fields of `Task` and of its tables as keys.

::

    [setup]                    # optional, like all tables but [[kind]]; defaults: `grind tasks --schema`
    wheel = "a60j"

    [[kind]]                   # a kind of cycle block; several kinds are ground in turn
    material = "aisi_52100"
    stock = 0.2                # mm
    pick = 0.01                # mm
    width = 20                 # mm
    length = 200               # mm

Above its tables a file may name a base: `base = "power_limited"` or `base = "shop.toml"`, a task of the package or a
file beside it. Tables of the file change single keys of the base's tables; all other keys replace the base's keys.
`title` and `reference_cost` never come from the base.

A user's catalogue comes from `[catalogue] files = ["tools.toml"]`, or from tables of the task file such as
`[material.hard_lot]` with `base = "aisi_52100"` and the values that differ (`process.catalogue`).
"""

import functools
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

from grind_env.envs.task_names import FOLDER, shipped_names, task_names
from grind_env.envs.tasks import tables
from grind_env.envs.tasks.definition import Task
from grind_env.files import ReadError
from grind_env.message_text import did_you_mean, quoted
from grind_env.process.catalogue import KINDS, load_catalogue
from grind_env.process.entries import CatalogueError
from grind_env.process.toml_tables import TomlTable, checked, keys, refuse_missing, refuse_unknown, wrong
from grind_env.process.user_catalogue import files_of
from grind_env.toml import TomlError, read_toml

SUFFIX = ".toml"  #: suffix that tells the file of a task from a name

#: tables of a task file by heading; orders, due dates and wheel changes exist only if the file has their tables
TABLES: Mapping[str, type[Any]] = MappingProxyType(
    {
        "action": tables.ActionRange,
        "setup": tables.TaskSetup,
        "dress": tables.Dress,
        "orders": tables.Orders,
        "due": tables.Due,
        "wheel_change": tables.WheelChange,
        "spread": tables.Spread,
        "start": tables.Start,
    }
)

OWN = ("title", "reference_cost")  #: keys that are never taken from a base
#: pairs of keys that exclude each other; a file that gives one key drops the other key of its base
ALTERNATIVES = (("sequence", "orders"), ("speed_range", "speed_levels"))

#: keys of a task file above its tables
PLAIN = tuple(key for key in keys(Task) if key not in ("name", "kinds", "catalogue", "file", *TABLES))
LEGAL = ("base", *PLAIN, *TABLES, "kind", "catalogue", *KINDS)  #: all keys and headings of a task file

USUAL_ROUNDS = 30  #: number of repetitions of the sequence in a task without the key `blocks`
#: values of keys of `PLAIN` without a fixed default, if a file leaves them out
DERIVED = {
    "title": "its name",
    "blocks": f"{USUAL_ROUNDS} times the sequence",
    "reference_cost": "cost of a block by the cheapest of several fixed plans",
    "sequence": "all kinds in turn",
    "plant": "the model",
}


def load_task(source: str) -> Task:
    """Return a task of blocks by its name or from a user's file.

    Args:
        source: name of a task that `GrindEnv` steps, or the path of a file, which ends in `.toml`.

    Raises:
        TaskError: if there is no such task, or its file is faulty (see `read_task`).
    """
    if not is_file(source):
        _refuse_other(source, task_names())
    return read_task(source)


def read_task(source: str) -> Task:
    """Return a task by its name or from a user's file, also a task of an id with a module of its own.

    Raises:
        TaskError: if a file cannot be read, lacks a key, or has one that is unknown or illegal; the message names file,
            key, value and what is legal.
    """
    return _from_file(Path(source)) if is_file(source) else _shipped(source)


def is_file(source: object) -> bool:
    """Return whether a task is named by its file."""
    return isinstance(source, str) and source.lower().endswith(SUFFIX)


@functools.cache
def _shipped(name: str) -> Task:
    _refuse_other(name, shipped_names())
    return replace(_from_file(FOLDER / f"{name}{SUFFIX}"), file="")


def _refuse_other(name: object, known: list[str]) -> None:
    if name not in known:
        hint = did_you_mean(name, known) if isinstance(name, str) else ""
        raise tables.TaskError(
            f"there is no task {quoted(name)}{hint}: the tasks are {', '.join(known)}, or a file that ends in {SUFFIX}"
        )


def _from_file(path: Path) -> Task:
    try:
        return _task(path, _document(path))
    except tables.TaskError as error:
        raise tables.TaskError(error.message, error.key, error.found, error.legal, str(path)) from None


def _document(path: Path) -> dict[str, Any]:
    """Return the content of a task file merged with its base."""
    layers = [{key: value for key, value in document.items() if key != "base"} for document in _layers(path)]
    document = layers.pop()
    for own in reversed(layers):
        document = _merged(document, own)
    return document


def _layers(path: Path) -> Iterator[dict[str, Any]]:
    """Yield the own content of a task file and of its bases."""
    document, seen = _parsed(path), [path.resolve()]
    yield document
    while "base" in document:
        path = _base(document["base"], path)
        try:
            document = _parsed(path)
        except tables.TaskError as error:
            raise tables.TaskError(f"base: {error}", "base", path.name) from None
        if path.resolve() in seen:
            raise tables.TaskError(
                f"base: {path.name} is based on itself in the end; leave out one base", "base", path.name
            )
        seen.append(path.resolve())
        yield document


def _base(source: object, path: Path) -> Path:
    """Return the file of a base that the file at `path` names."""
    if isinstance(source, str) and is_file(source):
        return path.parent / source
    try:
        _refuse_other(source, shipped_names())
    except tables.TaskError as error:
        raise tables.TaskError(f"base: {error.message}", "base", source) from None
    return FOLDER / f"{source}{SUFFIX}"


def _merged(base: TomlTable, own: TomlTable) -> dict[str, Any]:
    """Return a document merged with its base: tables change single keys, other values are replaced."""
    document = {key: value for key, value in base.items() if key not in OWN}
    if "kind" in own:
        document.pop("sequence", None)
    _drop_alternatives(document, own)
    for key, value in own.items():
        before = document.get(key)
        if isinstance(value, Mapping) and isinstance(before, Mapping):
            before = dict(before)
            _drop_alternatives(before, value)
            value = {**before, **value}
        document[key] = value
    return document


def _drop_alternatives(document: dict[str, Any], own: TomlTable) -> None:
    for one, other in ALTERNATIVES:
        for said, dropped in ((one, other), (other, one)):
            if said in own and dropped not in own:
                document.pop(dropped, None)


def _parsed(path: Path) -> dict[str, Any]:
    """Return the document of a file; names of catalogue files in it become absolute paths."""
    try:
        document = read_toml(path)
        refuse_unknown(document, LEGAL, tables.TaskError)
        if "catalogue" in document:
            files = [str(file) for file in files_of(document, path.parent, tables.TaskError)]
            document["catalogue"] = {"files": files}
    except ReadError as error:
        raise tables.TaskError(f"the task cannot be read ({error.reason}); name a TOML file", file=str(path)) from None
    except TomlError as error:
        raise tables.TaskError(f"the task is not valid TOML: {error}", file=str(path)) from None
    except tables.TaskError as error:
        raise tables.TaskError(error.message, error.key, error.found, error.legal, str(path)) from None
    return document


def _task(path: Path, document: TomlTable) -> Task:
    given = {key: _table(kind, document[key], key) for key, kind in TABLES.items() if key in document}
    found = document.get("kind", [])
    if not isinstance(found, list):
        raise wrong("kind", found, "tables, each headed [[kind]]", tables.TaskError)
    kinds = tuple(_kind(number, table) for number, table in enumerate(found, 1))
    try:
        catalogue = load_catalogue(
            *document.get("catalogue", {}).get("files", ()),
            document={kind: document[kind] for kind in KINDS if kind in document},
        )
    except CatalogueError as error:
        raise tables.TaskError(str(error).rstrip(".")) from None
    values = {key: _unchanging(document[key]) for key in PLAIN if key in document}
    values.setdefault("title", path.stem)
    if "orders" not in given:
        values.setdefault("sequence", tuple(kind.name for kind in kinds))
    rounds = len(values["sequence"]) if isinstance(values.get("sequence"), tuple) else max(len(kinds), 1)
    values.setdefault("blocks", USUAL_ROUNDS * max(rounds, 1))
    return Task(name=path.stem, kinds=kinds, catalogue=catalogue, file=str(path), **given, **values)


def _kind(number: int, table: object) -> tables.Kind:
    try:
        kind: tables.Kind = _table(tables.Kind, table, "kind")
    except tables.TaskError as error:
        raise tables.TaskError(f"kind {number}: {error.message}", error.key, error.found, error.legal) from None
    return kind


def _table(kind: type[Any], value: object, place: str) -> Any:
    """Return an instance of a dataclass from a table of a task file."""
    table = checked(value, place, keys(kind), tables.TaskError)
    refuse_missing(table, kind, place, tables.TaskError)
    return kind(**{key: _unchanging(value) for key, value in table.items()})


def _unchanging(value: Any) -> Any:
    if isinstance(value, dict):
        return tables.ReadOnly(value)
    return tuple(value) if isinstance(value, list) else value

"""The tasks, one declarative TOML file each (scenarios, section 4), read into frozen dataclasses."""

import functools
from collections.abc import Mapping
from dataclasses import MISSING, fields
from typing import Any

from grind_env.envs.names import FOLDER, task_names
from grind_env.envs.tasks.definition import DRESS_CLEARANCE, Task
from grind_env.envs.tasks.tables import (
    ActionRange,
    Dress,
    Due,
    Kind,
    Orders,
    ReadOnly,
    Setup,
    Spread,
    Start,
    TaskError,
    WheelChange,
    refuse_unknown,
)
from grind_env.errors import GrindError, quoted
from grind_env.toml import tomllib

__all__ = [
    "DRESS_CLEARANCE",
    "FOLDER",
    "ActionRange",
    "Dress",
    "Due",
    "Kind",
    "Orders",
    "Setup",
    "Spread",
    "Start",
    "Task",
    "TaskError",
    "WheelChange",
    "load_task",
    "read_task",
    "task_names",
]

TABLES: Mapping[str, type[Any]] = {
    "action": ActionRange,
    "setup": Setup,
    "dress": Dress,
    "spread": Spread,
    "start": Start,
}
"""Tables of every task; keys that are left out of one have their defaults."""

FURTHER_TABLES: Mapping[str, type[Any]] = {"orders": Orders, "due": Due, "wheel_change": WheelChange}
"""Tables of some tasks."""


def load_task(name: str) -> Task:
    """The task of cycle blocks of that name.

    Raises:
        TaskError: if there is no such task, or as `read_task`.
    """
    _refuse_other(name)
    return read_task(name)


@functools.cache
def read_task(name: str) -> Task:
    """The task in the file of that name, be it one of cycle blocks or that of an environment with its own classes.

    Raises:
        TaskError: if the file lacks a key or has one that does not exist, or if it is based on no task.
    """
    try:
        return _task(name, _document(name))
    except GrindError as error:
        raise TaskError(f"{name}.toml: {error}") from None


def _refuse_other(name: str) -> None:
    if name not in task_names():
        raise TaskError(f"there is no task {quoted(name)}: the tasks are {', '.join(task_names())}")


def _document(name: str) -> dict[str, Any]:
    """What a task file says, on top of what its `base` says: a table changes single keys, other values are replaced."""
    own = _parsed(name)
    if "base" not in own:
        return own
    base = own.pop("base")
    _refuse_other(base)
    document = _parsed(base)
    for key, value in own.items():
        both = isinstance(value, dict) and isinstance(document.get(key), dict)
        document[key] = document[key] | value if both else value
    return document


def _parsed(name: str) -> dict[str, Any]:
    try:
        return tomllib.loads((FOLDER / f"{name}.toml").read_text(encoding="utf-8"))
    except tomllib.TOMLDecodeError as error:
        raise TaskError(f"not valid TOML: {error}") from None


def _task(name: str, document: Mapping[str, Any]) -> Task:
    every = {**TABLES, **FURTHER_TABLES}
    plain = [item.name for item in fields(Task) if item.name not in ("name", "kinds", *every)]
    refuse_unknown(document, [*plain, *every, "kind"], "")
    tables = {key: _read(kind, document.get(key, {}), f"[{key}]: ") for key, kind in TABLES.items()}
    tables |= {key: _read(kind, document[key], f"[{key}]: ") for key, kind in FURTHER_TABLES.items() if key in document}
    kinds = tuple(_read(Kind, table, "[[kind]]: ") for table in document.get("kind", ()))
    values = {key: document[key] for key in plain if key in document}
    task: Task = _read(Task, values, "", name=name, kinds=kinds, **tables)
    for kind in kinds:
        # looks up every name of the catalogue and every key of the changes
        task.parameters(kind)
    return task


def _read(kind: type[Any], table: Any, place: str, **given: Any) -> Any:
    """An instance of a dataclass from a table of a task file; `given` are the fields not in the table."""
    if not isinstance(table, Mapping):
        raise TaskError(f"{place}it is {quoted(table)}, but must be a table")
    expected = [item for item in fields(kind) if item.name not in given]
    refuse_unknown(table, [item.name for item in expected], place)
    for item in expected:
        if item.default is MISSING and item.default_factory is MISSING and item.name not in table:
            raise TaskError(f"{place}the key {item.name} is missing")
    values = {key: _unchanging(value) for key, value in table.items()}
    return kind(**given, **values)


def _unchanging(value: Any) -> Any:
    if isinstance(value, dict):
        return ReadOnly(value)
    return tuple(value) if isinstance(value, list) else value

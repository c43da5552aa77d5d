"""Tables of numbers and texts: built from rows, saved in small compressed files, and compared."""

import math
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grind_env.array_types import Table

RECORDS = Path(__file__).with_name("records")

AXES = ("X", "Y", "Z")

PLACES = ("step", "env", "event", "part", "line", "number")  #: columns that identify a row

Tables = dict[str, Table]  #: tables by name, such as `box` or `as it is: strokes`


def table(rows: Iterable[Mapping[str, Any]]) -> Table:
    """Return a table with a float64 or text column for each key; a missing value or None is NaN or an empty text."""
    rows = list(rows)
    names = list(dict.fromkeys(name for row in rows for name in row))
    columns: dict[str, NDArray[Any]] = {}
    for name in names:
        values = [row.get(name) for row in rows]
        if any(isinstance(value, str) for value in values):
            columns[name] = np.array(["" if value is None else value for value in values], np.str_)
        else:
            columns[name] = np.array([math.nan if value is None else value for value in values], np.float64)
    made = np.empty(len(rows), [(name, column.dtype) for name, column in columns.items()])
    for name, column in columns.items():
        made[name] = column
    return made


def flat(place: str, value: Any) -> Iterator[tuple[str, Any]]:
    """Yield the values in a nested value, each with its path: `parts.0.Ra`, `end.X`."""
    if isinstance(value, Mapping):
        items: Iterable[tuple[Any, Any]] = value.items()
    elif isinstance(value, list | tuple):
        is_position = isinstance(value, tuple) and len(value) == len(AXES)
        items = zip(AXES, value, strict=True) if is_position else enumerate(value)
    else:
        yield place, value
        return
    for name, each in items:
        yield from flat(f"{place}.{name}" if place else str(name), each)


def load(name: str) -> Tables:
    """Return the tables of a record; empty if there is no such record yet."""
    path = RECORDS / f"{name}.npz"
    if not path.exists():
        return {}
    with np.load(path) as file:
        return dict(file)


def save(name: str, tables: Tables) -> None:
    """Write a record; the same tables make the same bytes."""
    RECORDS.mkdir(exist_ok=True)
    np.savez_compressed(RECORDS / f"{name}.npz", **tables)  # type: ignore[arg-type]


def changes(recorded: Tables, found: Tables, tolerance: float = 0.0) -> list[str]:
    """Return a sentence for each change, with the name of its table; see `differences`."""
    said = [f"{name}: is recorded, but no longer there" for name in recorded if name not in found]
    said += [f"{name}: is not recorded" for name in found if name not in recorded]
    for name in recorded:
        if name in found:
            said += [f"{name}: {sentence}" for sentence in differences(recorded[name], found[name], tolerance)]
    return said


def additions(recorded: Tables, found: Tables) -> list[str]:
    """Return a sentence for each column that is not recorded yet; nobody depends on new columns."""
    both = [name for name in recorded if name in found]
    columns = {name: recorded[name].dtype.names or () for name in both}
    return [
        f"{name}: {column} is new"
        for name in both
        for column in found[name].dtype.names or ()
        if column not in columns[name]
    ]


def differences(recorded: Table, found: Table, tolerance: float = 0.0) -> list[str]:
    """Return a sentence for each column that differs: where first, and by how much at most.

    The columns are sorted by their first difference, because the earliest is nearest to the cause. New columns are
    not included; see `additions`.

    Args:
        recorded: the old table.
        found: the new table.
        tolerance: absolute and relative tolerance of numbers; 0 for equal bits.
    """
    was, now = recorded.dtype.names or (), found.dtype.names or ()
    said = [f"{name} is no longer there" for name in was if name not in now]
    both = [name for name in was if name in now]
    if both != [name for name in now if name in was]:
        said.append("the columns are in another order")
    if len(recorded) != len(found):
        said.append(f"{len(recorded)} rows are recorded, {len(found)} are found")
    rows = min(len(recorded), len(found))
    moved = []
    for name in both:
        old, new = recorded[name][:rows], found[name][:rows]
        unequal = np.flatnonzero(_unequal(old, new, tolerance))
        if unequal.size:
            moved.append((unequal, name))
    moved.sort(key=lambda each: each[0][0])
    return said + [_sentence(name, unequal, recorded, found) for unequal, name in moved]


def _unequal(old: NDArray[Any], new: NDArray[Any], tolerance: float) -> NDArray[Any]:
    if _are_texts(old, new):
        return np.asarray(old != new)
    if tolerance > 0.0:
        return ~np.isclose(old, new, rtol=tolerance, atol=tolerance, equal_nan=True)
    return ~((old == new) & (np.signbit(old) == np.signbit(new)) | np.isnan(old) & np.isnan(new))


def _are_texts(old: NDArray[Any], new: NDArray[Any]) -> bool:
    return "U" in (old.dtype.kind, new.dtype.kind)


def _sentence(name: str, rows: NDArray[np.intp], recorded: Table, found: Table) -> str:
    """Return a sentence: where a column differs, the first two values, and the largest difference."""
    first = rows[0]
    old, new = recorded[name][rows], found[name][rows]
    cells = {key: recorded[key][first].item() for key in PLACES if key in (recorded.dtype.names or ())}
    places = {key: cell if isinstance(cell, str) else f"{cell:g}" for key, cell in cells.items()}
    place = ", ".join(f"{key} {value}" for key, value in places.items() if value not in ("", "nan"))
    where = f", first at {place}" if place else ""
    said = f"{name} differs in {len(rows)} of {len(recorded)} rows{where}: was {old[0].item()!r}, is {new[0].item()!r}"
    return said if _are_texts(old, new) else f"{said}; the largest relative difference is {_largest(old, new):.2g}"


def _largest(old: NDArray[Any], new: NDArray[Any]) -> float:
    """Return the largest relative difference; 0 for texts, infinite where only one of the numbers exists."""
    if _are_texts(old, new):
        return 0.0
    with np.errstate(invalid="ignore", divide="ignore"):
        share = np.abs(old - new) / np.maximum(np.abs(old), np.abs(new))
    share[old == new] = 0.0
    return float(np.nan_to_num(share, nan=math.inf).max())

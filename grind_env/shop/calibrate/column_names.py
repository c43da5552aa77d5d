"""Columns of a measured file, found by names in many languages or by a user's map (docs/howto/calibrate.md)."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from grind_env.files import ReadError, shown
from grind_env.message_text import did_you_mean, listed, quoted
from grind_env.shop.calibrate.exceptions import CalibrationError
from grind_env.shop.measurements.measured_sheet import MOST_NUMBER, Sheet, plain
from grind_env.toml import TomlError, read_toml

#: words in headings by which columns are recognised, by table of a map and by name of the column
WORDS: Mapping[str, Mapping[str, Sequence[str]]] = read_toml(Path(__file__).with_name("words.toml"))

#: keys of a map other than columns, by table
MAP_VALUES: Mapping[str, tuple[str, ...]] = {
    "log": ("power_unit", "time_unit", "rated_power", "volts", "power_factor", "scale"),
    "gauge": ("nominal_size", "size_unit"),
    "table": (),
}

LISTED = 5  #: greatest number of unused columns that a remark names
UNIT_OF_POWER = ("w", "kw", "hp", "ps", "%", "a", "watt", "amp", "ampere")


@dataclass(frozen=True, slots=True)
class Map:
    """Map: the content of a columns file, by table and key; `file` is None if there is no file."""

    file: Path | None = None
    tables: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)

    def value(self, table: str, key: str) -> Any:
        """Return the value of a key; None if the map does not have it."""
        return self.tables.get(table, {}).get(key)

    def number(self, table: str, key: str) -> float | None:
        """Return the number of a key, above 0; a `CalibrationError` says that the value is no such number."""
        value = self.value(table, key)
        if value is None:
            return None
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not 0.0 < value < MOST_NUMBER:
            raise CalibrationError(
                f"{self.file}: {table}.{key} is {quoted(value)}, but must be a number above 0 and below {MOST_NUMBER:g}"
            )
        return float(value)


def read_map(path: Path | None) -> Map:
    """Return the map in a file, an empty one for None; a `CalibrationError` names unknown tables and keys."""
    if path is None:
        return Map()
    try:
        tables = read_toml(path)
    except (ReadError, TomlError) as error:
        why = getattr(error, "reason", error)
        raise CalibrationError(
            f"{shown(path)}: the map cannot be read ({why}); name a TOML file, or correct it"
        ) from None
    for name, table in tables.items():
        if name not in MAP_VALUES or not isinstance(table, Mapping):
            raise CalibrationError(f"{shown(path)}: there is no table [{name}]; a map has [log], [gauge] and [table]")
        legal = (*WORDS[name], *MAP_VALUES[name])
        for key in set(table) - set(legal):
            hint = did_you_mean(key, legal)
            raise CalibrationError(f"{shown(path)}: there is no key {name}.{key}{hint}; legal are {', '.join(legal)}")
    return Map(path, tables)


def find_columns(sheet: Sheet, table: str, map_: Map, *needed: Sequence[str]) -> dict[str, int]:
    """Return the columns of a table of a map by name: named in the map, or recognised by the words in their headings.

    The remarks of the sheet list them. A `CalibrationError` names a group of `needed` names of which no column is
    found, or two columns that are equally likely.
    """
    known = WORDS[table]
    found = {name: _mapped(sheet, table, name, map_) for name in known if map_.value(table, name) is not None}
    for name, words in known.items():
        if name in found:
            continue
        scores = {number: _score(sheet, number, name, words) for number in range(len(sheet.headings))}
        scores = {number: score for number, score in scores.items() if score and number not in found.values()}
        best = [number for number, score in scores.items() if score == max(scores.values())]
        if len(best) > 1:
            both = " and ".join(quoted(sheet.headings[number].name) for number in best[:2])
            said_by = f"say which with a map: [{table}] {name} = ..."
            raise CalibrationError(f"{shown(sheet.path)}: columns {both} may both be the {name}; {said_by}")
        if best:
            found[name] = best[0]
    names = listed([heading.name for heading in sheet.headings])
    for group in needed:
        if not any(name in found for name in group):
            raise CalibrationError(
                f"{shown(sheet.path)} has no column of the {' or '.join(group)} among {names}; say which it "
                f"is with a map, [{table}] {group[0]} = ..., or add a column"
            )
    sheet.remarks.extend(f"{name} is column {quoted(sheet.headings[column].name)}" for name, column in found.items())
    others = [quoted(each.name) for column, each in enumerate(sheet.headings) if column not in found.values()]
    if others:
        what = f"column{'s' if len(others) > 1 else ''} {listed(others, LISTED)}"
        sheet.remarks.append(f"nothing was taken from {what} of {sheet.path.name}")
    return found


def _mapped(sheet: Sheet, table: str, name: str, map_: Map) -> int:
    """Return the column that a map names, by its number from 1, its name or its name with its unit."""
    value, names = map_.value(table, name), [heading.name for heading in sheet.headings]
    called = [*names, *(f"{heading.name} [{heading.unit}]" for heading in sheet.headings)]
    if isinstance(value, int) and not isinstance(value, bool) and 1 <= value <= len(names):
        return value - 1
    if value in called:
        return called.index(value) % len(names)
    raise CalibrationError(
        f"{map_.file}: {table}.{name} is {quoted(value)}, but {shown(sheet.path)} has no such column; "
        f"its columns are {listed(names)}"
    )


def _score(sheet: Sheet, number: int, name: str, words: Sequence[str]) -> float:
    """Return how well a heading matches these words; 0 for no match."""
    heading = sheet.headings[number]
    tokens = [token for token in re.split(r"[\W\d_]+", plain(heading.name)) if token]
    whole = [word for word in words if word in tokens or word == plain(heading.name)]
    part = [word for word in words if len(word) > 3 and any(token.startswith(word) for token in tokens)]
    score = 2.0 * len(whole[:1]) + 1.0 * len(part[:1])
    unit = plain(heading.unit)
    if name == "power":
        if any(token in ("limit", "soll", "setpoint", "rated", "cumul", "energie", "energy") for token in tokens):
            return 0.0
        score += 2.0 * (unit in UNIT_OF_POWER) * bool(score or unit in ("w", "kw", "a", "amp"))
        score += 0.5 * any(
            token.startswith(("spind", "spdl", "husillo", "broche", "mandrino", "ist")) for token in tokens
        )
    if name == "time":
        score += 2.0 * (unit in ("s", "ms", "us", "min", "h", "sec", "hh:mm:ss")) + 3.0 * sheet.is_clock(number)
    return score

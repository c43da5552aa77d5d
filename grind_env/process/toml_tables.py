"""Read tables of a user's TOML file into frozen dataclasses, with one sentence for every mistake.

Annotations of fields give the legal values: a number or a tuple of numbers as `Annotated[..., Quantity(...)]`, a whole
number in the same form, true or false, a text or a choice of texts, any of them `| None`. Fields of other types do not
belong to a document and are skipped.
"""

import functools
import itertools
from collections.abc import Iterable, Mapping
from dataclasses import MISSING, dataclass, fields, replace
from numbers import Integral
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin, get_type_hints

from grind_env.errors import GrindError
from grind_env.files import shown
from grind_env.message_text import did_you_mean, quoted, shortened
from grind_env.process.entries import Quantity

TomlTable = Mapping[str, Any]


class TableError(GrindError):
    """A document with an unknown, missing or illegal key.

    Attributes:
        key: the key at fault, with its table, such as `part.stock`.
        found: its value; None if it is missing.
        legal: its legal values.
        file: the file of the document; empty if it was not read from one.
    """

    def __init__(self, message: str, key: str = "", found: object = None, legal: str = "", file: str = "") -> None:
        self.message, self.key, self.found, self.legal, self.file = message, key, found, legal, file
        super().__init__(f"{shown(file)}: {message}" if file else message)


Error = type[TableError]


@dataclass(frozen=True, slots=True)
class Content:
    """Legal content of a field."""

    type: Any  # type of the value: float, int, bool, str, or tuple or Mapping of these
    item: Any  # type of the entries of a tuple or a mapping; else as `type`
    count: int = 0  #: entries of a tuple; 0 for any number
    quantity: Quantity | None = None
    choices: tuple[str, ...] = ()
    optional: bool = False  #: whether None is legal, for a value that is left out

    @property
    def legal(self) -> str:
        if self.choices:
            return f"one of {', '.join(self.choices)}"
        span = f" from {self.quantity}" if self.quantity else ""
        if self.type is tuple and self.item is str:
            return "a list of texts"
        if self.type is tuple and self.count > 2:
            return f"{self.count} numbers{span}, in a list"
        if self.type is tuple:
            return f"two numbers{span}, the lower one first" if self.count == 2 else f"rising numbers{span}, in a list"
        if self.type is Mapping:
            return f"a table of numbers{span}"
        return {float: f"a number{span}", int: f"a whole number{span}", bool: "true or false", str: "a text"}[self.type]

    def allows(self, value: Any) -> bool:
        if self.type is Mapping:
            return isinstance(value, Mapping) and all(self._allows_item(each) for each in value.values())
        if self.type is not tuple:
            return self._allows_item(value)
        if not isinstance(value, tuple) or not all(map(self._allows_item, value)):
            return False
        return self.item is str or (len(value) == (self.count or max(len(value), 1)) and self._rises(value))

    def _allows_item(self, value: Any) -> bool:
        if self.item is float or self.item is int:
            whole = self.item is float or isinstance(value, Integral)
            return whole and (self.quantity is None or self.quantity.allows(value))
        return isinstance(value, self.item) and (not self.choices or value in self.choices)

    def _rises(self, value: tuple[float, ...]) -> bool:
        # both ends of a range may be equal, levels must differ, and coordinates may have any order
        return self.count > 2 or all(a <= b if self.count else a < b for a, b in itertools.pairwise(value))


@functools.cache
def contents(kind: type[Any]) -> Mapping[str, Content]:
    """Return the legal content of each field of a dataclass, by its name."""
    hints = get_type_hints(kind, include_extras=True)
    found = {item.name: _content(hints[item.name]) for item in fields(kind)}
    return {name: content for name, content in found.items() if content is not None}


def check(table: Any, place: str, error: Error) -> None:
    """Check every field of a frozen dataclass, and store whole numbers as floats where a field is one.

    The `error` names `place`, the first value that is not legal, and the legal range.
    """
    for name, content in contents(table.__class__).items():
        value = getattr(table, name)
        if value is None and content.optional:
            continue
        if not content.allows(value):
            raise wrong(f"{place}.{name}" if place else name, value, content.legal, error)
        if content.type is float:
            object.__setattr__(table, name, float(value))
        elif content.type is tuple and content.item is float:
            object.__setattr__(table, name, tuple(map(float, value)))


def wrong(key: str, value: object, legal: str, error: Error) -> TableError:
    """Return the error for a value that is not legal."""
    return error(f"{key} is {quoted(value)}, but must be {legal}", key, value, legal)


def sub_table(parent: TomlTable, name: str, legal: Iterable[str], error: Error, place: str = "") -> TomlTable:
    """Return a table without unknown keys; an empty one if it is missing."""
    place = place or name
    return checked(parent.get(name, {}), place, legal, error)


def checked(value: object, place: str, legal: Iterable[str], error: Error) -> TomlTable:
    """Return the checked table at a place, without unknown keys."""
    if not isinstance(value, Mapping):
        raise wrong(place, value, f"a table, headed [{place}]", error)
    refuse_unknown(value, legal, error, f"{place}.")
    return value


def refuse_unknown(table: TomlTable, legal: Iterable[str], error: Error, prefix: str = "") -> None:
    """Check the keys of a table; the error names the first unknown one and the key most like it."""
    legal = tuple(legal)
    for key, value in table.items():
        if key not in legal:
            hint, names = did_you_mean(key.lower(), legal), ", ".join(legal)
            raise error(
                f"there is no key {prefix}{shortened(key)}{hint}; legal are {names}", f"{prefix}{key}", value, names
            )


def refuse_missing(table: TomlTable, kind: type[Any], place: str, error: Error) -> None:
    """Check that a table has all keys without a default."""
    for key in keys(kind, required=True):
        if key not in table:
            raise error(f"{place}.{key} is missing; it has no default", f"{place}.{key}")


def keys(kind: type[Any], required: bool = False) -> tuple[str, ...]:
    """Return the names of the fields of a dataclass; if `required`, only of fields without a default."""
    return tuple(
        item.name
        for item in fields(kind)
        if not required or (item.default is MISSING and item.default_factory is MISSING)
    )


def _content(hint: Any, quantity: Quantity | None = None) -> Content | None:
    origin, given = get_origin(hint), get_args(hint)
    if origin is Annotated:
        return _content(given[0], given[1])
    if origin in (Union, UnionType):
        (kind,) = (each for each in given if each is not NoneType)
        content = _content(kind, quantity)
        return None if content is None else replace(content, optional=True)
    if origin is Literal:
        return Content(str, str, choices=given)
    if origin is tuple and given[0] in (float, str):
        return Content(tuple, given[0], 0 if given[-1] is Ellipsis else len(given), quantity)
    if origin is not None and issubclass(origin, Mapping):
        return Content(Mapping, given[1], quantity=quantity)
    return Content(hint, hint, quantity=quantity) if hint in (float, int, bool, str) else None

"""Read JSON into frozen dataclasses, with every value checked against its annotation."""

import json
import sys
from collections.abc import Mapping
from dataclasses import MISSING, fields, is_dataclass
from types import NoneType, UnionType
from typing import Any, Literal, get_args, get_origin

from grind_env.errors import GrindError
from grind_env.message_text import quoted, reason, shortened


class FormError(GrindError):
    """JSON content of the wrong form; the message names place and remedy."""


def parsed(text: str) -> Any:
    """Return the value of a JSON text; raise a FormError if the text is no JSON or nested too deeply."""
    try:
        return json.loads(text)
    except RecursionError:
        raise FormError("it is nested too deeply: ask for it again") from None
    except ValueError as error:
        raise FormError(f"it is no JSON ({reason(error)}): ask for it again") from None


def formed(kind: Any, value: Any, place: str) -> Any:
    """Return a JSON value as the type of an annotation: dataclass, tuple, mapping, number, text or choice of texts.

    Raises:
        FormError: the value has another form, unknown or missing keys, or a number that is not finite.
    """
    origin, given = get_origin(kind), get_args(kind)
    if origin is UnionType:
        return formed(next((each for each in given if _fits(each, value)), given[0]), value, place)
    if not _fits(kind, value):
        wanted = f"one of {', '.join(given)}" if origin is Literal else SAID.get(origin or kind, "an object")
        raise FormError(f"{place} is {quoted(value)}, but must be {wanted}")
    if is_dataclass(kind):
        known = {each.name: each for each in fields(kind)}
        needed = [name for name, each in known.items() if each.default is each.default_factory is MISSING]
        wrong = [f"has an unknown key {shortened(key)}" for key in value if key not in known]
        if wrong := [*wrong, *(f"lacks the key {key}" for key in needed if key not in value)]:
            raise FormError(f"{place} {wrong[0]}: its keys are {', '.join(known)}")
        made: Any = kind
        return made(**{key: formed(known[key].type, each, f"{place}.{key}") for key, each in value.items()})
    if origin is Mapping:
        return {key: formed(given[1], each, f"{place}.{shortened(key)}") for key, each in value.items()}
    if origin is tuple:
        return tuple(formed(given[0], each, f"{place}[{k}]") for k, each in enumerate(value))
    return float(value) if kind is float else value


SAID = {
    float: "a finite number",
    int: "a whole number",
    bool: "true or false",
    str: "a text",
    tuple: "a list",
    NoneType: "null",
}


def _fits(kind: Any, value: Any) -> bool:
    """Return whether a value has this form; entries of lists and objects are not checked."""
    if kind is float:  # a whole number of any size up to the largest float also counts as a float
        return isinstance(value, int | float) and type(value) is not bool and abs(value) <= sys.float_info.max
    if get_origin(kind) is Literal:
        return isinstance(value, str) and value in get_args(kind)
    if kind in (int, bool, str, NoneType):
        return type(value) is kind
    return isinstance(value, list if get_origin(kind) is tuple else dict)

"""API pages of the site: every public name documents its shapes, units, errors and sources."""

import ast
import functools
import inspect
import re
import textwrap
from collections.abc import Callable, Iterator
from dataclasses import is_dataclass
from importlib import import_module
from pathlib import Path
from pkgutil import walk_packages
from types import ModuleType
from typing import Any, NamedTuple

import pytest
from sphinx.pycode import ModuleAnalyzer

import grind_env
from grind_env.errors import GrindError
from grind_env.process import cost, equations
from grind_env.process.stroke_types import StrokeParameters, StrokeResult, WheelState

DOCS = Path(__file__).parents[2] / "docs"
MODULES = sorted(set(re.findall(r"automodule:: (\S+)", "".join(page.read_text() for page in DOCS.glob("*/*.md")))))
ARRAY = re.compile(r"ndarray|ArrayLike|_SupportsArray")
SHAPE = re.compile(r"shape|Shape")
NUMERIC = re.compile(r"^(?!.*Callable).*\b(float|ndarray)\b")
#: unit of a quantity, or the words for a count, a flag or a number without a unit
UNIT = re.compile(
    # N, J and K are words of a program, too: units behind a comma only
    r"\b(mm[23]?|um|min)\b|(?<![\w'`])(s|k?W)\b|, [NJK]\b|\$|\bper minute\b|\bunits?\b|"
    r"\b(?i:shares?|fraction|factors?|ratios?|exponent|probability|log of|index|indices|how many)\b|"
    r"\b(?i:numbers? of)(?! the\b)|\b(?i:whether)\b|(\A|\bis |\bare )1 (if|for)\b"
)
#: a text of nothing but an enumerator makes an empty list on the site
ENUMERATOR = re.compile(r"([A-Za-z]|[ivxlcdm]+|[IVXLCDM]+)\.")
#: modules with the tables of the compiled loops, which the pages mention
BEHIND = (
    "envs.block_kind_rows",
    "envs.noise_tape",
    "machine.loops.cycle",
    "machine.script.script_tables",
    "machine.loops.stroke_totals",
)
PHYSICS: tuple[Any, ...] = (WheelState, StrokeParameters, StrokeResult, cost.Rates, cost.Limits)
#: equations derived from definitions and balances of the others
DERIVED = {
    "cut_root",
    "depth_of_cut",
    "force_per_grain",
    "grain_sliding",
    "grinding_stiffness",
    "pressed_share",
    "specific_energy",
    "turning",
    "wheel_speed",
    "worn_diameter",
    "worn_flat_area",
}
SOURCE = re.compile(r"\[[^\]]*\b[MRWDC]\b[^\]]*\]|Malkin|Rowe|Hahn|Chen|Verkerk|Jaeger")


class Public(NamedTuple):
    """A public function or method."""

    name: str
    function: Callable[..., Any]
    owner: type | None

    @property
    def overrides(self) -> bool:
        """True for a method that overrides a method of another library."""
        name, bases = self.name.rpartition(".")[2], self.owner.__mro__[1:] if self.owner else ()
        return any(name in vars(base) for base in bases if not base.__module__.startswith("grind_env"))

    @property
    def text(self) -> str:
        return inspect.getdoc(self.function) or ""


def exported(module: ModuleType) -> Iterator[tuple[str, Any]]:
    """Yield the names and objects on the page of a module."""
    names = getattr(module, "__all__", None)
    for name, value in [(each, getattr(module, each)) for each in names] if names else vars(module).items():
        if names or (not name.startswith("_") and getattr(value, "__module__", None) == module.__name__):
            yield name, value


def functions() -> list[Public]:
    """Return all public functions and methods, compiled ones as their Python functions."""
    found: dict[int, Public] = {}
    for module in map(import_module, MODULES):
        for name, value in exported(module):
            members = vars(value).items() if inspect.isclass(value) else [("", inspect.unwrap(value))]
            for member, function in members:
                function = function.fget if isinstance(function, property) else function
                if inspect.isfunction(function) and not member.startswith("_"):
                    place = f"{module.__name__}.{name}{'.' * bool(member)}{member}"
                    found[id(function)] = Public(place, function, value if member else None)
    return list(found.values())


FUNCTIONS = functions()


def tables() -> list[type]:
    """Return the named tuples and dataclasses of the pages, with their base classes in the package."""
    modules = [*MODULES, *(f"grind_env.{name}" for name in BEHIND)]
    shown = (value for module in map(import_module, modules) for _, value in exported(module) if inspect.isclass(value))
    kinds = dict.fromkeys(kind for each in shown for kind in each.__mro__ if kind.__module__.startswith("grind_env"))
    return [kind for kind in kinds if is_dataclass(kind) or hasattr(kind, "_fields")]


def quantities_of(table: type) -> list[str]:
    """Return public fields with floats or arrays, without each `Quantity`, whose unit the site prints."""
    return [
        name
        for name, hint in inspect.get_annotations(table).items()
        if NUMERIC.search(str(hint)) and not name.startswith("_") and "Quantity(" not in str(hint)
    ]


@functools.cache
def own_texts(table: type) -> dict[str, str]:
    """Return the docstrings below the fields of a table and the `#:` comments beside them, as the site shows them."""
    texts = ModuleAnalyzer.for_module(table.__module__).find_attr_docs()
    return {name: " ".join(lines) for (owner, name), lines in texts.items() if owner == table.__qualname__}


def text_of(table: type, name: str) -> str:
    """Return all text about a field: beside or below it, in the section on attributes and in sentences that name it.

    A table may refer to another one for fields without a text, by the same name or as 1/X in `per_X`.
    """
    introduction, *sections = re.split(r"^Attributes:\n", inspect.getdoc(table) or "", flags=re.MULTILINE)
    said = [own_texts(table).get(name, "")]
    said += re.findall(rf"^    {name}: (.*(?:\n {{8}}.*)*)", "".join(sections), flags=re.MULTILINE)
    other = re.search(r"without a text are those of\s+`(\w+)`", introduction)
    if other and not any(said):
        return text_of(getattr(import_module(table.__module__), other[1]), name.removeprefix("per_"))
    sentences = re.split(r"(?<=[.;])\s+", introduction)
    said += [each for each in sentences if f"`{name}`" in each or each.startswith("All fields")]
    return " ".join(filter(None, said))


def test_enough_modules_and_functions_are_found() -> None:
    assert len(MODULES) > 50 and len(FUNCTIONS) > 350


def test_every_public_name_is_documented() -> None:
    undocumented = [each.name for each in FUNCTIONS if not each.text and not each.overrides]
    for module in map(import_module, MODULES):
        silent = [name for name, value in exported(module) if callable(value) and not value.__doc__]
        undocumented += [f"{module.__name__}.{name}" for name in silent]
        undocumented += [] if module.__doc__ else [module.__name__]
    assert undocumented == []


def test_every_error_that_a_public_function_raises_is_named() -> None:
    unnamed = []
    for each in FUNCTIONS:
        tree = ast.parse(textwrap.dedent(inspect.getsource(each.function)))
        for node in ast.walk(tree):
            called = node.exc.func if isinstance(node, ast.Raise) and isinstance(node.exc, ast.Call) else None
            kind = each.function.__globals__.get(called.id) if isinstance(called, ast.Name) else None
            if (
                isinstance(kind, type)
                and issubclass(kind, GrindError)
                and not {kind.__name__, "GrindError"} & set(re.findall(r"\w+", each.text))
            ):
                unnamed.append(f"{each.name}: {kind.__name__}")
    assert unnamed == []


def test_every_documented_error_exists() -> None:
    for module in walk_packages(grind_env.__path__, "grind_env."):
        if not module.name.endswith("__main__"):
            import_module(module.name)
    known = {kind.__name__ for kind in _below(Exception)}
    unknown = []
    for each in FUNCTIONS:
        section = re.split(r"^Raises:\n", each.text, flags=re.MULTILINE)[1:]
        named = re.findall(r"^    ([\w.]+): ", section[0], flags=re.MULTILINE) if section else []
        unknown += [f"{each.name}: {name}" for name in named if name.rpartition(".")[2] not in known]
    assert unknown == []


def test_functions_of_arrays_state_shapes() -> None:
    silent = [
        each.name
        for each in FUNCTIONS
        if any(ARRAY.search(str(hint)) for hint in inspect.get_annotations(each.function).values())
        and not SHAPE.search(each.text)
        and not each.overrides
    ]
    assert silent == []


@pytest.mark.parametrize("table", PHYSICS, ids=lambda table: table.__name__)
def test_every_quantity_of_the_process_has_its_own_text_and_unit(table: type) -> None:
    texts = own_texts(table)
    assert texts.keys() == set(table._fields)
    assert [name for name, text in texts.items() if not UNIT.search(text)] == []


def test_every_quantity_has_a_unit() -> None:
    quantities = [(table, name) for table in tables() for name in quantities_of(table)]
    assert len(quantities) > 500
    assert [
        f"{table.__name__}.{name}" for table, name in quantities if ENUMERATOR.fullmatch(text_of(table, name))
    ] == []
    assert [f"{table.__name__}.{name}" for table, name in quantities if not UNIT.search(text_of(table, name))] == []


@pytest.mark.parametrize("name", [name for name, value in vars(equations).items() if callable(value)])
def test_every_equation_has_a_source(name: str) -> None:
    function = inspect.unwrap(getattr(equations, name))
    text = f"{function.__doc__} {inspect.getmodule(function).__doc__}"
    assert name in DERIVED or SOURCE.search(text)


def _below(kind: type) -> Iterator[type]:
    for each in kind.__subclasses__():
        yield each
        yield from _below(each)

"""Sources of every rule of the control: statements of the manuals, decisions, and their tests."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, TypeAlias

from grind_env.toml import tomllib

FILE = Path(__file__).with_name("facts.toml")

MarkName: TypeAlias = Literal["seen", "inferred", "decided"]
MARKS: tuple[MarkName, ...] = ("seen", "inferred", "decided")


@dataclass(frozen=True, slots=True, kw_only=True)
class Fact:
    """A statement about the control."""

    id: str  #: page and number of a statement, or the name of a decision
    text: str  #: the statement, in the project's own words
    page: str  #: page of the grinder manual; a letter before it names another manual; "" for a decision without a page
    mark: MarkName  #: "seen" on the page, "inferred" from it, or "decided" by the project
    tests: tuple[str, ...] = ()  #: the tests of the fact, ``file::function`` from the root of the repository
    outside: str = ""  #: why the fact is not simulated; "" if it is simulated and has `tests`


def load_facts() -> tuple[Fact, ...]:
    """Return all facts in the order of the file.

    Example:
        >>> from grind_env.control.facts import load_facts
        >>> [fact.text for fact in load_facts() if fact.id == "16-13.5"]
        ['D is not program modal: a cycle block without D makes no auto-dress.']
    """
    entries: list[Mapping[str, Any]] = tomllib.loads(FILE.read_text(encoding="utf-8"))["fact"]
    return tuple(Fact(**{**entry, "tests": tuple(entry.get("tests", ()))}) for entry in entries)

"""What a picture shows of an environment without machine and wheel: a table of quantities."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Entry:
    """A quantity."""

    name: str
    text: str
    """Value and unit, as shown."""
    share: float
    """Length of its bar, from 0 to 1."""
    beyond: bool = False
    """Whether it has passed its limit."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Sheet:
    """A table of quantities under a title."""

    title: str
    entries: tuple[Entry, ...]
    verdict: str
    """A sentence under the table."""

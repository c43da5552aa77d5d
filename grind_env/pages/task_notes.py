"""Hand-written notes on each id, from `notes.toml`."""

import functools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from grind_env.errors import GrindError
from grind_env.toml import read_toml

FILE = Path(__file__).with_name("notes.toml")


class PageError(GrindError):
    """An id that is not registered or has no notes."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PageNote:
    """Notes on one id; `program` is the example program that `make` needs, `reward` its span without a task."""

    summary: str
    hard: str
    versions: Mapping[str, str]
    program: str = ""
    reward: Sequence[float] | None = None


@functools.cache
def load_notes() -> Mapping[str, PageNote]:
    """Return all notes by id."""
    return {env_id: PageNote(**entry) for env_id, entry in read_toml(FILE).items()}


def note_of(env_id: str) -> PageNote:
    """Return the notes on an id.

    Raises:
        PageError: the id has no notes.
    """
    notes = load_notes()
    if env_id not in notes:
        raise PageError(f"{env_id} has no notes: add a table of that name to {FILE.name}")
    return notes[env_id]

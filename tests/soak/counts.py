"""What a soak has come to so far, in a file of the commit that is whole whenever it is stopped."""

import json
import subprocess
from collections import Counter
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from tests.soak.part import Tried

KEPT = 5
"""Falls of a kind whose details are kept."""


@dataclass(slots=True)
class Fall:
    """A case that has fallen, to be repeated by its seed."""

    seed: int
    kind: str
    details: str


@dataclass(slots=True)
class Count:
    """Cases of a part.

    Attributes:
        next: the first seed that was not yet given out.
        open: seeds that were given out and have not ended.
        ends: cases by how they ended.
        kinds: those that have fallen, by kind.
        seconds: of processes that tried them.
        sums, most: of `Tried`.
        falls: the first of every kind.
    """

    next: int = 0
    open: list[int] = field(default_factory=list)
    ends: dict[str, int] = field(default_factory=dict)
    kinds: dict[str, int] = field(default_factory=dict)
    seconds: float = 0.0
    sums: dict[str, float] = field(default_factory=dict)
    most: dict[str, float] = field(default_factory=dict)
    falls: list[Fall] = field(default_factory=list)

    @property
    def tried(self) -> int:
        """How many cases have ended."""
        return sum(self.ends.values())

    def take(self) -> int:
        """Give out a seed."""
        self.next += 1
        self.open.append(self.next - 1)
        return self.next - 1

    def add(self, seed: int, tried: Tried) -> None:
        """Count a case that was given out, or, of a seed that was not, only what it has fallen by."""
        if seed in self.open:
            self.open.remove(seed)
            self.ends[tried.end] = self.ends.get(tried.end, 0) + 1
        self.sums = dict(Counter(self.sums) + Counter(dict(tried.sums)))
        self.most |= {name: max(value, self.most.get(name, value)) for name, value in tried.most.items()}
        if tried.end == "fallen":
            self.kinds[tried.kind] = self.kinds.get(tried.kind, 0) + 1
            if self.kinds[tried.kind] <= KEPT:
                self.falls.append(Fall(seed, tried.kind, tried.details))


@dataclass(slots=True)
class Counts:
    """Cases of all parts.

    Attributes:
        path: of the file that keeps them.
        parts: by name.
        origin: the first seed of each, so that every commit tries other cases.
    """

    path: Path
    parts: dict[str, Count]
    origin: int = 0

    def of(self, name: str) -> Count:
        """Those of a part."""
        return self.parts.setdefault(name, Count(self.origin))

    def save(self) -> None:
        """Replace the file; what was given out and has not ended is given out again."""
        parts: dict[str, Any] = {name: asdict(count) for name, count in self.parts.items()}
        temporary = self.path.with_suffix(".new")
        temporary.write_text(json.dumps(parts, indent=1) + "\n", encoding="utf-8")
        temporary.replace(self.path)


def load(folder: Path) -> Counts:
    """The counts of the commit so far."""
    folder.mkdir(parents=True, exist_ok=True)
    name = commit()
    path, origin = folder / f"{name}.json", int(name[:8], 16)
    document = json.loads(path.read_text("utf-8")) if path.exists() else {}
    return Counts(path, {name: _count(fields) for name, fields in document.items()}, origin)


def _count(fields: dict[str, Any]) -> Count:
    return Count(**{**fields, "falls": [Fall(**each) for each in fields["falls"]]})


def commit() -> str:
    """The commit of the working tree, marked if there are changes."""
    words = ("git", "describe", "--always", "--dirty", "--abbrev=8", "--exclude=*")
    return subprocess.run(words, capture_output=True, text=True, check=True).stdout.strip()

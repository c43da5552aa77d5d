"""What a soak has come to so far, in a file of the commit: a line for each case that begins and each that ends."""

import json
import subprocess
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field, fields
from itertools import count
from pathlib import Path
from typing import Any

from tests.soak.part import Tried


@dataclass(slots=True)
class Count:
    """Cases of a part.

    Attributes:
        begun, ended: seeds.
        ends: cases by how they ended.
        falls: seeds and details of those that have fallen, by kind.
        seconds: of the cases.
        sums, most: of `Tried`.
    """

    begun: dict[int, float] = field(default_factory=dict)
    ended: set[int] = field(default_factory=set)
    ends: Counter[str] = field(default_factory=Counter)
    falls: dict[str, list[tuple[int, str]]] = field(default_factory=dict)
    seconds: float = 0.0
    sums: Counter[str] = field(default_factory=Counter)
    most: dict[str, float] = field(default_factory=dict)

    def add(self, line: dict[str, Any]) -> None:
        """Count a line of the file."""
        seed = line["seed"]
        if "end" not in line:
            self.begun[seed] = line["moment"]
            return
        if seed not in self.ended:  # what a process says of its memory is no further case
            self.ended.add(seed)
            self.ends[line["end"]] += 1
            self.seconds += line["moment"] - self.begun.get(seed, line["moment"])
        self.sums.update(line["sums"])
        self.most |= {name: max(value, self.most.get(name, value)) for name, value in line["most"].items()}
        if line["end"] == "fallen":
            self.falls.setdefault(line["kind"], []).append((seed, line["details"]))


def _fields(tried: Tried) -> dict[str, object]:
    # `asdict` makes a Counter of pairs out of a Counter
    return {each.name: getattr(tried, each.name) for each in fields(tried)}


@dataclass(frozen=True, slots=True)
class Log:
    """The file.

    Attributes:
        path: of the file.
        origin: the first seed of each part, so that every commit tries other cases.
    """

    path: Path
    origin: int = 0

    def write(self, part: str, seed: int, tried: Tried | None = None) -> None:
        """Tell that a case begins, or how it has ended."""
        line = {"part": part, "seed": seed, "moment": time.time(), **(_fields(tried) if tried else {})}
        with self.path.open("ab", buffering=0) as file:
            file.write(f"\n{json.dumps(line)}".encode())

    def counts(self) -> dict[str, Count]:
        """The cases of each part, by name."""
        counts: dict[str, Count] = {}
        for line in self.path.read_text("utf-8").splitlines() if self.path.exists() else ():
            try:
                found = json.loads(line)
            except ValueError:  # empty, or cut off by a kill
                continue
            counts.setdefault(found["part"], Count()).add(found)
        return counts

    def cut_off(self, part: str, slot: int, jobs: int) -> list[int]:
        """The seeds of every `jobs`th case from `slot` on that has begun and not ended."""
        found = self.counts().get(part, Count())
        return [seed for seed in found.begun if seed not in found.ended and (seed - self.origin) % jobs == slot]

    def seeds(self, part: str, slot: int, jobs: int) -> Iterator[int]:
        """Those seeds, and then the ones that have not begun."""
        begun = self.counts().get(part, Count()).begun
        yield from self.cut_off(part, slot, jobs)
        yield from (seed for seed in count(self.origin + slot, jobs) if seed not in begun)


def log_in(folder: Path) -> Log:
    """The file of the commit of the working tree, which is marked if there are changes."""
    folder.mkdir(parents=True, exist_ok=True)
    words = ("git", "describe", "--always", "--dirty", "--abbrev=8", "--exclude=*")
    name = subprocess.run(words, capture_output=True, text=True, check=True).stdout.strip()
    return Log(folder / f"{name}.jsonl", int(name[:8], 16))

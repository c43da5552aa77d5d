"""Log of a soak in one file for a commit: a line when a case begins, and a line when it ends."""

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
    """Results of the cases of a part; `sums` and `most` are as in `Tried`, over all cases."""

    begun: dict[int, float] = field(default_factory=dict)  # start time by seed
    ended: set[int] = field(default_factory=set)  # seeds
    ends: Counter[str] = field(default_factory=Counter)  # numbers of cases by result
    falls: dict[str, list[tuple[int, str]]] = field(default_factory=dict)  # seeds and details of failed cases, by kind
    seconds: float = 0.0  # duration of the cases
    sums: Counter[str] = field(default_factory=Counter)
    most: dict[str, float] = field(default_factory=dict)

    def add(self, line: dict[str, Any]) -> None:
        """Add a line of the file."""
        seed = line["seed"]
        if "end" not in line:
            self.begun[seed] = line["moment"]
            return
        if seed not in self.ended:  # a message about memory is not a new case
            self.ended.add(seed)
            self.ends[line["end"]] += 1
            self.seconds += line["moment"] - self.begun.get(seed, line["moment"])
        self.sums.update(line["sums"])
        self.most |= {name: max(value, self.most.get(name, value)) for name, value in line["most"].items()}
        if line["end"] == "fallen":
            self.falls.setdefault(line["kind"], []).append((seed, line["details"]))


def _fields(tried: Tried) -> dict[str, object]:
    # `asdict` would make a Counter of pairs from a Counter
    return {each.name: getattr(tried, each.name) for each in fields(tried)}


@dataclass(frozen=True, slots=True)
class Log:
    """Log file of a commit."""

    path: Path
    origin: int = 0  # first seed of each part, which differs between commits so that each tries other cases

    def write(self, part: str, seed: int, tried: Tried | None = None) -> None:
        """Write that a case begins, or how it ended."""
        line = {"part": part, "seed": seed, "moment": time.time(), **(_fields(tried) if tried else {})}
        with self.path.open("ab", buffering=0) as file:
            file.write(f"\n{json.dumps(line)}".encode())

    def counts(self) -> dict[str, Count]:
        """Return the results of each part, by its name."""
        counts: dict[str, Count] = {}
        for line in self.path.read_text("utf-8").splitlines() if self.path.exists() else ():
            try:
                found = json.loads(line)
            except ValueError:  # empty, or cut off by a kill
                continue
            counts.setdefault(found["part"], Count()).add(found)
        return counts

    def cut_off(self, part: str, slot: int, jobs: int) -> list[int]:
        """Return the seeds of begun but not ended cases, among every `jobs`th case from `slot` on."""
        found = self.counts().get(part, Count())
        return [seed for seed in found.begun if seed not in found.ended and (seed - self.origin) % jobs == slot]

    def seeds(self, part: str, slot: int, jobs: int) -> Iterator[int]:
        """Yield the seeds of `cut_off`, then the seeds of cases that have not begun."""
        begun = self.counts().get(part, Count()).begun
        yield from self.cut_off(part, slot, jobs)
        yield from (seed for seed in count(self.origin + slot, jobs) if seed not in begun)


def log_in(folder: Path) -> Log:
    """Return the log of the current commit; its name ends in -dirty if the working tree has changes."""
    folder.mkdir(parents=True, exist_ok=True)
    words = ("git", "describe", "--always", "--dirty", "--abbrev=8", "--exclude=*")
    name = subprocess.run(words, capture_output=True, text=True, check=True).stdout.strip()
    return Log(folder / f"{name}.jsonl", int(name[:8], 16))

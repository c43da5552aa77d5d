"""A row: what a policy did on which episodes of what, what it cost, and all that is needed to do it again."""

import base64
import hashlib
import json
import math
import re
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from grind_env.envs.splits import EVERY
from grind_env.errors import quoted, shortened
from grind_env.files import read_text, shown, write_atomically
from grind_env.policies.evaluation import Evaluation
from grind_env.policies.policy import Sees
from grind_env.policies.rows.form import RowError, formed, parsed
from grind_env.policies.statistics import bootstrap, prediction
from grind_env.task_version import TASK_VERSION, of_version

FORMAT = 1
AGENT = "agent.safetensors"
"""Name in a row of the file of its trained agent."""
SAYS = re.compile(rf"(?:guarded:)?(?:\w+|(?P<module>\w+):\w+|E[\d.]+D\d+|{re.escape(AGENT)})|", re.ASCII)
"""How a row may name its policy: no path is among it."""
MOST_SAID, MOST_FILES, MOST_FILE, MOST_EPISODES = 200, 100, 16_000_000, 10_000
"""Characters of a name, files, bytes of a file, episodes."""
MOST_WHOLE = 1000
"""Highest whole number of a policy's parameters, as how many E are tried: with more no step would end."""

Numbers = tuple[float, float, float]
"""A mean and two ends."""


@dataclass(frozen=True, slots=True, kw_only=True)
class File:
    """A file in a row: a text, or bytes in base64, and the SHA-256 of its bytes in hexadecimal digits."""

    sha256: str
    text: str = ""
    base64: str = ""

    @staticmethod
    def of(data: bytes, *, text: bool) -> "File":
        """Bytes as a row has them; those of a text that are no UTF-8 are escaped as Python does it."""
        said = (
            {"text": data.decode("utf-8", "surrogateescape")} if text else {"base64": base64.b64encode(data).decode()}
        )
        return File(sha256=hashlib.sha256(data).hexdigest(), **said)

    def data(self, name: str) -> bytes:
        """The bytes.

        Raises:
            RowError: they are not what the sum is of, or too many.
        """
        try:
            data = base64.b64decode(self.base64, validate=True) or self.text.encode("utf-8", "surrogateescape")
        except ValueError:  # UnicodeEncodeError is one
            data = b""
        if hashlib.sha256(data).hexdigest() != self.sha256 or len(data) > MOST_FILE:
            most = f"{MOST_FILE / 1e6:g} MB"
            raise RowError(f"files.{quoted(name)} is longer than {most}, or not what its sha256 is of: submit it again")
        return data


@dataclass(frozen=True, slots=True, kw_only=True)
class Episode:
    """An episode.

    Attributes:
        seed: of it.
        cost: $.
        good: expected number of good parts.
        finished: number of parts finished.
        E: of every step as it was taken, mm/min.
        D: likewise, number of dress executions.
    """

    seed: int
    cost: float
    good: float
    finished: float
    E: tuple[float, ...]
    D: tuple[float, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """What a policy did and what it cost.

    Attributes:
        id: of the environment.
        program: name in `files` of a part program; likewise `job`, that of the program's name if empty, and `task`.
        parts: how often the program is run.
        policy: its name in tables.
        sees: what it is shown.
        says: how `named_policy` finds it; empty if it cannot be run again.
        parameters: of a scripted policy of the package, in the units that it takes them in.
        plant: the machine, and `model`, what it was taken for, as `Judgement` has them.
        split: that contexts were drawn from.
        files: by their names: all that problem, policy (`AGENT`) and modules (`name.py`) are read from.
        cost_per_good_part: $, and its 95 % interval; None where a part may not be good.
        cost: mean of an episode, $, and its 95 % interval.
        prediction: the same mean, $, and where that of as many others lies with 95 % (`statistics.prediction`).
        episodes: one by one.
        provenance: versions of what it was made with.

    Raises:
        RowError: episodes, files or policy do not fit.
    """

    id: str
    program: str = ""
    job: str = ""
    task: str = ""
    parts: int = 1
    policy: str
    sees: Sees
    says: str = ""
    parameters: Mapping[str, int | float | tuple[int | float, ...]] = field(default_factory=dict)
    plant: str = ""
    model: str = ""
    split: str = EVERY
    files: Mapping[str, File] = field(default_factory=dict)
    cost_per_good_part: Numbers | None
    cost: Numbers
    prediction: Numbers
    provenance: Mapping[str, str] = field(default_factory=dict)
    task_version: int = TASK_VERSION
    format: int = FORMAT
    episodes: tuple[Episode, ...]

    def __post_init__(self) -> None:
        if not 2 <= len(self.episodes) <= MOST_EPISODES:
            raise RowError(f"it has {len(self.episodes)} episodes, but must have 2 to {MOST_EPISODES}")
        if len({*self.seeds}) < len(self.seeds) or not all(0 <= seed < 1 << 64 for seed in self.seeds):
            raise RowError("a seed of its episodes is there twice, or not from 0 to 2^64 - 1: give each its own")
        for k, each in enumerate(self.episodes):
            if not 0 < len(each.E) == len(each.D):
                raise RowError(f"episodes[{k}] has {len(each.E)} E and {len(each.D)} D: give both of every step")
        if not SAYS.fullmatch(self.says) or max(map(len, (self.says, self.plant, self.model, *self.files))) > MOST_SAID:
            raise RowError(
                f"says is {quoted(self.says)}, or a name is longer than {MOST_SAID}: name a policy of the row"
            )
        if len(self.files) > MOST_FILES:
            raise RowError(f"it has {len(self.files)} files, but may have {MOST_FILES}")
        for key, value in self.parameters.items():
            numbers = value if isinstance(value, tuple) else (value,)
            if not key.isidentifier() or any(isinstance(each, int) and abs(each) > MOST_WHOLE for each in numbers):
                raise RowError(
                    f"parameters.{quoted(key)} is {quoted(value)}, but must have no whole beyond {MOST_WHOLE}"
                )

    @property
    def seeds(self) -> list[int]:
        """Of the episodes."""
        return [each.seed for each in self.episodes]

    @property
    def module(self) -> str:
        """The module of its policy; empty for a policy of the package."""
        found = SAYS.fullmatch(self.says)
        return (found and found["module"]) or ""

    def __str__(self) -> str:
        what = f"{self.id} {self.program or self.task}".strip()
        where = f"{what} on {self.plant}, taken for {self.model}" if self.plant else what
        name = shortened(self.policy)  # one with a line end would say more than there is
        which = f"{len(self.seeds)} episodes, seeds {min(self.seeds)} to {max(self.seeds)}, split {self.split}"
        return f"{name} (sees {self.sees}) in {where}, {which}: {self.cost[0]:.4g} $ an episode"


def stated(run: Evaluation) -> dict[str, Any]:
    """What a row states of an evaluation, by its fields."""
    mean = bootstrap(lambda cost: np.asarray(cost.mean(axis=-1)), run.cost)
    each, other = run.cost_per_good_part, prediction(run.cost, len(run.cost))
    known = (*each,) if all(map(math.isfinite, each)) else None
    return {"cost_per_good_part": known, "cost": (*mean,), "prediction": (*other,)}


def write_row(path: Path, row: Row) -> None:
    """Write a row as JSON, an episode a line, whole or not at all; errors as of `write_atomically`."""
    lines = [f"{json.dumps(key)}: {json.dumps(value)}" for key, value in asdict(row).items() if key != "episodes"]
    episodes = ",\n".join(json.dumps(asdict(each)) for each in row.episodes)
    text = ",\n".join([*lines, f'"episodes": [\n{episodes}\n]'])
    write_atomically(path, lambda partial: partial.write_text(f"{{\n{text}\n}}\n", encoding="utf-8"))


def read_row(path: Path) -> Row:
    """The row in a file of at most 64 MB; no name in it is opened, and no code of it is run.

    Raises:
        ReadError: the file cannot be read.
        RowError: it is no row, or one of another version.
    """
    try:
        document = parsed(read_text(path))
        if not isinstance(document, dict) or "format" not in document:
            raise RowError("it is no row: name a file that `grind evaluate --submit` wrote")
        if document["format"] != FORMAT:
            raise RowError(f"format is {quoted(document['format'])}, but this version reads {FORMAT}: submit it anew")
        if (found := document.get("task_version")) != TASK_VERSION:
            raise RowError(f"it is {of_version(found)}: submit it anew")
        row: Row = formed(Row, document, "row")
    except RowError as error:
        raise RowError(f"{shown(path)}: {error}") from None
    return row

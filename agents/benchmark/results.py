"""Table of results: a row for each cell and its inputs. Parquet also holds the episodes, CSV does not."""

import io
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow
from numpy.typing import NDArray
from pyarrow import parquet

from agents.benchmark.plan import LONG, BenchmarkCell
from agents.csv_tables import csv_of
from agents.provenance import provenance, shown_seeds
from grind_env.array_types import Array
from grind_env.files import csv_cell, read_bytes, write_atomically
from grind_env.message_text import reason
from grind_env.output_checks import FileKind
from grind_env.policies.evaluation import SEEDS, Evaluation
from grind_env.policies.policy import Sees
from grind_env.policies.tuned_parameters import ConfigError, write_whole
from grind_env.task_version import TASK_VERSION

Episodes = NDArray[np.float32]

PARQUET, CSV = "benchmark.parquet", "benchmark.csv"
TABLE = FileKind("table of `python -m agents benchmark`", re.compile(b"task,policy,kind,").match)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Result:
    """Row of the table. Intervals are 95 %, over the episodes; missing values are None."""

    task: str
    policy: str
    kind: str  #: `scripted`, `planner` or `learned`
    sees: str
    seed: int | None  #: training seed
    episodes: int
    cost_per_good_part: float | None = None  #: cost per good part, $, with the ends of its interval in the next fields
    cost_per_good_part_low: float | None = None
    cost_per_good_part_high: float | None = None
    #: score: 0 is the best fixed plan, 100 the hindsight planner; where both cost the same, `cost_ratio` is used
    score: float | None = None
    score_low: float | None = None
    score_high: float | None = None
    cost_ratio: float | None = None  #: ratio of the cost of an episode to the cost of the best fixed plan
    cost_ratio_low: float | None = None
    cost_ratio_high: float | None = None
    scrap: float  #: share of the parts that are scrap
    E_mean: float  #: mean E over all blocks, mm/min
    D_mean: float  #: mean D, dress executions per block
    #: number of episodes of the split `interpolation`, as in the next columns; the columns above are of `all`
    interpolation_episodes: int
    interpolation_cost_per_good_part: float | None = None
    interpolation_cost_per_good_part_low: float | None = None
    interpolation_cost_per_good_part_high: float | None = None
    interpolation_score: float | None = None
    interpolation_score_low: float | None = None
    interpolation_score_high: float | None = None
    interpolation_cost_ratio: float | None = None
    interpolation_cost_ratio_low: float | None = None
    interpolation_cost_ratio_high: float | None = None
    interpolation_scrap: float | None
    interpolation_seeds: str | None
    plants_episodes: int = 0  #: number of episodes on held-out machines; the next columns are of these machines, too
    plants_cost_per_good_part: float | None = None
    plants_cost_per_good_part_low: float | None = None
    plants_cost_per_good_part_high: float | None = None
    plants_scrap: float | None = None
    plants_seeds: str | None = None
    trained_on: str | None  #: split of the contexts of the training
    steps: int | None  #: number of steps of the training
    train_seconds: float | None  #: CPU time of the training, s
    model: str | None = None  #: knowledge of the simulator's equations in a decision: `none`, `nominal` or `exact`
    blocks: int | None = None  #: number of blocks ground for training or tuning, without validation
    decision_ms: float | None = None  #: CPU time of a decision, ms
    digest: str = ""  #: hash of all inputs of the row; a row with an equal hash is not run again
    task_version: int
    seeds: str
    commit: str
    python: str
    grind_env: str
    numpy: str
    numba: str
    stable_baselines3: str
    torch: str
    cost: Episodes  #: cost of every episode, $, shape (episodes,); single precision
    good: Episodes  #: expected good parts of every episode
    interpolation_cost: Episodes
    interpolation_good: Episodes
    plants_cost: Episodes = field(default_factory=lambda: np.zeros(0, np.float32))
    plants_good: Episodes = field(default_factory=lambda: np.zeros(0, np.float32))
    #: learning curve: steps of the training, and the score on validation seeds after them
    curve_steps: Episodes = field(default_factory=lambda: np.zeros(0, np.float32))
    curve_score: Episodes = field(default_factory=lambda: np.zeros(0, np.float32))

    @property
    def key(self) -> tuple[str, str, int | None]:
        return self.task, self.policy, self.seed


INTERPOLATION, PLANTS = "interpolation_", "plants_"
#: prefixes of the columns of the split `all`, of the split `interpolation`, and of held-out machines
PREFIXES = ("", INTERPOLATION, PLANTS)
EPISODES = (*(f"{prefix}{name}" for prefix in PREFIXES for name in ("cost", "good")), "curve_steps", "curve_score")
COLUMNS = [each.name for each in fields(Result) if each.name not in EPISODES]
#: types of columns by the annotations of `Result`
TYPES = {
    **dict.fromkeys((int, int | None), pyarrow.int64()),
    **dict.fromkeys((float, float | None), pyarrow.float64()),
    **dict.fromkeys((str, str | None), pyarrow.string()),
    Episodes: pyarrow.list_(pyarrow.float32()),
}
SCHEMA = pyarrow.schema([(each.name, TYPES[each.type]) for each in fields(Result)])


def result_of(
    cell: BenchmarkCell,
    sees: Sees,
    run: Evaluation,
    interpolation: Evaluation | None = None,
    plants: Evaluation | None = None,
    first: int = SEEDS["evaluation"],
    **made: Any,
) -> Result:
    """Return the row of a cell, without the values that depend on other cells; see `judge.judged`.

    `first` is the first seed of the evaluations; `made` holds the columns on the making of the policy.
    """
    facts: dict[str, Any] = dict(provenance(range(first, first + len(run.cost))))
    for prefix, other in ((INTERPOLATION, interpolation), (PLANTS, plants)):
        count = 0 if other is None else len(other.cost)
        facts |= {
            f"{prefix}episodes": count,
            f"{prefix}scrap": None if other is None else other.scrap,
            f"{prefix}seeds": shown_seeds(range(first, first + count)) if count else None,
            f"{prefix}cost": single(other, "cost"),
            f"{prefix}good": single(other, "good"),
        }
    return Result(
        task=cell.task,
        policy=cell.policy,
        kind="learned" if cell.seed is not None else "planner" if cell.base in LONG else "scripted",
        sees=sees,
        seed=cell.seed,
        episodes=len(run.cost),
        scrap=run.scrap,
        E_mean=run.speed,
        D_mean=run.dresses,
        cost=single(run, "cost"),
        good=single(run, "good"),
        **{"trained_on": None, "steps": None, "train_seconds": None, **made, **facts},
    )


def single(run: Evaluation | None, name: str) -> Episodes:
    """Return a value of every episode in single precision; an empty array without a run."""
    values: Array = np.zeros(0) if run is None else getattr(run, name)
    return values.astype(np.float32)


def row_of(found: Result) -> dict[str, Any]:
    """Return a result as a row, of a file or of the cache."""
    return {each.name: getattr(found, each.name) for each in fields(Result)}


def result(row: Mapping[str, Any]) -> Result:
    """Return the result in a row of a file or of the cache."""
    return Result(**{**row, **{name: np.array(row[name], np.float32) for name in EPISODES}})


def merged(old: Iterable[Result], new: Sequence[Result]) -> list[Result]:
    """Return old and new results, in the order of the table; a new result replaces the old one of the same key."""
    replaced = {each.key for each in new}
    kept = [each for each in old if each.key not in replaced]
    return sorted([*kept, *new], key=lambda each: (each.task, each.kind, each.policy, each.seed or 0))


def read_results(folder: Path) -> list[Result]:
    """Return the results of the present task version in a folder; a damaged file raises a ConfigError."""
    path = folder / PARQUET
    if not path.exists():
        return []
    try:
        file = io.BytesIO(read_bytes(path))
        present = [("task_version", "=", TASK_VERSION)]
        if not parquet.read_table(file, columns=["task_version"], filters=present).num_rows:
            return []
        missing = set(SCHEMA.names) - set(parquet.read_schema(file).names)
        if missing:
            raise ValueError(f"it has no column {min(missing)!r}")
        rows: list[dict[str, Any]] = parquet.read_table(file, schema=SCHEMA, filters=present).to_pylist()
        return [result(row) for row in rows]
    except (OSError, pyarrow.ArrowException, TypeError, ValueError) as error:
        raise ConfigError(f"{path} is damaged ({reason(error)}): delete it and run the benchmark again") from error


def write_results(results: Sequence[Result], folder: Path) -> None:
    """Write both files, each in one atomic step, and make the folder."""
    cells = [
        ["" if (value := getattr(each, name)) is None else csv_cell(value) for name in COLUMNS] for each in results
    ]
    write_whole(folder / CSV, csv_of(COLUMNS, cells))
    table = pyarrow.Table.from_pylist([row_of(each) for each in results], SCHEMA)
    write_atomically(folder / PARQUET, lambda path: parquet.write_table(table, path, compression="zstd"))

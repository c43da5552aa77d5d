"""Study of the training recipe of `docs/howto/train.md`, also with other seeds, without belief, and on other tasks."""

import os
import re
import time
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields
from itertools import product
from pathlib import Path
from statistics import mean, stdev
from tempfile import TemporaryDirectory
from typing import Any

from agents.csv_tables import csv_of, csv_rows, typed
from agents.evaluation_cache import sources
from agents.provenance import ROOT, provenance
from agents.study import Found, Study, StudyOptions
from grind_env.data_table import Column, table_of
from grind_env.envs import wrappers
from grind_env.errors import GrindError
from grind_env.files import read_text
from grind_env.policies.evaluation import episode_seeds
from grind_env.policies.problem_lookup import Problem
from grind_env.policies.tuned_parameters import write_whole

SOURCE = ROOT / "docs" / "howto" / "train.md"
BLOCK = re.compile(r"```python\n(.*?)```", re.DOTALL)
TRAINS = "model.learn("  #: text that marks the Python block of the recipe
BELIEF = re.compile(r"^envs = VectorBeliefFilter\(.*\n", re.MULTILINE)
SEED, STEPS, TASK = "seed=0", "1_000_000", '"grind/PowerLimited-v0"'
WAYS = {"measurements": "measurements", "belief": "measurements and belief"}
EPISODES = 128
CSV, PAGE = "recipe.csv", "recipe.md"
TITLE = "# The training recipe"


@dataclass(frozen=True)
class RecipeTrial:
    """Training of an agent: task, observation, seed, number of steps, and the code lines."""

    problem: Problem
    way: str
    seed: int
    steps: int | None = None
    text: str = field(default="", repr=False)

    def __str__(self) -> str:
        return f"{self.problem.name}, {WAYS[self.way]}, seed {self.seed}"


@dataclass(frozen=True, slots=True, kw_only=True)
class RecipeRow:
    """Result of a training on evaluation episodes, with a 95 % interval over them."""

    task: str
    sees: str
    seed: int
    steps: int
    episodes: int
    score: float
    score_low: float
    score_high: float
    cost_per_good_part: float
    scrap: float
    E: float
    D: float
    cpu_seconds: float  #: CPU time of imports, training and judging on one core, s
    wall_seconds: float


def recipe(page: str) -> str:
    """Return the only Python block of a page that trains."""
    found = [block for block in BLOCK.findall(page) if TRAINS in block]
    if len(found) != 1:
        raise GrindError(f"{SOURCE.name} has {len(found)} blocks with {TRAINS!r}, but must have one: the recipe")
    return str(found[0])


def variant(text: str, trial: RecipeTrial) -> str:
    """Return the recipe changed to another task, seed or number of steps, or without the belief.

    Raises:
        GrindError: a text to change is not in the recipe exactly once, or the task is a file, which has no id.
    """
    if trial.problem.arguments:
        raise GrindError(
            f"{trial.problem.name} is a file, and the recipe names its task by an id: choose a registered one"
        )
    if TASK not in text:
        raise GrindError(f"the recipe of train.md does not train on {TASK}, so that it cannot be run on another task")
    changes = [(re.escape(SEED), f"seed={trial.seed}")]
    changes += [] if trial.way == "belief" else [(BELIEF.pattern, "")]
    changes += [] if trial.steps is None else [(STEPS, str(trial.steps))]
    for pattern, new in changes:
        text, count = re.subn(pattern, new, text, flags=re.MULTILINE)
        if count != 1:
            raise GrindError(f"the recipe of train.md has {pattern!r} {count} times, but must have it once")
    return text.replace(TASK, f'"{trial.problem.id}"')


def run(text: str) -> dict[str, Any]:
    """Run the lines of the recipe; return the names that they bind, and the seconds that they took."""
    names: dict[str, Any] = {}
    wall, cpu = time.perf_counter(), time.process_time()
    exec(compile(text, SOURCE.name, "exec"), names)
    return {**names, "cpu_seconds": time.process_time() - cpu, "wall_seconds": time.perf_counter() - wall}


def train(trial: RecipeTrial) -> dict[str, Any]:
    """Return the result of the recipe in a trial: the fields of `RecipeRow`."""
    text, before = variant(trial.text, trial), Path.cwd()
    with TemporaryDirectory() as folder:
        os.chdir(folder)
        try:
            named = run(text)
        finally:
            os.chdir(before)
    found = named["judged"].numbers() | named
    asked = {"task": trial.problem.name, "sees": trial.way, "seed": trial.seed, "steps": trial.steps}
    return {name: asked.get(name, found.get(name)) for name in COLUMNS}


def study(asked: StudyOptions) -> Study:
    """Return the study of the recipe, on measurements alone and with the belief."""
    text = recipe(read_text(SOURCE))
    trials = [
        RecipeTrial(problem, way, seed, asked.steps, text)
        for problem in asked.problems
        for way in WAYS
        for seed in range(asked.seeds)
    ]

    def publish(found: Found, folder: Path) -> str:
        return write([RecipeRow(**each) for each in found.values()], folder)

    def decides(trial: RecipeTrial) -> object:
        return variant(text, trial), sources(wrappers.__name__), sources("grind_env.sb3.vec_env")

    return Study(
        name="recipe",
        title="The training recipe",
        trials=trials,
        run=train,
        decides=decides,
        columns=COLUMNS[:4],
        publish=publish,
        seconds=lambda trial: 1e-4 * trial.steps,
    )


def write(found: Sequence[RecipeRow], results: Path) -> str:
    """Write table and page; rows of other tasks stay if steps, episodes and task version are equal."""
    made_with = provenance(episode_seeds("evaluation", EPISODES))
    new = [{name: str(value) for name, value in (asdict(each) | made_with).items()} for each in found]
    tasks = {row["task"] for row in new}
    before = csv_rows(results / CSV) if (results / CSV).exists() else []
    kept = [row for row in before if row["task"] not in tasks and _alike(row, new[0])]
    rows = sorted(kept + new, key=lambda row: row["task"])
    text = csv_of(list(rows[0]), [list(row.values()) for row in rows])
    shown = page([typed(RecipeRow, row) for row in rows])
    write_whole(results / CSV, text)
    write_whole(results / PAGE, shown)
    return shown


def _alike(one: Mapping[str, str], other: Mapping[str, str]) -> bool:
    """Return whether two rows may be in one table."""
    return one.keys() == other.keys() and all(
        one[name] == other[name] for name in ("steps", "episodes", "task_version")
    )


def scores(runs: Sequence[RecipeRow]) -> list[float]:
    """Return the score of each seed."""
    return [each.score for each in runs]


COLUMNS = tuple(each.name for each in fields(RecipeRow))
#: columns of the page; a row is for all seeds of a task and observation
SHOWN = (
    Column("task", lambda runs: runs[0].task),
    Column("observation", lambda runs: WAYS[runs[0].sees]),
    Column("mean score", lambda runs: mean(scores(runs)), ".1f"),
    Column("standard deviation", lambda runs: stdev(scores(runs)) if len(runs) > 1 else None, ".1f"),
    Column("lowest", lambda runs: min(scores(runs)), ".1f"),
    Column("highest", lambda runs: max(scores(runs)), ".1f"),
    Column("seeds", len, "d"),
    Column("$ per good part", lambda runs: mean(each.cost_per_good_part for each in runs), ".2f"),
    Column("CPU-seconds of a seed", lambda runs: mean(each.cpu_seconds for each in runs), ".0f"),
)


def page(found: Sequence[RecipeRow]) -> str:
    """Return the table of all seeds as Markdown."""
    ways = product(dict.fromkeys(each.task for each in found), WAYS)
    rows = [[each for each in found if (each.task, each.sees) == way] for way in ways]
    return (
        f"{TITLE}\n\n`python -m agents recipe`: {found[0].steps:,} steps a training, judged on {found[0].episodes}"
        f" evaluation episodes.\n\n{table_of(SHOWN, rows).markdown()}\n"
    )

"""The training recipe of `docs/howto/train.md`, run as printed, with other seeds, without belief, on other tasks."""

import hashlib
import json
import os
import re
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from itertools import product
from pathlib import Path
from statistics import mean
from typing import Any, NamedTuple, get_type_hints

from rich.console import Console

from agents.cells import RESULTS, RUNS, behaviour, sources
from agents.pool import find_all
from agents.provenance import ROOT, installed, provenance
from agents.tables import check_tables, csv_of, csv_rows
from grind_env.envs import wrappers
from grind_env.errors import GrindError
from grind_env.files import read_text
from grind_env.pages.markdown import table
from grind_env.policies.evaluation import episode_seeds
from grind_env.policies.problem import Problem
from grind_env.policies.tuned import write_whole

SOURCE = ROOT / "docs" / "howto" / "train.md"
BLOCK = re.compile(r"```python\n(.*?)```", re.DOTALL)
TRAINS = "model.learn("
"""By which the block is known."""
BELIEF = re.compile(r"^envs = VectorBeliefFilter\(.*\n", re.MULTILINE)
SEED, STEPS, TASK = "seed=0", "1_000_000", '"grind/PowerLimited-v0"'
WAYS = {"measurements": "measurements alone", "belief": "with the belief"}
EPISODES = 128
LIBRARIES = ("gymnasium", "numpy", "stable_baselines3", "torch")
CSV, PAGE = "recipe.csv", "recipe.md"
TITLE = "# The training recipe"
BEGINS = {CSV: "task,sees,seed,steps,", PAGE: TITLE}


class Cell(NamedTuple):
    """A training: of which task, what it sees, and its seed."""

    problem: Problem
    way: str
    seed: int

    def __str__(self) -> str:
        return f"{self.problem.name}, {WAYS[self.way]}, seed {self.seed}"


@dataclass(frozen=True, slots=True)
class Request:
    """How the recipe is run.

    Attributes:
        text: the Python block of the page.
        steps: of a training.
        folder: of what is kept.
    """

    text: str
    steps: int
    folder: Path

    @property
    def size(self) -> int:
        """A training tells nothing on the way."""
        return 1


@dataclass(frozen=True, slots=True, kw_only=True)
class Trained:
    """What a training came to, judged on evaluation episodes; the interval is 95 %, over these."""

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
    cpu_seconds: float
    """Of imports, training and judging, on one core."""
    wall_seconds: float


def recipe(page: str) -> str:
    """Return the Python block of a page that trains.

    Raises:
        GrindError: there are none, or several blocks of them.
    """
    found = [block for block in BLOCK.findall(page) if TRAINS in block]
    if len(found) != 1:
        raise GrindError(f"{SOURCE.name} has {len(found)} blocks with {TRAINS!r}, but must have one: the recipe")
    return str(found[0])


def variant(text: str, cell: Cell, steps: int | None = None) -> str:
    """The recipe for another task, with another seed or other steps, or without the belief, and else as it stands.

    Raises:
        GrindError: what is to be changed does not stand in it just once, or the task is a file, which no id names.
    """
    if cell.problem.arguments:
        raise GrindError(
            f"{cell.problem.name} is a file, and the recipe names its task by an id: choose a registered one"
        )
    if TASK not in text:
        raise GrindError(f"the recipe of train.md does not train on {TASK}, so that it cannot be run on another task")
    changes = [(re.escape(SEED), f"seed={cell.seed}")]
    changes += [] if cell.way == "belief" else [(BELIEF.pattern, "")]
    changes += [] if steps is None else [(STEPS, str(steps))]
    for pattern, new in changes:
        text, count = re.subn(pattern, new, text, flags=re.MULTILINE)
        if count != 1:
            raise GrindError(f"the recipe of train.md has {pattern!r} {count} times, but must have it once")
    return text.replace(TASK, f'"{cell.problem.id}"')


def run(text: str) -> dict[str, Any]:
    """Run the lines of the recipe; return the names they bind and the seconds they took."""
    names: dict[str, Any] = {}
    wall, cpu = time.perf_counter(), time.process_time()
    exec(compile(text, SOURCE.name, "exec"), names)
    return {**names, "cpu_seconds": time.process_time() - cpu, "wall_seconds": time.perf_counter() - wall}


def train(cell: Cell, request: Request, tell: Callable[[int], object]) -> Trained:
    """What the recipe comes to in a cell, which is kept as soon as it is known; its model lies beside it.

    Raises:
        GrindError: as `variant`.
    """
    text = variant(request.text, cell, request.steps)
    path = request.folder / f"{cell.problem.name}-{cell.way}-{cell.seed}-{fingerprint(text, cell.problem)}.json"
    if path.exists():
        return Trained(**json.loads(read_text(path)))
    place = path.with_suffix("")
    place.mkdir(parents=True, exist_ok=True)
    before = Path.cwd()
    os.chdir(place)
    try:
        named = run(text)
    finally:
        os.chdir(before)
    found = named["judged"].numbers() | named
    numbers = {each.name: found[each.name] for each in fields(Trained) if each.name in found}
    asked = {"task": cell.problem.name, "sees": cell.way, "seed": cell.seed, "steps": request.steps}
    done = Trained(**{**numbers, **asked})
    write_whole(path, json.dumps(asdict(done)))
    tell(1)
    return done


def fingerprint(text: str, problem: Problem) -> str:
    """Stands for all that decides what a training ends in."""
    simulation, versions = problem.simulation(), [installed(library) for library in LIBRARIES]
    parts = [text, sources(wrappers.__name__), sources("grind_env.sb3.adapter"), behaviour(simulation), versions]
    return hashlib.sha256("\0".join(map(str, parts)).encode()).hexdigest()[:12]


def run_recipe(
    problems: Sequence[Problem],
    seeds: int,
    steps: int,
    *,
    jobs: int,
    console: Console,
    runs: Path = RUNS,
    results: Path = RESULTS,
) -> list[Trained]:
    """Run the recipe both ways; what was trained before by the same lines and code is taken up again.

    Args:
        problems: registered environments.
        seeds: of each way, from 0.
        steps: of a training.
        jobs: processes.
        console: shows how far it is.
        runs: folder of what is kept, in its sub-folder `recipe`.
        results: folder of the table.

    Raises:
        FileError: another table has the name of one that is to be written.
        GrindError: the page has no recipe, or a training failed.
    """
    request = Request(recipe(read_text(SOURCE)), steps, runs.absolute() / "recipe")
    results.mkdir(parents=True, exist_ok=True)
    check_tables(results, "recipe", BEGINS)
    cells = [Cell(problem, way, seed) for problem in problems for way in WAYS for seed in range(seeds)]
    found = find_all(cells, request, jobs, console, train)
    write(found, results)
    return found


def write(found: Sequence[Trained], results: Path) -> None:
    """Write the table as CSV and as a page; what it has of other tasks of this version and of as many steps stays."""
    made_with = provenance(episode_seeds("evaluation", EPISODES))
    new = [{name: str(value) for name, value in (asdict(each) | made_with).items()} for each in found]
    tasks = {row["task"] for row in new}
    before = csv_rows(results / CSV) if (results / CSV).exists() else []
    kept = [row for row in before if row["task"] not in tasks and _alike(row, new[0])]
    rows = sorted(kept + new, key=lambda row: row["task"])
    text = csv_of(list(rows[0]), [list(row.values()) for row in rows])
    for name, content in ((CSV, text), (PAGE, page([_trained(row) for row in rows]))):
        write_whole(results / name, content)


def _alike(one: Mapping[str, str], other: Mapping[str, str]) -> bool:
    """Whether two rows may stand in one table."""
    return one.keys() == other.keys() and all(
        one[name] == other[name] for name in ("steps", "episodes", "task_version")
    )


def _trained(row: Mapping[str, str]) -> Trained:
    kinds = get_type_hints(Trained)
    return Trained(**{name: kind(row[name]) for name, kind in kinds.items()})


HEADINGS = (
    "task",
    "what it sees",
    "mean score",
    "least",
    "score of each seed",
    "$ per good part",
    "CPU-seconds of each",
)


def page(found: Sequence[Trained]) -> str:
    """The table of all seeds, Markdown."""
    rows = []
    for task, (way, title) in product(dict.fromkeys(each.task for each in found), WAYS.items()):
        of_way = [each for each in found if (each.task, each.sees) == (task, way)]
        scores = [each.score for each in of_way]
        rows.append(
            (
                task,
                title,
                f"{mean(scores):.1f}",
                f"{min(scores):.1f}",
                ", ".join(f"{score:.1f}" for score in scores),
                f"{mean(each.cost_per_good_part for each in of_way):.2f}",
                ", ".join(f"{each.cpu_seconds:.0f}" for each in of_way),
            )
        )
    return (
        f"{TITLE}\n\n`python -m agents recipe`: {found[0].steps:,} steps of each, {found[0].episodes} evaluation"
        " episodes.\n\n" + table(HEADINGS, rows) + "\n"
    )

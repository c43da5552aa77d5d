"""A study as data: its trials run once, are cached with all their inputs, and become a table and a page."""

import hashlib
import json
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, fields
from functools import cache
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console

from agents.csv_tables import check_tables, csv_of
from agents.evaluation_cache import RUNS, behaviour, sources
from agents.parallel_trials import run_all
from agents.provenance import TRAINING, installed, provenance
from grind_env.command_exit import command
from grind_env.errors import GrindError
from grind_env.file_arguments import Application, Keeps
from grind_env.files import ReadError, read_text
from grind_env.policies.evaluation import episode_seeds
from grind_env.policies.problem_lookup import Problem, find_problem
from grind_env.policies.tuned_parameters import write_whole
from grind_env.terminal_output import table_console

Found = Mapping[Any, Any]  #: results by trial
LIBRARIES = ("numpy", "numba", "gymnasium", *TRAINING)

Jobs = Annotated[int, typer.Option(min=1, help="Number of processes.")]
Ray = Annotated[
    str | None,
    typer.Option("--ray", metavar="local|ADDRESS", help="Run on a Ray cluster: local, or host:port of its head."),
]
Runs = Annotated[Path, typer.Option("--cache", help="Cache folder; default ./runs.", show_default=False), Keeps()]
Results = Annotated[
    Path | None, typer.Option(help="Folder of tables; default agents/results if full, else cache."), Keeps()
]
Hours = Annotated[bool, typer.Option("--hours", help="Only say how long it would take.")]
Fresh = Annotated[bool, typer.Option("--fresh", help="Repeat runs that are cached.")]


@dataclass(frozen=True, kw_only=True)
class Options:
    """Options of running trials."""

    jobs: int = 1
    ray: str | None = None
    runs: Path = RUNS
    fresh: bool = False
    hours: bool = False
    console: Console


@dataclass(frozen=True, kw_only=True)
class StudyOptions:
    """Options of a study; `tasks` is None if the user names none; `seeds` counts trainings, or runs on each machine."""

    problems: Sequence[Problem]
    tasks: str | None = None
    job: str | None = None
    parts: int = 1
    episodes: int
    seeds: int
    steps: int
    configs: Path | None
    results: Path
    options: Options


@dataclass(frozen=True, kw_only=True)
class Study:
    """Study as data."""

    name: str  #: name of its command and files
    title: str  #: title of its page
    trials: Sequence[Any]  #: frozen dataclasses; a field `problem` or `task` names the problem
    # `run(trial)`: result of a trial, as JSON types. A function of a module, which processes import.
    run: Callable[[Any], Any]
    columns: Sequence[str] = ()  #: columns of the table; by default the fields of trials and results
    page: Callable[[Found], str] = lambda found: ""  #: `page(found)`: Markdown below the title
    # `rows(found)`: rows of the table under `columns`
    rows: Callable[[Found], Iterable[Sequence[object]]] | None = None
    episodes: int = 1  #: evaluation episodes, whose seeds are in every row; 0 for none
    # `decides(trial)`: further inputs of the result, beside the code of `run`, the trial and its task
    decides: Callable[[Any], object] = lambda trial: None
    seconds: Callable[[Any], float] = lambda trial: 0.0  #: `seconds(trial)`: estimated CPU-seconds
    trains: bool = True  #: whether every row has the versions of Stable-Baselines3 and torch, too
    prepare: Callable[[], object] = lambda: None  #: called before the first trial
    # `draw(found, folder)`: writes further files, such as the figures of the page
    draw: Callable[[Found, Path], object] = lambda found, folder: None
    # `publish(found, folder)`: writes further files, and returns text to print
    publish: Callable[[Found, Path], str] | None = None
    files: Mapping[str, str] | None = None  #: first characters of further files, by name

    def check(self, folder: Path) -> None:
        """Refuse a folder in which other files have the names of the files of this study."""
        check_tables(folder, self.name, self.written)

    @property
    def heading(self) -> str:
        return f"# {self.title}"

    @property
    def written(self) -> Mapping[str, str]:
        """Return the first characters of the written files, by name."""
        own = {f"{self.name}.csv": ",".join(self.columns), f"{self.name}.md": self.heading}
        return own if self.files is None else self.files

    def path(self, trial: Any, runs: Path) -> Path:
        """Return the cache file of a trial; its name has a hash of all inputs of the result."""
        return runs / self.name / f"{re.sub(r'[^A-Za-z0-9_.]+', '-', str(trial))[:80]}-{self.digest(trial)}.json"

    def digest(self, trial: Any) -> str:
        """Return a hash of all inputs that decide the result of a trial."""
        name = getattr(trial, "problem", None) or getattr(trial, "task", None)
        problem = find_problem(name) if isinstance(name, str) else name
        decides = [
            sources(self.run.__module__),
            repr(trial),
            None if problem is None else of_problem(problem),
            self.decides(trial),
            *map(installed, LIBRARIES),
        ]
        return hashlib.sha256("\0".join(map(str, decides)).encode()).hexdigest()[:16]

    def cached(self, trial: Any, runs: Path) -> Any:
        """Return the cached result of a trial; None without one."""
        with suppress(ReadError, ValueError):  # a missing or damaged file is written again
            return json.loads(read_text(self.path(trial, runs)))
        return None

    def cache(self, trial: Any, found: Any, runs: Path) -> None:
        write_whole(self.path(trial, runs), json.dumps(found, default=lambda array: array.tolist()))

    def find(self, options: Options) -> tuple[Found, Mapping[Any, str]]:
        """Run the trials that are not cached; return all results, and a sentence for each failed trial."""
        runs = options.runs.absolute()
        waiting = [trial for trial in self.trials if options.fresh or self.cached(trial, runs) is None]
        hours = sum(map(self.seconds, waiting)) / 3600.0
        said = f"{len(self.trials)} runs, {len(waiting)} to do: about {hours:.1f} core-hours"
        options.console.print(f"{self.name}: {said}", highlight=False)
        if options.hours:
            raise typer.Exit

        def done(trial: Any, found: Any) -> None:
            self.cache(trial, found, runs)

        failed = run_all(waiting, self.run, options.jobs, options.console, options.ray, done)
        return {trial: self.cached(trial, runs) for trial in self.trials if trial not in failed}, failed

    def found(self, options: Options) -> Found:
        """Return the results of all trials; raise a GrindError if a trial has failed."""
        found, failed = self.find(options)
        if failed:
            trial, why = next(iter(failed.items()))
            raise GrindError(f"{len(failed)} of {len(self.trials)} trials failed: {trial}: {why}")
        return found

    def write(self, found: Found, folder: Path) -> str:
        """Write the table and the page, and return the page."""
        if self.publish is not None:
            return self.publish(found, folder)
        made = provenance(episode_seeds("evaluation", self.episodes or 1), trains=self.trains)
        if not self.episodes:
            del made["seeds"]
        rows = [(*row, *made.values()) for row in (self.rows or _plain)(found)]
        text = f"{self.heading}\n\n{self.page(found)}\n"
        write_whole(folder / f"{self.name}.csv", csv_of([*self.columns, *made], rows))
        write_whole(folder / f"{self.name}.md", text)
        self.draw(found, folder)
        return text

    def publish_to(self, folder: Path, options: Options) -> None:
        """Run the study and write its files."""
        folder.mkdir(parents=True, exist_ok=True)
        self.check(folder)
        if not options.hours:
            self.prepare()
        text = self.write(self.found(options), folder)
        options.console.print(text, soft_wrap=True, highlight=False, markup=False)
        options.console.print(f"written to {folder}: {', '.join(self.written)}", highlight=False)


@cache
def of_problem(problem: Problem) -> tuple[str, float]:
    """Return a fingerprint of a problem's behaviour and prices."""
    return behaviour(problem.simulation()), problem.simulation().task.reference_cost


def _plain(found: Found) -> list[tuple[object, ...]]:
    return [(*(getattr(trial, f.name) for f in fields(trial)), *each.values()) for trial, each in found.items()]


def main(study: Study) -> None:
    """Run a study from the command line of its file; cache and tables lie below the working folder."""
    app = Application()

    @app.command(help=study.title)
    def run(
        jobs: Jobs = 2, ray: Ray = None, runs: Runs = Path("runs"), results: Results = Path(), fresh: Fresh = False
    ) -> None:
        options = Options(jobs=jobs, ray=ray, runs=runs, fresh=fresh, console=table_console())
        study.publish_to(results or runs, options)

    with command(study.name):
        app()

"""Evaluations of many policies on many problems, in processes side by side, kept for whoever asks for them next."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from glob import escape
from pathlib import Path
from typing import NamedTuple

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from agents.cells import CHUNK, RUNS, Advance, kept_evaluation
from agents.pool import work_on_all
from grind_env.policies.evaluation import Evaluation, episode_seeds
from grind_env.policies.problem import Problem
from grind_env.policies.registry import make_policy


class Chunk(NamedTuple):
    """Some evaluation episodes of a policy: what is kept as one."""

    problem: Problem
    policy: str
    seeds: range

    def __str__(self) -> str:
        return f"{self.problem.name} {self.policy}, seeds {self.seeds.start} to {self.seeds.stop - 1}"

    @property
    def files(self) -> tuple[str, ...]:
        """Pattern of what is kept of it."""
        return (f"{escape(self.problem.name)}/cells/{self.policy}/{self.seeds.start}.npz",)

    @property
    def trains(self) -> bool:
        """No agent is trained."""
        return False


@dataclass(frozen=True, slots=True, kw_only=True)
class Places:
    """Where evaluations are kept, and tuned parameters lie."""

    runs: Path = RUNS
    configs: Path | None = None

    @property
    def size(self) -> int:
        """Episodes of a chunk."""
        return CHUNK


def measured(chunk: Chunk, places: Places, advance: Advance = lambda episodes: None) -> Evaluation:
    """The kept evaluation of a policy."""
    policy = make_policy(chunk.policy, chunk.problem.simulation(), places.configs)
    return kept_evaluation(policy, chunk.problem, chunk.seeds, places.runs, advance=advance)


def measure_all(
    names: Mapping[Problem, Sequence[str]],
    episodes: int,
    places: Places,
    jobs: int,
    console: Console,
    cluster: str | None = None,
) -> dict[Problem, dict[str, Evaluation]]:
    """Evaluations of the named policies of each problem, on its first evaluation episodes.

    Raises:
        GrindError: a policy has not been tuned or does not fit.
    """
    seeds = episode_seeds("evaluation", episodes)
    parts = [seeds[first : first + CHUNK] for first in range(0, episodes, CHUNK)]
    # those that know most take longest, and come last in the lists
    chunks = [Chunk(problem, name, part) for problem, of in names.items() for name in reversed(of) for part in parts]
    if jobs > 1 or cluster is not None:
        work_on_all(chunks, places, jobs, console, measured, cluster)
    found: dict[Problem, dict[str, Evaluation]] = {problem: {} for problem in names}
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, console=console, transient=True) as progress:
        for problem, of in names.items():
            bar = progress.add_task(problem.name, total=len(of))
            for name in of:
                progress.update(bar, description=f"{problem.name}: {name}")
                found[problem][name] = measured(Chunk(problem, name, seeds), places)
                progress.advance(bar)
    return found

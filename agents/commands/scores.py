"""`python -m agents scores`."""

import sys
from importlib import import_module
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from agents.budgets import SCORE_EPISODES
from agents.cells import RESULTS, RUNS
from grind_env.policies.tuned import CONFIGS
from grind_env.scores import FILE as SCORES

OTHERS = {
    "wen": ("agents.reference.scores", "score_wen"),
    "reciprocation": ("agents.reference.reciprocation_scores", "score_reciprocation"),
    "stroke": ("agents.reference.stroke_scores", "score_stroke"),
    "wide_plates": ("agents.reference.wide_plates_scores", "score_wide_plates"),
}
"""Environments that are no tasks of G82 blocks, and the module and function that measure each."""


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command(epilog="Example: python -m agents scores --task power_limited")(scores)


def scores(
    task: Annotated[str | None, typer.Option(help=f"Name of the task, or {', '.join(OTHERS)}; all by default.")] = None,
    episodes: Annotated[int, typer.Option(min=2, help="Evaluation episodes of a task of G82 blocks.")] = SCORE_EPISODES,
    compare: Annotated[bool, typer.Option("--compare", help="Only set the tables beside the published costs.")] = False,
    runs: Annotated[Path, typer.Option(help="Folder of what is kept.")] = RUNS,
    configs: Annotated[Path, typer.Option(help="Folder of the tuned parameters of the scripted policies.")] = CONFIGS,
    results: Annotated[Path, typer.Option(help="Folder of the tables.")] = RESULTS,
    data: Annotated[Path, typer.Option(help="File of the reference scores.")] = SCORES,
) -> None:
    """Measure the reference scores: tune what is missing, run every policy, write the tables."""
    from agents.reference.compare import compare as compare_published
    from agents.reference.compare import comparison_table
    from agents.reference.scores import score, scored_tasks
    from agents.reference.table import WIDTH

    names = [*OTHERS, *scored_tasks()] if task is None else [task]
    if compare:
        known = [name for name in names if name not in OTHERS]
        Console(width=None if sys.stdout.isatty() else WIDTH).print(comparison_table(compare_published(known, results)))
        return
    for name in names:
        if name in OTHERS:
            score_other(name, data)
        else:
            score(name, episodes=episodes, results=results, runs=runs, configs=configs, data=data)


def score_other(name: str, data: Path) -> None:
    """Measure the reference scores of one of `OTHERS`."""
    module, function = OTHERS[name]
    getattr(import_module(module), function)(data)

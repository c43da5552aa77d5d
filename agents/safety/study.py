"""The safe track over tasks: who decides in them, how long that takes, and where it is written."""

from collections.abc import Sequence
from dataclasses import asdict, fields
from pathlib import Path

from rich.console import Console

from agents.cells import RESULTS, RUNS
from agents.pool import find_all
from agents.provenance import provenance
from agents.safety.judging import LAGRANGIAN, RULES, UNCONSTRAINED, Cell, Judged, Request, work
from agents.safety.page import TITLE, page
from agents.tables import check_tables, csv_of
from grind_env.policies.evaluation import episode_seeds
from grind_env.policies.problem import Problem
from grind_env.policies.tuned import write_whole

CSV, PAGE = "safety.csv", "safety.md"
BEGINS = {CSV: ",".join(each.name for each in fields(Judged)), PAGE: TITLE}
STEP, EPISODE = 8e-5, 0.1
"""CPU-seconds, by measurement: of a step of a training, and of an episode of a rule, which looks ahead."""


def run_safety(
    problems: Sequence[Problem],
    seeds: int,
    steps: int,
    episodes: int,
    *,
    jobs: int,
    console: Console,
    runs: Path = RUNS,
    results: Path = RESULTS,
) -> list[Judged]:
    """Train and judge all cells, and write the table.

    Args:
        problems: environments whose steps are blocks.
        seeds: of each training, from 0.
        steps: of a training.
        episodes: evaluation episodes.
        jobs: processes.
        console: shows how far it is.
        runs: folder of what is kept, in its sub-folder `safety`.
        results: folder of the table.

    Raises:
        FileError: another table has the name of one that is to be written.
        GrindError: a cell failed.
    """
    results.mkdir(parents=True, exist_ok=True)
    check_tables(results, "safety", BEGINS)
    cells = [
        Cell(problem, who, seed)
        for problem in problems
        for who in (UNCONSTRAINED, LAGRANGIAN, *RULES)
        for seed in range(1 if who in RULES else seeds)
    ]
    request = Request(steps, episodes, runs.absolute() / "safety")
    hours = sum(EPISODE * episodes if cell.who in RULES else STEP * steps for cell in cells) / 3600.0
    console.print(f"{len(cells)} cells: about {hours:.1f} core-hours where none is kept")
    found = find_all(cells, request, jobs, console, work)
    rows = [asdict(each) | provenance(episode_seeds("evaluation", episodes)) for each in found]
    text = csv_of(list(rows[0]), [list(row.values()) for row in rows])
    for name, content in ((CSV, text), (PAGE, page(found))):
        write_whole(results / name, content)
    return found

"""Compares policies on the same evaluation episodes and writes the tables of `runs/<task>/benchmark.*`."""

import csv
import hashlib
import io
import os
import sys
import zipfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, astuple, dataclass, fields
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

from agents.evaluate import Evaluation, episode_seeds, evaluate
from agents.policy import Policy, Sees
from agents.provenance import ROOT, code_hash, provenance
from agents.registry import FIXED_PLANS, REFERENCE, check_names, make_policy, policy_names
from agents.statistics import Interval
from agents.tuned import CONFIGS, write_whole
from grind_env.envs.tasks import Task

EPISODES = 128
RUNS = ROOT / "runs"
KNOWLEDGE: tuple[Sees, ...] = ("measurements", "state", "future")
"""From least to most, the order of the table."""
HEADINGS = ("policy", "sees", "$/good part", "scrap %", "E m/min", "D", "score (95 % interval)")
WIDTH = 110
"""Columns of the printed table where the output is not a terminal."""


@dataclass(frozen=True, slots=True)
class Row:
    """One line of the table."""

    policy: str
    sees: Sees
    cost: Interval
    """$ per good part."""
    scrap: float
    """Share of the parts."""
    speed: float
    """Mean E, m/min."""
    executions: float
    """Mean D."""
    score: Interval
    """0 is the best fixed plan, 100 the hindsight planner."""

    def cells(self) -> tuple[str, ...]:
        """The texts under `HEADINGS`."""
        return (
            self.policy,
            self.sees,
            f"{self.cost.value:.3f} ± {self.cost.half_width:.3f}",
            f"{100.0 * self.scrap:.2f}",
            f"{self.speed:.1f}",
            f"{self.executions:.2f}",
            f"{self.score.value:.1f} ({self.score.low:.1f} to {self.score.high:.1f})",
        )


def benchmark(
    task: Task,
    names: Sequence[str] | None = None,
    *,
    learned: Sequence[Policy] = (),
    episodes: int = EPISODES,
    folder: Path = RUNS,
    configs: Path = CONFIGS,
    fresh: bool = False,
    console: Console | None = None,
) -> list[Row]:
    """Run policies on the first evaluation seeds, print the table and write it.

    The fixed plans and the planner that anchor the score are always run. What a scripted policy or a planner did
    is kept below `folder` and used again while code, parameters and seeds are the same; learned ones always run.

    Args:
        task: the task.
        names: policies; all of the task by default.
        learned: trained agents.
        episodes: number of episodes.
        folder: of the results, which come into its sub-folder of the task's name.
        configs: folder of the tuned parameters.
        fresh: run also what is kept.
        console: where to print.

    Raises:
        ConfigError: if a policy is unknown or has not been tuned for the task.
    """
    console = console or Console(width=None if sys.stdout.isatty() else WIDTH)
    seeds = episode_seeds("evaluation", episodes)
    wanted = {*check_names(task, names), *FIXED_PLANS, REFERENCE}
    anchored = [name for name in policy_names(task) if name in wanted]
    policies = [make_policy(name, task, configs) for name in anchored]
    target = folder / task.name
    results: dict[str, Evaluation] = {}
    with console.status("") as status:
        for policy in policies:
            status.update(f"{policy.name}: {episodes} episodes")
            results[policy.name] = kept_evaluation(policy, task, seeds, target / "benchmark", fresh)
        for policy in learned:
            status.update(f"{policy.name}: {episodes} episodes")
            results[policy.name] = evaluate(policy, task, seeds)
    rows = table_rows(sorted([*policies, *learned], key=lambda policy: KNOWLEDGE.index(policy.sees)), results)
    console.print(rich_table(rows, f"{task.title}: {episodes} paired episodes"))
    facts = provenance(seeds)
    write_whole(target / "benchmark.csv", csv_text(rows, facts))
    write_whole(target / "benchmark.md", markdown_text(rows, task, facts))
    console.print(f"written to {target / 'benchmark.csv'} and .md", highlight=False)
    return rows


def table_rows(policies: Sequence[Policy], results: Mapping[str, Evaluation]) -> list[Row]:
    """The table; the fixed plan of lower mean cost on these episodes scores 0, the planner 100.

    Scores are of the episodes that the planner has planned, the first ones of the others.
    """
    planner = results[REFERENCE]
    planned = len(planner.cost)
    fixed = results[better_plan(results)]
    rows = []
    for policy in policies:
        run = results[policy.name]
        score = run.first(planned).score(fixed.first(planned), planner)
        speed, executions = float(run.speeds.mean()) / 1000.0, float(run.executions.mean())
        rows.append(Row(policy.name, policy.sees, run.cost_per_good_part, run.scrap, speed, executions, score))
    return rows


def better_plan(results: Mapping[str, Evaluation]) -> str:
    """Name of the fixed plan of lower mean cost."""
    return min(FIXED_PLANS, key=lambda name: float(results[name].cost.mean()))


def kept_evaluation(
    policy: Policy, task: Task, seeds: range, folder: Path, fresh: bool, code: str | None = None
) -> Evaluation:
    """The evaluation kept in `folder` if it is of the same code, parameters and seeds, else a new one, now kept.

    Args:
        policy: the policy.
        task: the task.
        seeds: of the episodes.
        folder: where evaluations are kept.
        fresh: run also what is kept.
        code: stands for the code; the hash of all of it by default.
    """
    path = folder / f"{policy.name}.npz"
    fingerprint = hashlib.sha256(f"{code or code_hash()} {task.name} {seeds} {policy!r}".encode()).hexdigest()
    if not fresh:
        # a file that is missing, damaged or of something else is made anew
        with suppress(OSError, ValueError, KeyError, zipfile.BadZipFile), np.load(path) as kept:
            if str(kept["fingerprint"]) == fingerprint:
                return Evaluation(*(kept[each.name] for each in fields(Evaluation)))
    result = evaluate(policy, task, seeds)
    folder.mkdir(parents=True, exist_ok=True)
    partial = path.with_name(f".{policy.name}.{os.getpid()}.npz")
    np.savez(partial, fingerprint=np.array(fingerprint), **asdict(result))
    partial.replace(path)
    return result


def rich_table(rows: Sequence[Row], title: str) -> Table:
    """The table for a terminal."""
    table = Table(title=title)
    for k, heading in enumerate(HEADINGS):
        table.add_column(heading, justify="left" if k < 2 else "right")
    for row in rows:
        table.add_row(*row.cells())
    return table


def csv_text(rows: Sequence[Row], facts: dict[str, str]) -> str:
    """All numbers in full, with the provenance in every row."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    columns = ["policy", "sees", *spread_names("cost_per_good_part"), "scrap", "E", "D", *spread_names("score")]
    writer.writerow([*columns, *facts])
    for row in rows:
        writer.writerow([*flat(row), *facts.values()])
    return text.getvalue()


def spread_names(name: str) -> list[str]:
    """Columns of an interval."""
    return [name, f"{name}_low", f"{name}_high"]


def flat(row: Row) -> Iterator[object]:
    """The numbers of a row, intervals spread out."""
    for value in astuple(row):
        yield from value if isinstance(value, tuple) else (value,)


def markdown_text(rows: Sequence[Row], task: Task, facts: dict[str, str]) -> str:
    """The table for a page."""
    rules = ["---"] * 2 + ["---:"] * (len(HEADINGS) - 2)
    lines = [HEADINGS, rules, *(row.cells() for row in rows)]
    return "\n".join(
        [
            f"# {task.title}",
            "",
            "Paired evaluation episodes; 95 % bootstrap intervals. Score: 0 = the better of `constant` and `interval`,"
            f" 100 = `{REFERENCE}`.",
            "",
            *("| " + " | ".join(cells) + " |" for cells in lines),
            "",
            *(f"- {name}: {value}" for name, value in facts.items()),
            "",
        ]
    )

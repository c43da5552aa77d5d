"""Published results re-run on new seeds: do the means lie within the published intervals?"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

from agents.benchmark.page import AgentVerdict, verdict
from agents.benchmark.plan import AT, KINDS, BenchmarkCell, Request, chosen_problems
from agents.benchmark.results import PLANTS, Result, read_results, result
from agents.benchmark.scoring import Sampled, judged
from agents.benchmark.summary import shown, tasks_of
from agents.benchmark.trials import study as trials_of
from agents.csv_tables import check_tables, csv_of
from agents.provenance import provenance
from agents.study import Found, Options, Study, StudyOptions
from grind_env.data_table import table_of
from grind_env.files import csv_cell
from grind_env.policies.evaluation import SEEDS, SEEDS_EACH
from grind_env.policies.problem_lookup import Problem
from grind_env.policies.score_statistics import prediction
from grind_env.policies.tuned_parameters import ConfigError, write_whole

#: first seed of each set; no seed of the sets is in a range of `grind_env.policies.evaluation.SEEDS`
FIRSTS = (11_000_000, 12_000_000, 13_000_000)
#: machines that grind, by the prefix of the columns of a result
PLACES = {"": "the model", PLANTS: "held-out machines"}
CSV, PAGE, TITLE = "replications.csv", "replications.md", "# Replications"
COLUMNS = ("task", "policy", "seed", "on", "first", "published", "low", "high", "found", "holds")
BEGINS = {CSV: ",".join(COLUMNS), PAGE: TITLE}

HEAD = """\
`python -m agents replicate` runs {policies} rules, planners and agents of [the results](README.md) on {sets} new sets
of {episodes} episodes. No policy was tuned, trained or chosen on these seeds. The table counts the mean costs inside
the 95 % [prediction interval](../../docs/benchmark/protocol.md#verify-a-row) of their published row: {total}. All
policies of a task grind the same episodes, so one hard set moves many rows; on 24 other sets of machines at least 93 %
of the fast rules and bundled agents hold (tested nightly). Variants (`@12`) and uncached agents are left out."""
CHOSEN = """\
The best agent on measurements and the best rule or planner are those of the published results. On the new sets the
agent beats the other (the interval of the paired difference is above 0) in {beaten} of {tasks} tasks."""


class Replication(NamedTuple):
    """Published mean cost, and mean cost on other seeds, $ per episode."""

    task: str
    policy: str
    seed: int | None  #: training seed
    on: str
    first: int  #: first seed of the set
    published: float
    low: float
    high: float  #: ends of the 95 % prediction interval of the published row for the mean of as many other episodes
    found: float

    @property
    def holds(self) -> bool:
        return self.low <= self.found <= self.high


def study(asked: StudyOptions, first: Sequence[int] | None, published: Path) -> Study:
    """Return the study that runs published results on other seeds; raise the errors of `replicate`."""
    check_tables(asked.results, "replicate", BEGINS)
    known = read_results(published)
    problems = chosen_problems(asked.tasks or ",".join(tasks_of(known)), asked.job, asked.parts) if known else []
    firsts = list(dict.fromkeys(first or FIRSTS))
    return replicate(known, problems, firsts, asked.episodes, asked.configs, asked.options)


def replicate(
    published: Sequence[Result],
    problems: Sequence[Problem],
    firsts: Sequence[int],
    episodes: int,
    configs: Path | None,
    options: Options,
) -> Study:
    """Return the study that runs all policies of published results, variants left out, on other seeds.

    Agents come from the cache folder. A result without an agent is left out; an agent of other code is trained again.

    Raises:
        ConfigError: no result can be re-run, or a set shares seeds with another set or with `SEEDS`.
    """
    check_sets(firsts, episodes)
    cells = [
        BenchmarkCell(problem, each.policy, each.seed)
        for problem in problems
        for each in published
        if each.task == problem.name and AT not in each.policy
    ]
    # newly trained agents would be other agents
    gone = [cell for cell in cells if cell.trains and not (cell.policy in KINDS and cell.has_agent(options.runs))]
    if gone:
        names = dict.fromkeys(f"{cell.task} {cell.policy}" for cell in gone)
        options.console.print(f"left out, because their agents are not in the cache: {', '.join(names)}", markup=False)
    cells = [cell for cell in cells if cell not in gone]
    if not cells:
        raise ConfigError("no published results to replicate: run `python -m agents benchmark` first")
    request = Request(
        episodes=episodes, interpolation_episodes=0, plants_episodes=episodes, runs=options.runs, configs=configs
    )
    requests = [replace(request, first=first) for first in firsts]
    return trials_of("replicate", cells, *requests, files=BEGINS, publish=partial(write, published))


def by_first(found: Found) -> Mapping[int, Sequence[Result]]:
    """Return the results of every set, by its first seed."""
    firsts = dict.fromkeys(trial.request.first for trial in found)
    return {
        first: judged([result(row) for trial, row in found.items() if trial.request.first == first]) for first in firsts
    }


def check_sets(firsts: Sequence[int], episodes: int) -> None:
    """Refuse sets that share seeds with another set, or with `SEEDS`, by which policies were made and chosen."""
    taken = {f"the {name} seeds": range(first, first + SEEDS_EACH) for name, first in SEEDS.items()}
    for first in firsts:
        for name, other in taken.items():
            if first < other.stop and other.start < first + episodes:
                raise ConfigError(
                    f"--first-seed {first} has {name}, {other.start} to {other.stop - 1}, among its {episodes}:"
                    " give another"
                )
        taken[f"seeds of the set from {first}"] = range(first, first + episodes)


def compared(published: Sequence[Result], found: Mapping[int, Sequence[Result]]) -> list[Replication]:
    """Return each published mean cost with the mean cost of every set."""
    others = {first: {each.key: each for each in results} for first, results in found.items()}
    replications = []
    for each in published:
        for prefix, on in PLACES.items():
            cost = f"{prefix}cost"
            known = np.asarray(getattr(each, cost), float)
            for first, results in others.items():
                if not len(known) or each.key not in results:
                    continue
                other = np.asarray(getattr(results[each.key], cost), float)
                expected = prediction(known, len(other))
                replications.append(Replication(*each.key, on, first, *expected, float(other.mean())))
    return replications


def verdicts_of(published: Sequence[Result], found: Sequence[Result]) -> list[AgentVerdict]:
    """Return the verdicts of every task on other seeds, for the published best agent and best rule or planner."""
    given = []
    for task in tasks_of(found):
        chosen, of = (Sampled(each for each in results if each.task == task) for results in (published, found))
        given.append(verdict(task, of, chosen))
    return [each for each in given if each is not None]


def page(
    published: Sequence[Result], found: Mapping[int, Sequence[Result]], replications: Sequence[Replication]
) -> str:
    """Return the tables as Markdown."""
    results = next(iter(found.values()))
    tasks, sets = tasks_of(results), [f"from {first}" for first in found]
    shares = [
        (task, on, *(_share(replications, on, task, first) for first in found))
        for task in tasks
        for on in PLACES.values()
    ]
    total = "; ".join(f"{_share(replications, on)} on {on}" for on in PLACES.values())
    ran = {each.key for each in results}
    published = [each for each in published if each.key in ran]
    known = verdicts_of(published, published)
    others = [verdicts_of(published, results) for results in found.values()]
    beaten = ", ".join(str(sum(each.over.low > 0.0 for each in of)) for of in others)
    verdicts = [
        row
        for first, *later in zip(known, *others, strict=True)
        for row in (
            (first.task, f"{first.agent}, score", *(shown(each.score, ratio=False) for each in (first, *later))),
            (first.task, f"points over {first.rule}", *(shown(each.over, ratio=False) for each in (first, *later))),
        )
    ]
    head = HEAD.format(policies=len(results), sets=len(found), episodes=results[0].episodes, total=total)
    parts = [TITLE, head, table_of(("task", "on", *sets), shares).markdown()]
    if known:
        chosen = CHOSEN.format(beaten=beaten, tasks=len(known))
        listed = table_of(("task", "what", "published", *sets), verdicts)
        parts += ["## Learned against scripted", chosen, listed.markdown()]
    return "\n\n".join(parts) + "\n"


def _share(replications: Sequence[Replication], on: str, task: str | None = None, first: int | None = None) -> str:
    """Return how many replications hold, of one task or all, and of one set or all."""
    of = [each for each in replications if each.on == on and task in (None, each.task) and first in (None, each.first)]
    held = sum(each.holds for each in of)
    return f"{held} of {len(of)}" + (f" ({100.0 * held / len(of):.1f} %)" if of and task is None else "")


def write(published: Sequence[Result], trials: Found, folder: Path) -> str:
    """Write both files, and return the page."""
    found = by_first(trials)
    replications = compared(published, found)
    facts = {first: provenance(range(first, first + results[0].episodes)) for first, results in found.items()}
    rows = [
        [*("" if value is None else csv_cell(value) for value in each), each.holds, *facts[each.first].values()]
        for each in replications
    ]
    text = page(published, found, replications)
    write_whole(folder / CSV, csv_of([*COLUMNS, *next(iter(facts.values()))], rows))
    write_whole(folder / PAGE, text)
    return text

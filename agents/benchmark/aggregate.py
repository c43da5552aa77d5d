"""Aggregates of scores over tasks and runs, computed like rliable (Agarwal et al. 2021)."""

from collections.abc import Callable, Sequence

import numpy as np

from agents.benchmark.plan import AT
from agents.benchmark.results import Result
from agents.benchmark.scoring import Sampled, is_ratio
from agents.benchmark.summary import tasks_of
from grind_env.array_types import Array
from grind_env.policies.registry import REFERENCE
from grind_env.policies.score_statistics import Interval, ScoredRuns, interquartile_mean, mean_score, resampled_runs

#: policy that replaces another in tasks with one kind of block, where both are equal
SINGLE_KIND = {"constant_per_kind": "constant"}

MEASURES: dict[str, Callable[[Array], Array]] = {"IQM": interquartile_mean, "mean": mean_score}


def scored_tasks(results: Sequence[Result]) -> dict[str, Sampled]:
    """Return the tasks with a score: both anchors were run, and their costs are not nearly equal."""
    tasks = {name: Sampled(each for each in results if each.task == name) for name in tasks_of(results)}
    return {name: of for name, of in tasks.items() if not is_ratio(name) and of.scores() is not None}


def all_runs(results: Sequence[Result]) -> dict[str, ScoredRuns]:
    """Return the scores of every policy that was run on all scored tasks, without variants of hindsight.

    If tasks have different numbers of runs, the first runs of each task are taken, as many as every task has.
    """
    tasks = scored_tasks(results)
    found: dict[str, ScoredRuns] = {}
    for policy in dict.fromkeys(each.policy for each in results if not each.policy.startswith(f"{REFERENCE}{AT}")):
        runs = [of.runs(policy) or of.runs(SINGLE_KIND.get(policy, policy)) for of in tasks.values()]
        count = min(map(len, runs), default=0)
        if not count:
            continue
        columns, draws = [], []
        for of, numbers in zip(tasks.values(), runs, strict=True):
            scores = of.scores()
            assert scores is not None
            columns.append(scores[0][numbers[:count]])
            draws.append(scores[1][:, numbers[:count]])
        # the runs of two policies are not paired, so each policy draws its own
        drawn = resampled_runs(np.stack(draws, axis=-1), seed=1 + len(found))
        found[policy] = ScoredRuns.clipped(np.stack(columns, axis=-1), drawn)
    return found


def aggregates(runs: dict[str, ScoredRuns]) -> dict[str, dict[str, Interval]]:
    """Return every measure of every policy, the best policy first."""
    found = {policy: {name: of.interval(measure) for name, measure in MEASURES.items()} for policy, of in runs.items()}
    return dict(sorted(found.items(), key=lambda item: -item[1]["IQM"].value))

"""Scores of a policy in all core tasks, next to published scores."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from grind_env.array_types import Array
from grind_env.data_table import Table, table_of
from grind_env.envs.task_names import CORE, environment_id
from grind_env.policies.evaluation import nobody
from grind_env.policies.policy import Policy
from grind_env.policies.registry import TRAINED
from grind_env.policies.score_statistics import (
    RESAMPLES,
    Interval,
    ScoredRuns,
    interquartile_mean,
    percentile_interval,
    score_of_means,
)
from grind_env.policies.scoring import Judgement, evaluate
from grind_env.score_scale import EPISODES, Reference, reference

AGENT, ON_STATE = TRAINED[0], "mpc"  #: bundled agent, and planner on the true state; both are shown next to a policy
SAID = """\
Score 0: the best fixed plan; 100: hindsight. best tuned: the best rule or planner with tuned parameters. IQM: mean of
the middle half of the tasks; below -100 counts as -100. 95 % CI; of best tuned and mpc unpaired, of others paired."""


class BoardRow(NamedTuple):
    """Scores of a policy in all core tasks."""

    scores: Array  #: ratio to the gap between fixed plan and hindsight, %, shape (tasks,)
    draws: Array  #: score ratio of each resample of the episodes, %, shape (resamples, tasks)

    def intervals(self) -> list[Interval]:
        """Return the score in each task, with its interval."""
        return [percentile_interval(float(each), draws) for each, draws in zip(self.scores, self.draws.T, strict=True)]

    def iqm(self) -> Interval:
        """Return the interquartile mean over the tasks."""
        return ScoredRuns.clipped(self.scores[None], self.draws[:, None]).interval(interquartile_mean)


@dataclass(frozen=True, slots=True)
class CoreJudgement:
    """Scores and evaluations of a policy in all core tasks."""

    judgements: Mapping[str, Judgement]  #: judgement of the policy, by task
    rows: Mapping[str, BoardRow]  #: row of the policy and of each policy shown next to it, by name

    def table(self) -> Table:
        """Return the scores: a row for each task, and for the mean over the tasks."""
        shown = [[f"{each:.1f}" for each in (*row.intervals(), row.iqm())] for row in self.rows.values()]
        return table_of(("task", *self.rows), zip((*self.judgements, "IQM"), *shown, strict=True), left=1)

    def numbers(self) -> dict[str, Any]:
        """Return the scores by name, for JSON."""
        return {
            name: {task: score._asdict() for task, score in zip(self.judgements, row.intervals(), strict=True)}
            | {"IQM": row.iqm()._asdict()}
            for name, row in self.rows.items()
        }

    def __str__(self) -> str:
        return f"{self.table().markdown()}\n\n{SAID}"


def evaluate_core(
    policy: Policy | str | Mapping[str, Policy],
    *,
    episodes: int = EPISODES,
    advance: Callable[[int], object] = nobody,
) -> CoreJudgement:
    """Return the scores of a policy in all core tasks, on the evaluation episodes of the published scores.

    Args:
        policy: as for `evaluate`, or a policy for each task by the name of the task.
        episodes: number of episodes of each task; the published scores have 256.
        advance: as for `evaluate`.

    Raises:
        GrindError: `evaluate` fails, or a core task has no published scores.
    """
    known = [reference(environment_id(task)) for task in CORE]

    def judged(each: Policy | str | Mapping[str, Policy]) -> dict[str, Judgement]:
        policies = each if isinstance(each, Mapping) else dict.fromkeys(CORE, each)
        return {task: evaluate(policies[task], task, episodes=episodes, advance=advance) for task in CORE}

    own = judged(policy)
    name = own[CORE[0]].policy
    rows = {name: _own(own), "best tuned": _published(known, [each.best_scripted for each in known])}
    rows[f"{AGENT} (bundled)"] = rows[name] if name == AGENT else _own(judged(AGENT))
    rows[ON_STATE] = _published(known, [ON_STATE] * len(known))
    return CoreJudgement(own, rows)


def _own(judgements: Mapping[str, Judgement]) -> BoardRow:
    draws = [each.draws for each in judgements.values() if each.draws is not None]
    scores = [each.score.value for each in judgements.values() if each.score is not None]
    return BoardRow(np.array(scores), np.stack(draws, axis=-1))


def _published(known: list[Reference], names: list[str]) -> BoardRow:
    """Return the row of published mean returns; normal random errors replace resamples."""
    mean, error = np.array([each.returns[name] for each, name in zip(known, names, strict=True)]).T
    zero, hundred = np.array([(each.zero, each.hundred) for each in known]).T
    returns = mean + error * np.random.default_rng(0).standard_normal((RESAMPLES, len(known)))
    return BoardRow(score_of_means(-mean, -zero, -hundred), score_of_means(-returns, -zero, -hundred))

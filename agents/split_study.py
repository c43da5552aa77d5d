"""Scores of policies on contexts inside and outside of a task."""

from collections import Counter
from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import NamedTuple

from agents.evaluations import Evaluations, chunks, joined
from agents.reference.table import best_plan
from agents.study import Found, Study, StudyOptions
from grind_env.data_table import NONE, table_of
from grind_env.envs.distribution_splits import EVERY
from grind_env.errors import GrindError
from grind_env.policies.evaluation import Evaluation
from grind_env.policies.policy_lookup import named_policy
from grind_env.policies.problem_lookup import Problem
from grind_env.policies.registry import FIXED_PLANS, REFERENCE, policy_names
from grind_env.policies.score_statistics import Interval

SHOWN = (EVERY, "interpolation", "extrapolation")
MEASURED = ("empirical_rule", "look_ahead", "belief_planner", "plain_gru", "robust")
WHO = (*MEASURED, "mpc")
COLUMNS = ("task", "split", "who", "score", "score_low", "score_high", "cost", "cost_low", "cost_high", "scrap")


class SplitScore(NamedTuple):
    """Score of a policy in a split of a task, each number with its 95 % interval over episodes."""

    task: str
    split: str
    who: str
    score: Interval  #: score: 0 is the best fixed plan on all contexts, 100 is hindsight
    cost: Interval  #: cost per good part, $
    scrap: float  #: share of the parts that are scrap


def study(asked: StudyOptions) -> Study:
    """Return the study."""
    return Evaluations(
        name="splits",
        title="Scores on held-out contexts",
        trials=chunks(asked, lambda problem: [*plans_of(problem), *judged(problem), REFERENCE], SHOWN),
        columns=COLUMNS,
        rows=lambda found: [(*each[:3], *each.score, *each.cost, each.scrap) for each in all_lines(found)],
        page=lambda found: page(all_lines(found), asked.episodes),
        episodes=asked.episodes,
    )


def all_lines(found: Found) -> list[SplitScore]:
    """Return the scores of all policies in the splits of all tasks."""
    runs = joined(found)
    return [line for problem in dict.fromkeys(key[0] for key in runs) for line in lines_of(problem, runs)]


def plans_of(problem: Problem) -> list[str]:
    """Return the names of the fixed plans of a task."""
    return [name for name in policy_names(problem.simulation()) if name in FIXED_PLANS]


def judged(problem: Problem) -> list[str]:
    """Return the policies of `WHO` that exist for a task: bundled agents and tuned rules."""
    found = []
    for who in WHO:
        with suppress(GrindError):
            named_policy(who, problem.simulation())
            found.append(who)
    return found


def lines_of(problem: Problem, found: Mapping[tuple[Problem, str, str], Evaluation]) -> list[SplitScore]:
    """Return the scores of all policies in the splits of a task."""
    by_split = {
        split: {who: run for (of, drawn, who), run in found.items() if (of, drawn) == (problem, split)}
        for split in SHOWN
    }
    plan = best_plan(by_split[EVERY])
    lines = []
    for split, runs in by_split.items():
        for who in (plan, *(who for who in WHO if who in runs), REFERENCE):
            run = runs[who]
            score = run.score(runs[plan], runs[REFERENCE])
            lines.append(SplitScore(problem.name, split, who, score, run.cost_per_good_part, run.scrap))
    return lines


def page(lines: Sequence[SplitScore], episodes: int) -> str:
    """Return the tables as Markdown."""
    scores, costs = [], []
    for task, split in dict.fromkeys((each.task, each.split) for each in lines):
        of = {each.who: each for each in lines if (each.task, each.split) == (task, split)}
        plan = next(iter(of))
        scores.append((task, split, *(f"{of[who].score:.1f}" if who in of else NONE for who in WHO)))
        costs.append((task, split, plan, *(_cost(of.get(who)) for who in (plan, *WHO, REFERENCE))))
    return (
        f"`python -m agents splits`: {episodes} evaluation episodes, with the same seeds in every"
        " [split](../../docs/howto/evaluate.md#seeds). Rules are tuned on `all`, agents are trained on `inner`."
        " `extrapolation` has more wear and pressure than the task, another wheel and material, 1.5 times the stock and"
        " three times the noise. Score 0 is the fixed plan that is best on `all`, 100 is hindsight; 95 % intervals over"
        " episodes. `mpc` sees the true state.\n\nBest policy on measurements:\n\n"
        + "\n".join(f"- `{split}`: {leading(lines, split)}" for split in SHOWN)
        + "\n\n"
        + table_of(("task", "split", *WHO), scores).markdown()
        + "\n\n$ per good part, and scrap:\n\n"
        + table_of(("task", "split", "best fixed plan", "its cost", *WHO, REFERENCE), costs).markdown()
    )


def leading(lines: Sequence[SplitScore], split: str) -> str:
    """Return a sentence: in how many tasks each policy on measurements scores best, and in how many significantly."""
    first, clear = Counter[str](), Counter[str]()
    for task in dict.fromkeys(each.task for each in lines):
        of = [each for each in lines if (each.task, each.split) == (task, split) and each.who in MEASURED]
        if not of:
            continue
        best = max(of, key=lambda each: each.score[0])
        first[best.who] += 1
        clear[best.who] += all(best.score[1] > each.score[2] for each in of if each is not best)
    said = [
        f"`{who}` on {count} of {first.total()} tasks" + (f" ({clear[who]} significantly)" if clear[who] else "")
        for who, count in first.most_common()
    ]
    return ", ".join(said) or "nobody was run"


def _cost(line: SplitScore | None) -> str:
    return NONE if line is None else f"{line.cost[0]:.2f}, {100.0 * line.scrap:.1f} %"

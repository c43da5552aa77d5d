"""Page of all results, made from the checked-in results."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from agents.benchmark.aggregate import aggregates, all_runs, scored_tasks
from agents.benchmark.figures import figure_names
from agents.benchmark.grid import MORE_SEARCH
from agents.benchmark.plan import ABOUT, AT
from agents.benchmark.results import Result
from agents.benchmark.scoring import Sampled, is_ratio
from agents.benchmark.summary import KNOWLEDGE, UNTRAINED, best, brief, budget, columns_of, shown, summaries, tasks_of
from grind_env.data_table import NONE, Column, table_of
from grind_env.policies.planners import hindsight
from grind_env.policies.registry import REFERENCE
from grind_env.policies.score_statistics import CLIP, Interval, ScoredRuns

MEASUREMENTS, STATE, _ = KNOWLEDGE
ON_STATE = "mpc"  #: the planner on the true state
PICTURES = {
    "iqm": "Interquartile mean and mean of the score over tasks",
    "curves": "Score on validation seeds over the steps of the training",
}
HEAD = """\
# Results of the benchmark

Score 0: the best fixed plan (E, and D or a dress interval, without sensors). Score 100: hindsight, a planner that knows
all future lots and stocks. Intervals: 95 %, over episodes and trainings. All policies of a task grind the same
evaluation episodes ([protocol](../../docs/benchmark/protocol.md)). `python -m agents benchmark --full` makes this page.

**Enter**: `grind evaluate --core --policy my_rule:MyRule` prints your row beside the published ones
([in ten minutes](../../docs/benchmark/submit.md))."""
ROOM = """\
*Best known*: the best score of a policy that sees measurements only, trained for any number of steps. The policy was
chosen on these episodes, so its score is a little too high. *Planner on state*: `mpc`, which sees the true wheel and
lot. *Room*: score of this planner minus best known, on the same episodes. Better memory or planning can close a part of
the room; how large this part can be with measurements only is unknown."""
COLUMNS = """\
*Over best untrained*: points over the best rule or planner with the same inputs, paired. *Budget*: 1M, at most a
million blocks were ground for training or tuning; else open. `@3M`, `@10M`: trained for as many steps. *Runs*:
trainings. *On plants*: $ per good part on machines of `held-out`, another one in each episode. *Interpolation*: score
on contexts that training left out (`ppo` and the tuned rules know them). *Model*: whether the policy computes with the
equations of the simulator (none; nominal: with catalogue constants; exact: with the true ones). *Training*, *decision*:
CPU time. Agents `plain_*` and `robust` (trained on public machines) are PPO of `grind_env/training/gru_ppo.py`; `ppo`
is the [recipe](recipe.md)."""


def page(results: Sequence[Result]) -> str:
    """Return the page of all results."""
    runs = all_runs(results)
    samples = {task: Sampled(each for each in results if each.task == task) for task in tasks_of(results)}
    parts = [HEAD, *rooms(samples), *verdicts(samples)]
    if runs:
        parts += ["## Over tasks", over_tasks(results, runs)]
    parts += [f"![{PICTURES[name]}](figures/{name}.png)" for name in figure_names(results, scored=bool(runs))]
    parts += ["## Task by task", COLUMNS]
    for task in samples:
        parts += [f"### {task}", table_of(columns_of(is_ratio(task)), summaries(results, task)).markdown()]
    return "\n\n".join([*parts, made_by(results)]) + "\n"


class TaskRoom(NamedTuple):
    """Room between the best known policy on measurements and the planner on the true state."""

    task: str
    best_known: str  #: the best policy that sees measurements
    score: Interval
    budget: str
    on_state: Interval | None  #: score of the planner on the true state
    room: Interval | None  #: points of the planner on the true state over the best known policy
    searched: Interval | None  #: points over 100 of hindsight with more search


def room(task: str, of: Sampled) -> TaskRoom | None:
    """Return the room that a task leaves; None without a score."""
    known, fixed = best(of, MEASUREMENTS), of.fixed()
    if known is None or fixed is None or is_ratio(task):
        return None
    plan, blocks = of.results[fixed].policy, of.results[of.runs(known)[0]].blocks
    score = of.gain(known, plan)
    assert score is not None, "a best policy has a score"
    searched = of.gain(MORE_SEARCH, REFERENCE)
    return TaskRoom(task, known, score, budget(blocks), of.gain(ON_STATE, plan), of.gain(ON_STATE, known), searched)


def rooms(samples: Mapping[str, Sampled]) -> list[str]:
    """Return the section on the decisions, the hidden state and the room of each task."""
    found = [each for each in (room(*item) for item in samples.items()) if each is not None]
    if not found:
        return []
    columns = (
        Column("task", "task"),
        Column("parts", lambda each: ABOUT.get(each.task, (NONE, NONE))[0]),
        Column("hidden", lambda each: ABOUT.get(each.task, (NONE, NONE))[1]),
        Column("best known from measurements", lambda each: f"{brief(each.score, False)} ({each.best_known})"),
        Column("planner on state", lambda each: brief(each.on_state, False), right=True),
        Column("room", lambda each: shown(each.room, False), right=True),
    )
    gains = [each.searched.value for each in found if each.searched is not None]
    more = f"with {MORE_SEARCH.partition(AT)[2]} (`{MORE_SEARCH}`) it scores at most"
    improves = f"`hindsight` is a search of {hindsight.SWEEPS} rounds, not the optimum. More rounds gain little"
    said = [f"{improves}: {more} {100.0 + max(gains):.1f} in any task."] if gains else []
    return ["## How much room is left", table_of(columns, found).markdown(), " ".join([ROOM, *said])]


class AgentVerdict(NamedTuple):
    """Best agent on measurements of a task with the budget 1M, and best rule or planner."""

    task: str
    agent: str
    score: Interval
    rule: str
    over: Interval  #: points over the best rule or planner


def verdict(task: str, of: Sampled, chosen: Sampled | None = None) -> AgentVerdict | None:
    """Return the verdict on a task for the best agent and rule of `chosen`; None without them or a score."""
    agent = best(chosen or of, MEASUREMENTS, ("learned",), limited=True)
    rule, fixed = best(chosen or of, MEASUREMENTS, UNTRAINED), of.fixed()
    if agent is None or rule is None or fixed is None or is_ratio(task):
        return None
    score, over = of.gain(agent, of.results[fixed].policy), of.gain(agent, rule)
    return None if score is None or over is None else AgentVerdict(task, agent, score, rule, over)


def verdicts(samples: Mapping[str, Sampled]) -> list[str]:
    """Return the section that compares the best agent of each task with the best rule or planner."""
    found = [each for each in (verdict(*item) for item in samples.items()) if each is not None]
    if not found:
        return []
    better, worse = (sum(each.over.low > 0.0 for each in found), sum(each.over.high < 0.0 for each in found))
    said = (
        f"The best agent with the budget 1M is better than the best rule or planner of any budget in {better} of"
        f" {len(found)} tasks and worse in {worse}: the 95 % interval of the difference excludes 0. Both are chosen on"
        " the episodes that judge them; [Replications](replications.md) compare them on new seeds."
    )
    columns = (
        Column("task", "task"),
        Column("best agent, 1M", lambda each: f"{each.agent}: {brief(each.score, False)}"),
        Column("best rule or planner", "rule"),
        Column("points over it", lambda each: shown(each.over, False), right=True),
    )
    return ["## Learned against scripted", said, table_of(columns, found).markdown()]


def over_tasks(results: Sequence[Result], runs: Mapping[str, ScoredRuns]) -> str:
    """Return aggregates of the score over tasks and runs."""
    found = aggregates(dict(runs))
    measures = list(next(iter(found.values())))
    rows = [[policy, *(shown(of[measure], ratio=False) for measure in measures)] for policy, of in found.items()]
    return (
        f"Over {', '.join(scored_tasks(results))}; 0 is the best fixed plan of each task; a score below {CLIP:g} counts"
        f" as {CLIP:g}. IQM: mean of the middle half of all runs. Bootstrap over episodes and runs, as in rliable.\n\n"
        + table_of(("policy", *measures), rows, left=1).markdown()
    )


def made_by(results: Sequence[Result]) -> str:
    """Return a sentence with the task version, seeds, splits and commits of the results."""
    values: dict[str, list[object]] = {
        "task version": [each.task_version for each in results],
        "evaluation seeds": [each.seeds for each in results],
        "interpolation seeds": [each.interpolation_seeds for each in results],
        "plants seeds": [each.plants_seeds for each in results],
        "training split": [each.trained_on for each in results],
        "commit": [each.commit for each in results],
    }
    found = {name: ", ".join(str(value) for value in dict.fromkeys(of) if value) for name, of in values.items()}
    return f"Made with: {'; '.join(f'{name} {text}' for name, text in found.items() if text)}."

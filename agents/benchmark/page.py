"""The page of all results, from the checked-in ones."""

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import NamedTuple

from agents.benchmark.aggregate import aggregates, all_runs, scored_tasks
from agents.benchmark.figures import OVER, figure_names
from agents.benchmark.judge import Sampled, is_ratio
from agents.benchmark.plan import AT, LIMIT, LIMITED, ON_BELIEF, SWEEPS
from agents.benchmark.results import Result
from agents.benchmark.summary import KNOWLEDGE, PolicySummary, best, brief, columns_of, shown, summaries, tasks_of
from grind_env.policies.learned.saved import SUFFIX, load_policy
from grind_env.policies.naming import SHIPPED
from grind_env.policies.planners import hindsight
from grind_env.policies.registry import REFERENCE
from grind_env.policies.statistics import CLIP, Interval, ScoredRuns
from grind_env.table import NONE, table_of

Lines = Mapping[str, Sequence[PolicySummary]]
"""The lines of every task."""

FEW = {
    ("scripted", KNOWLEDGE[0]): 1,
    ("learned", KNOWLEDGE[0]): 3,
    ("planner", KNOWLEDGE[0]): 1,
    ("learned", KNOWLEDGE[1]): 1,
    ("planner", KNOWLEDGE[1]): 1,
}
"""Policies in the headline at most, by kind and by what they see."""
NEAR = 3.0
"""Points that the best learned agent may stay behind the planner on the belief."""
WIDE = 0.1
"""Half the interval of what 100 points are, over that, from which on scores of other episodes may differ by as much."""
NOTHING = 0.5
"""Points that more search of hindsight may gain."""
FACULTIES = {
    "memory: stack": ("plain_stack", "plain_none"),
    "memory: GRU": ("plain_gru", "plain_none"),
    "belief": ("plain_belief", "plain_gru"),
    "state": ("plain_state", "plain_belief"),
    "future": (REFERENCE, "plain_state"),
}
"""What is worth what one policy scores more than another."""
PICTURES = {
    "cost": "Cost per good part on each task",
    "iqm": "Interquartile mean, median, mean and optimality gap of the score",
    "profiles": "Share of the runs above each score",
    "improvement": f"Probability that a run scores above {OVER}",
}
HEAD = """\
# Results of the benchmark

Score: 0 is the best fixed plan, a program without sensors; 100 is hindsight, a planner that knows every later lot and
stock; with its 95 % interval over episodes and training seeds. All policies of a task grind the same evaluation
episodes; those of fewer are compared on the ones that they share. What may be tuned on what, and what the splits are:
[protocol](../../docs/benchmark/protocol.md). [Diagnostics](../../docs/benchmark/index.md#diagnostics) have no place
here. Files `<task>.csv` are the reference scores of the environments (`python -m agents scores`).
`python -m agents benchmark --full` makes all of this page anew; the commands at its end made what is here."""
COLUMNS = f"""\
*Over best rule*: points more than the best scripted policy that sees the same, paired. *Model*: what of the
simulator's equations a policy holds when it decides; none, those with nominal constants, or the exact ones.
*On plants*: $ per good part on machines that are not the model and are held out, one in every episode, of what sees
measurements; policies hold the model. *Interpolation*: score on contexts that training left out. *Blocks*: ground to
make it, tuning and teacher included, validation left out; `{AT}{LIMITED}` is a rule that was tuned on {LIMIT:,} at
most, its other row has no limit. *Simulated*: blocks that it tries for a decision, or that were tried to make it.
*Making*: CPU time (of `ppo` and `bc`, whose kinds of training are gone, wall time of one thread; of a rule that of its
blocks). *Decision*: CPU time. {NONE}: not known, or none. Agents `plain_*` are PPO of
`grind_env/training/gru_ppo.py`, by what they remember or are shown; `robust` is the GRU of it trained on public
plants."""


def page(results: Sequence[Result]) -> str:
    """The page of all results."""
    runs = all_runs(results)
    samples = {task: Sampled(each for each in results if each.task == task) for task in tasks_of(results)}
    lines = {task: summaries(results, task) for task in samples}
    parts = [HEAD, *(["## In short", headline(results, lines, runs)] if runs else [])]
    parts += [*verdicts(samples), *worths(samples), *measure_of(samples), "## Task by task", COLUMNS]
    for task, of in lines.items():
        parts += [f"### {task}", table_of(columns_of(is_ratio(task)), of).markdown()]
    if runs:
        parts += ["## Over tasks", over_tasks(results, runs)]
    parts += [f"![{PICTURES[name]}](figures/{name}.png)" for name in figure_names(runs)]
    return "\n\n".join([*parts, "\n".join(made_by(results))]) + "\n"


def headline(results: Sequence[Result], lines: Lines, runs: Mapping[str, ScoredRuns]) -> str:
    """Scores of the best few policies on every task that has one, from poor to good."""
    kinds = {each.policy: (each.kind, each.sees) for each in results}
    ordered = sorted(runs, key=lambda name: float(runs[name].scores.mean()))
    few = {name for kind, most in FEW.items() for name in [name for name in ordered if kinds[name] == kind][-most:]}
    shown_of = {task: {line.policy: shown(line.score, False) for line in lines[task]} for task in scored_tasks(results)}
    names = [name for name in ordered if name in few and name != REFERENCE]
    rows = [[task, *(scores[name] for name in names)] for task, scores in shown_of.items()]
    return table_of(("task", *(f"{name} ({kinds[name][1]})" for name in names)), rows, left=1).markdown()


class AgentVerdict(NamedTuple):
    """The best agent on measurements of a task, and what it is held against."""

    task: str
    agent: str
    score: Interval
    rule: str
    over: Interval
    """Points over the best rule that sees the same."""
    behind: Interval | None
    """Points over the planner on the belief."""
    scale: Interval
    """What hindsight saves over the best fixed plan, $ an episode."""

    @property
    def cells(self) -> list[str]:
        near = "" if self.behind is None else f": {'within' if self.behind.value >= -NEAR else 'beyond'} {NEAR:g}"
        return [
            self.task,
            f"{self.agent}: {brief(self.score, False)}",
            self.rule,
            f"{shown(self.over, False)}: {'beats it' if self.over.low > 0.0 else 'does not hold'}",
            f"{shown(self.behind, False)}{near}",
            f"{self.scale.value:.1f} ± {100.0 * self.scale.half_width / self.scale.value:.0f} %",
        ]


def verdict(task: str, of: Sampled, chosen: Sampled | None = None) -> AgentVerdict | None:
    """Return the verdict on a task, by agent and rule that are best in `chosen`; None without these or a score."""
    agent, rule = (best(chosen or of, kind, KNOWLEDGE[0]) for kind in ("learned", "scripted"))
    fixed, scale = of.fixed(), of.scale()
    if agent is None or rule is None or fixed is None or scale is None or is_ratio(task):
        return None
    score, over = of.gain(agent, of.results[fixed].policy), of.gain(agent, rule)
    assert score is not None and over is not None
    return AgentVerdict(task, agent, score, rule, over, of.gain(agent, ON_BELIEF), scale)


def verdicts(samples: Mapping[str, Sampled]) -> list[str]:
    """Whether the best learned agent on measurements beats the best rule, and how far it is from the planner."""
    found = [each for each in (verdict(*item) for item in samples.items()) if each is not None]
    if not found:
        return []
    beaten = sum(each.over.low > 0.0 for each in found)
    behind = [each.behind for each in found if each.behind is not None]
    near = sum(each.value >= -NEAR for each in behind)
    wide = [each.task for each in found if each.scale.half_width > WIDE * each.scale.value]
    said = (
        f"From the same measurements the best learned agent beats the best rule in {beaten} of {len(found)} tasks, the"
        " interval of the paired difference apart from 0"
        + (f", and is within {NEAR:g} points of `{ON_BELIEF}` in {near} of {len(behind)}" if behind else "")
        + ". The best of several is chosen on the episodes that judge it. *100 points*: what hindsight saves an episode"
        " over the best fixed plan"
        + (f", which is known to no better than {100.0 * WIDE:g} % in {', '.join(wide)}" if wide else "")
        + "; differences on the same episodes are known better."
        + shipped(samples)
    )
    headings = ("task", "best learned, score", "best rule", "points over it", f"over {ON_BELIEF}", "100 points, $")
    return ["## Learned against scripted", said, table_of(headings, [each.cells for each in found], left=1).markdown()]


def shipped(samples: Mapping[str, Sampled]) -> str:
    """In how many tasks no other kind of agent on measurements scores more than the shipped one beyond chance."""
    kinds, held = set[str](), []
    for task, of in samples.items():
        if (kind := shipped_kind(task)) is None or is_ratio(task):
            continue
        others = {row.policy for row in of.results if (row.kind, row.sees) == ("learned", KNOWLEDGE[0])} - {kind}
        gains = [gain for gain in (of.gain(other, kind) for other in sorted(others)) if gain is not None]
        if gains:
            kinds.add(kind)
            held.append(all(gain.low <= 0.0 for gain in gains))
    if not held:
        return ""
    return (
        f" The first training of {' or '.join(f'`{kind}`' for kind in sorted(kinds))} comes with the package for each"
        f" task: in {sum(held)} of {len(held)} no other kind of agent from measurements scores more beyond chance,"
        " paired."
    )


def shipped_kind(task: str) -> str | None:
    """The kind of agent that comes with the package for a task; None if there is none."""
    path = SHIPPED / f"{task}{SUFFIX}"
    return load_policy(path).name if path.is_file() else None


def worths(samples: Mapping[str, Sampled]) -> list[str]:
    """What memory, belief, state and future are worth, where such agents were run."""
    rows = []
    for task, of in samples.items():
        gains = [of.gain(*pair) for pair in FACULTIES.values()]
        if any(gains) and not is_ratio(task):
            rows.append([task, *(shown(gain, False) for gain in gains)])
    if not rows:
        return []
    what = "; ".join(f"*{name}*: `{one}` less `{other}`" for name, (one, other) in FACULTIES.items())
    return [
        "## What is worth what",
        f"Points of score, paired. {what}.",
        table_of(("task", *FACULTIES), rows, left=1).markdown(),
    ]


def measure_of(samples: Mapping[str, Sampled]) -> list[str]:
    """What hindsight would gain by another search, where it was tried."""
    rows, held = [], 0
    for task, of in samples.items():
        gains = [of.gain(f"{REFERENCE}{AT}{sweeps}", REFERENCE) for sweeps in SWEEPS]
        if is_ratio(task) or None in gains:
            continue
        held += max(gain.value for gain in gains if gain is not None) < NOTHING
        rows.append([task, *(f"{gain:±.2f}" for gain in gains if gain is not None)])
    if not rows:
        return []
    said = (
        f"Points that hindsight would score beyond 100 if it swept over its plans another number of times than the"
        f" {hindsight.SWEEPS} of today, paired. More search gains less than {NOTHING:g} points in {held} of {len(rows)}"
        " tasks."
    )
    listed = table_of(("task", *(f"sweeps: {each}" for each in SWEEPS)), rows, left=1)
    return ["## Hindsight as the measure", said, listed.markdown()]


def over_tasks(results: Sequence[Result], runs: Mapping[str, ScoredRuns]) -> str:
    """Aggregates of the score over tasks and runs."""
    found = aggregates(dict(runs))
    measures = list(next(iter(found.values())))
    rows = [[policy, *(shown(of[measure], ratio=False) for measure in measures)] for policy, of in found.items()]
    return (
        f"Over {', '.join(scored_tasks(results))}, scores clipped at {CLIP:g} (IQM: mean of the middle half of all"
        " runs; optimality gap: how far scores fall short of 100; 95 % intervals of a bootstrap over episodes and,"
        " stratified by task, over runs, as in rliable):\n\n" + table_of(("policy", *measures), rows, left=1).markdown()
    )


def made_by(results: Sequence[Result]) -> list[str]:
    """What the results were made with: commands, seeds and commits."""
    tasks: dict[str, list[str]] = {}
    for task in tasks_of(results):
        for given in options([each for each in results if each.task == task]):
            tasks.setdefault(given, []).append(task)
    values: dict[str, list[str | None]] = {
        "evaluation seeds": [each.seeds for each in results],
        "interpolation judged on seeds": [each.interpolation_seeds for each in results],
        "plants on seeds": [each.plants_seeds for each in results],
        "agents trained on split": [each.trained_on for each in results],
        "commit": [each.commit for each in results],
    }
    found = {name: ", ".join(dict.fromkeys(value for value in of if value)) for name, of in values.items()}
    return [
        f"Made by ({'; '.join(f'{name} {text}' for name, text in found.items() if text)}):",
        "",
        "```sh",
        *(f"python -m agents benchmark --tasks {','.join(of)} {given}" for given, of in tasks.items()),
        "```",
    ]


def options(results: Sequence[Result]) -> list[str]:
    """Options of the commands that make the results of a task: one for what has as many episodes and trainings."""
    grid, most = any(AT in each.policy for each in results), max(results, key=lambda each: each.episodes)

    def lengths(result: Result) -> str:
        # of the grid it is the command that knows them
        if grid and result.episodes == most.episodes:
            return ""
        return (
            f" --episodes {result.episodes} --interpolation-episodes {result.interpolation_episodes}"
            f" --plants-episodes {result.plants_episodes}"
        )

    trained = Counter((each.policy, lengths(each)) for each in results if each.seed is not None)
    made: dict[tuple[int, str], list[str]] = {}
    for (kind, given), seeds in trained.items():
        made.setdefault((seeds, given), []).append(kind)
    commands = []
    for (seeds, given), kinds in sorted((made or {(0, lengths(most)): []}).items(), key=lambda each: -each[0][0]):
        of_kinds = f"--kinds {','.join(kinds) or repr('')} --seeds {seeds}{given}"
        commands.append(f"{'' if given else '--full '}{of_kinds} --results agents/results")
    return commands

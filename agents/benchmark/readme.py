"""The results section of the README, and the page of all results, from the checked-in ones."""

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path

from agents.benchmark.aggregate import Runs, aggregates, all_runs, scored_tasks
from agents.benchmark.figures import OVER, figure_names
from agents.benchmark.judge import CLIP, is_ratio
from agents.benchmark.plan import FLAGSHIP
from agents.benchmark.results import Result
from agents.benchmark.summary import HEADINGS, KNOWLEDGE, NONE, Summary, brief, shown, summaries, tasks_of
from agents.provenance import ROOT
from grind_env.files import read_text
from grind_env.policies.tuned import ConfigError, write_whole

README = ROOT / "README.md"
BEGIN, END = "<!-- results: written by `python -m agents benchmark --report` -->", "<!-- end of results -->"
PAGE = "agents/results/README.md"
SCORE = (
    "Score on each task (a number with x: cost over that of the best fixed plan, where the planner costs nearly the"
    " same, so that a score would be noise):"
)
COST = "Cost, $ per good part:"
PICTURES = {
    "cost": "Cost per good part on each task",
    "iqm": "Interquartile mean, median, mean and optimality gap of the score",
    "profiles": "Share of the runs above each score",
    "improvement": f"Probability that a run scores above {OVER}",
}

WITHOUT_SENSORS = ("handbook", "interval", "constant")
PLANNERS = ("mpc", "hindsight")

Cell = Callable[[str, Summary], str]
"""What a table says of a policy on a task."""


def section(results: Sequence[Result], task: str = FLAGSHIP) -> str:
    """The text between the markers of the README: what a task costs with the policies that say most of it."""
    headings = ("policy", "sees", "$ per good part", "dresses a part", "score (95 %)")
    rows = (
        (
            line.policy,
            line.sees,
            f"{line.cost.value:.2f} ± {line.cost.half_width:.2f}",
            f"{line.dresses:.2f}",
            shown(line.ratio if is_ratio(task) else line.score, is_ratio(task)),
        )
        for line in telling(summaries(results, task))
    )
    return "\n".join(table(headings, rows, left=2))


def telling(lines: Sequence[Summary]) -> list[Summary]:
    """Of the policies of a task those without sensors, the best rule on measurements, all agents, and the planners."""
    learned = [line for line in lines if line.train_seconds is not None]
    plans = [line for line in lines if line.policy in WITHOUT_SENSORS]
    rules = [line for line in lines if line.sees == KNOWLEDGE[0] and line not in [*plans, *learned]]
    best = min(rules, key=lambda line: line.cost.value, default=None)
    kept = [*plans, best, *learned]
    return [line for line in lines if line in kept or line.policy in PLANNERS]


def page(results: Sequence[Result]) -> str:
    """The page of all results."""
    tasks, runs = tasks_of(results), all_runs(results)
    lines = [
        "# Results of the benchmark",
        "",
        "Written by `python -m agents benchmark --report`. The files `<task>.csv` beside it are the reference scores of"
        " the environments, made by `python -m agents scores`.",
        "",
    ]
    for task in tasks:
        lines += [*on_task(results, task), ""]
    lines += [*by_task(results, tasks, SCORE, score), "", *by_task(results, tasks, COST, cost), ""]
    if runs:
        lines += [*over_tasks(results, runs), ""]
    return "\n".join([*lines, *pictures(figure_names(runs), "figures"), *made_by(results), ""])


def pictures(names: Iterable[str], folder: str) -> list[str]:
    """Lines that show figures of a folder."""
    return [line for name in names for line in (f"![{PICTURES[name]}]({folder}/{name}.png)", "")]


def on_task(results: Sequence[Result], task: str) -> list[str]:
    """Every policy on a task."""
    found = [line.cells(is_ratio(task)) for line in summaries(results, task)]
    return [f"`{task}`:", "", *table(HEADINGS, found, left=2)]


def by_task(results: Sequence[Result], tasks: Sequence[str], title: str, cell: Cell) -> list[str]:
    """A number of every policy on every task."""
    lines = {task: {line.policy: line for line in summaries(results, task)} for task in tasks}
    policies = dict.fromkeys(name for task in tasks for name in lines[task])
    ordered = sorted(policies, key=lambda name: standing(name, lines))
    rows = (
        [name, *(cell(task, lines[task][name]) if name in lines[task] else NONE for task in tasks)] for name in ordered
    )
    return [title, "", *table(("policy", *tasks), rows)]


def score(task: str, line: Summary) -> str:
    """The score of a policy on a task, or its cost over that of the best fixed plan."""
    return brief(line.ratio, True) if is_ratio(task) else brief(line.score, False)


def cost(task: str, line: Summary) -> str:
    """$ per good part."""
    return f"{line.cost.value:.3f}"


def over_tasks(results: Sequence[Result], runs: dict[str, Runs]) -> list[str]:
    """Aggregates of the score over tasks and runs."""
    found = aggregates(runs)
    measures = list(next(iter(found.values())))
    rows = ([policy, *(shown(of[measure], ratio=False) for measure in measures)] for policy, of in found.items())
    return [
        f"Over {', '.join(scored_tasks(results))}, scores clipped at {CLIP:g} (IQM: mean of the middle half of all"
        " runs; optimality gap: how far scores fall short of 100; 95 % intervals of a bootstrap over episodes and,"
        " stratified by task, over runs, as in rliable):",
        "",
        *table(("policy", *measures), rows),
    ]


def made_by(results: Sequence[Result]) -> list[str]:
    """What the results were made with: commands, seeds and commits."""
    tasks: dict[str, list[str]] = {}
    for task in tasks_of(results):
        for given in options([each for each in results if each.task == task]):
            tasks.setdefault(given, []).append(task)
    facts: dict[str, list[str | None]] = {
        "evaluation seeds": [each.seeds for each in results],
        "interpolation judged on seeds": [each.interpolation_seeds for each in results],
        "agents trained on split": [each.trained_on for each in results],
        "commit": [each.commit for each in results],
    }
    found = {name: ", ".join(dict.fromkeys(value for value in of if value)) for name, of in facts.items()}
    return [
        f"Made by ({'; '.join(f'{name} {text}' for name, text in found.items() if text)}):",
        "",
        "```sh",
        *(f"python -m agents benchmark --tasks {','.join(of)} {given}" for given, of in tasks.items()),
        "```",
    ]


def options(results: Sequence[Result]) -> list[str]:
    """Options of the commands that make the results of a task: one for the kinds of each number of training seeds."""
    trained = Counter(each.policy for each in results if each.seed is not None)
    first = results[0]
    return [
        f"--kinds {','.join(kind for kind in trained if trained[kind] == seeds) or repr('')} --seeds {seeds}"
        f" --episodes {first.episodes} --interpolation-episodes {first.interpolation_episodes}"
        " --results agents/results"
        for seeds in sorted(set(trained.values()) or {0}, reverse=True)
    ]


def standing(policy: str, lines: Mapping[str, Mapping[str, Summary]]) -> tuple[int, float]:
    """Place of a policy in a table of all tasks: by what it sees, and then by its mean score, clipped."""
    of = [found[policy] for found in lines.values() if policy in found]
    scores = [max(each.score.value, CLIP) for each in of if each.score is not None]
    return KNOWLEDGE.index(of[0].sees), sum(scores) / max(len(scores), 1)


def table(headings: Sequence[str], rows: Iterable[Sequence[str]], left: int = 1) -> list[str]:
    """Lines of a table; the first `left` columns are text."""
    rules = ["---"] * left + ["---:"] * (len(headings) - left)
    return ["| " + " | ".join(cells) + " |" for cells in (headings, rules, *rows)]


def replaced(text: str, results: Sequence[Result]) -> str:
    """The text of a page with the section between its markers."""
    return between(text, BEGIN, END, section(results))


def between(text: str, begin: str, end: str, results: str) -> str:
    """The text of a page with other results between two lines.

    Raises:
        ConfigError: if the page has no such lines.
    """
    before, first, rest = text.partition(begin)
    _, last, after = rest.partition(end)
    if not (first and last):
        raise ConfigError(f"the page has no lines {begin!r} and {end!r} between which the results go: put them in")
    return f"{before}{begin}\n\n{results}\n\n{end}{after}"


def write_readme(results: Sequence[Result], path: Path = README) -> None:
    """Put the section into a page, and write that of all results beside the checked-in ones."""
    write_whole(path, replaced(read_text(path), results))
    write_whole(ROOT / PAGE, page(results))

"""The results section of the README, written from the checked-in results."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from agents.benchmark.aggregate import Runs, aggregates, all_runs, scored_tasks
from agents.benchmark.figures import OVER, figure_names
from agents.benchmark.judge import CLIP, is_ratio
from agents.benchmark.plan import FLAGSHIP
from agents.benchmark.results import Result
from agents.benchmark.summary import HEADINGS, KNOWLEDGE, NONE, Summary, brief, shown, summaries, tasks_of
from agents.provenance import ROOT
from agents.tuned import ConfigError, write_whole

README = ROOT / "README.md"
BEGIN, END = "<!-- results: written by `python -m agents benchmark --report` -->", "<!-- end of results -->"
PICTURES = {
    "cost": "Cost per good part on each task",
    "iqm": "Interquartile mean, median, mean and optimality gap of the score",
    "profiles": "Share of the runs above each score",
    "improvement": f"Probability that a run scores above {OVER}",
}


def section(results: Sequence[Result]) -> str:
    """The text between the markers."""
    tasks = tasks_of(results)
    lines = [*flagship(results), ""] if FLAGSHIP in tasks else []
    lines += [*by_task(results, tasks), ""]
    runs = all_runs(results)
    if runs:
        lines += [*over_tasks(results, runs), ""]
    for name in figure_names(runs):
        lines += [f"![{PICTURES[name]}](agents/results/figures/{name}.png)", ""]
    return "\n".join([*lines, *made_by(results)])


def flagship(results: Sequence[Result]) -> list[str]:
    """Every policy on the flagship task."""
    found = [line.cells(is_ratio(FLAGSHIP)) for line in summaries(results, FLAGSHIP)]
    return [f"`{FLAGSHIP}`:", "", *table(HEADINGS, found, left=2)]


def by_task(results: Sequence[Result], tasks: Sequence[str]) -> list[str]:
    """Score and cost of every policy on every task."""
    lines = {task: {line.policy: line for line in summaries(results, task)} for task in tasks}
    policies = dict.fromkeys(name for task in tasks for name in lines[task])
    ordered = sorted(policies, key=lambda name: standing(name, lines))

    def score(task: str, policy: str) -> str:
        line = lines[task].get(policy)
        if line is None:
            return NONE
        return brief(line.ratio, True) if is_ratio(task) else brief(line.score, False)

    def cost(task: str, policy: str) -> str:
        line = lines[task].get(policy)
        return NONE if line is None else f"{line.cost.value:.3f}"

    return [
        "Score on each task (a number with x: cost over that of the best fixed plan, where the planner costs nearly the"
        " same, so that a score would be noise):",
        "",
        *table(("policy", *tasks), ([p, *(score(t, p) for t in tasks)] for p in ordered)),
        "",
        "Cost, $ per good part:",
        "",
        *table(("policy", *tasks), ([p, *(cost(t, p) for t in tasks)] for p in ordered)),
    ]


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
    seeds = ", ".join(dict.fromkeys(each.seeds for each in results))
    commits = ", ".join(dict.fromkeys(each.commit for each in results))
    return [
        f"Made by (evaluation seeds {seeds}; commit {commits}):",
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
        f" --episodes {first.episodes} --test-episodes {first.test_episodes} --results agents/results"
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
    """Put the section into a page."""
    write_whole(path, replaced(path.read_text(encoding="utf-8"), results))

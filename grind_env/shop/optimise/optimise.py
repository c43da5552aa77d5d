"""Better words for a part program: searched on some lots, chosen on others, judged on unseen ones."""

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from grind_env.control import Programs, read, read_file
from grind_env.errors import GrindError
from grind_env.files import read_bytes
from grind_env.machine.job import Job, Part
from grind_env.machine.job_file import job_beside, load_job
from grind_env.machine.settings import DRESS_SECONDS, D
from grind_env.policies.statistics import Interval, bootstrap
from grind_env.process.cost import NO_LIMIT
from grind_env.shop.optimise.budget import ENOUGH_TRIALS, Between, Budget, TimeUp, nothing, time_said
from grind_env.shop.optimise.editing import ProgramText, added_word, like, other_number, text_of, word_of
from grind_env.shop.optimise.outcome import LimitUse, Optimised, Quantity, Verdict, WordChange
from grind_env.shop.optimise.search import GENERATIONS, Point, Search
from grind_env.shop.optimise.trials import LIMITS, Array, Measures, Trials, lots_of, lots_said, settings_like, trials_of
from grind_env.shop.optimise.unrolling import unrolled
from grind_env.shop.optimise.variables import INHERITED, Choices, Spot, Variable, choices_of
from grind_env.shop.optimise.wishes import WishError, Wishes

SEARCHED, CHOSEN, JUDGED = 16, 128, 256
"""Lots on which programs are searched, on which the best of them are compared, and on which that one is judged; fewer
of a program that the control executes, if there is no time for them."""
FINALISTS = 12
STEP_BY_STEP = 3, 8
"""Finalists, and lots on which they are compared, of a program that the control executes, a thousand times slower."""
INFEASIBLE = 1e9
"""$; what a program that is beyond a limit costs in the search, times one and how far it is beyond."""
FEWER = 4
"""Generations of a search without a limit, over those of the whole one."""
WORTH_NAMING = 0.01
"""Share of the cost of a part that a limit costs at least if it is said to bind."""
SAME = 1e-6
"""Relative difference of settings that are the same but for rounding."""

QUANTITIES = {
    "cost": "$",
    "seconds": "s",
    "Ra": "um",
    "power": "kW",
    "rise": "K",
    "size_error": "um",
    "scrap": "%",
}
UNITS = {"power": "kW", "temp": "K", "Ra": "um", "size": "um"}

FREE = {"temp": ("rise_allowance", 2000.0), "Ra": ("roughness_limit", NO_LIMIT), "size": ("tolerance", NO_LIMIT)}
"""Field of a part that holds a limit, and what it is without."""

LEAST = {"passes": 1}

Progress = Callable[[str, int], object]


class ScriptRanges(NamedTuple):
    """The lowest and the highest J, `picks` in mm, and L that may be chosen; empty where they are not varied."""

    picks: tuple[float, ...] = ()
    spark_outs: tuple[int, ...] = ()


class Problem(NamedTuple):
    """A program of which some words are varied.

    Attributes:
        programs: the program.
        text: of its file.
        job: the job.
        runs: how often it is run.
        seed: of lots and search.
        choices: what is varied.
        ranges: of J and L, as `trials_of` takes them.
        margins: of the limits, as shares of them, shape (4,).
        once: one run of the program on the expected lot.
        base: the batch with the program as it is, on any lots.
        budget: time that there is.
    """

    programs: Programs
    text: ProgramText
    job: Job
    runs: int
    seed: int
    choices: Choices
    ranges: ScriptRanges
    margins: Array
    once: Trials
    base: Trials
    budget: Budget

    def trials(self, use: int, lots: int) -> Trials:
        """The program as it is, on lots of its own for each use."""
        return self.base.on(lots_of(self.seed, use, lots))

    def trials_of(self, programs: Programs, use: int, lots: int) -> Trials:
        """Another text, with its own words only."""
        return trials_of(programs, self.job, self.runs, lots_of(self.seed, use, lots))

    def with_job(self, job: Job, margins: Array, budget: Budget) -> "Problem":
        """The same with another job, other margins, shape (4,), and another time."""
        base = _base(self.programs, job, self.runs, self.seed, self.ranges)
        return self._replace(job=job, margins=margins, base=base, budget=budget)

    @property
    def besides(self) -> bool:
        """Whether others than E and D are varied."""
        return any(each.name not in ("E", "D") for each in self.choices.variables)

    def settings(self, own: Array, points: NDArray[np.int64]) -> Array:
        """Settings of the blocks of one run; points of shape (C, variables)."""
        table = settings_like(own, len(points))
        for k, variable in enumerate(self.choices.variables):
            table[:, variable.blocks, variable.column] = variable.settings[points[:, k], None]
        return table

    def measure(self, trials: Trials, points: list[Point], between: Between = nothing) -> Measures:
        """What programs with other words come to."""
        return trials.measure(self.settings(trials.own, np.array(points)), besides=self.besides, between=between)

    def search(self, trials: Trials, progress: Progress, label: str) -> Search:
        """A search on lots."""
        budget = self.budget

        def costs(points: NDArray[np.int64]) -> Array:
            between = budget.require_search if search.costs else budget.require_first
            found = trials.measure(self.settings(trials.own, points), besides=self.besides, between=between)
            beyond = found.violation(self.margins).sum(axis=1)
            return np.asarray(np.where(beyond > 0.0, INFEASIBLE * (1.0 + beyond), found.cost.mean(axis=1)))

        counts = [len(each.levels) for each in self.choices.variables]
        search = Search(costs, counts, lambda: budget.is_up, trials.at_once, lambda count: progress(label, count))
        return search


def optimise(
    program: str | Path,
    job: str | Path | None = None,
    wishes: Wishes | None = None,
    *,
    parts: int = 50,
    seconds: float = 60.0,
    seed: int = 1,
    unroll: bool = False,
    progress: Progress = lambda label, count: None,
) -> Optimised:
    """Search better words for a program.

    The search, the comparison of the best programs found and the judgement have lots of their own, the same ones for
    all programs. The result is the same for the same seed unless the time ends the search.

    Args:
        program: file of the part program.
        job: its job file; the program's name with `.toml` if not given.
        wishes: what is varied between which bounds, and margins of the limits.
        parts: how often the program is run before the wheel is handed over; the wheel carries over.
        seconds: for the search; it ends with them, and what follows within four times as many and 10 s.
        seed: of lots and search.
        unroll: whether M98 calls of cycle blocks are written out, each with words of its own.
        progress: called with what is being done and by how many programs it has come on.

    Raises:
        GrindError: the program cannot be run, there is nothing to vary in it, or there is no time for one trial.
    """
    program = Path(program)
    job = job_beside(program) if job is None else Path(job)
    programs, text = read_file(program), text_of(read_bytes(program))
    if unroll:
        text = unrolled(programs, text)
        programs = read(text.text, programs.name, programs.folder)
    try:
        problem = problem_of(programs, text, load_job(job), wishes or Wishes(), parts, seed, seconds)
        return _optimised(problem, job.name, progress)
    except TimeUp:
        raise GrindError(
            f"{programs.name}: there was no time to try one program on {SEARCHED} lots, for the control executes this "
            f"one step by step; give it more than --budget {seconds:g}s, or grind fewer than --parts {parts}"
        ) from None


def problem_of(
    programs: Programs, text: ProgramText, job: Job, wishes: Wishes, runs: int, seed: int, seconds: float = math.inf
) -> Problem:
    """What is to be searched; where there is not even time to look at the batch, `TimeUp` ends it.

    Raises:
        GrindError: as `optimise`.
    """
    once = _expected(programs, job)
    budget = Budget(seconds)  # from here on, for the first run compiles what has never been compiled on this machine
    choices = choices_of(once.simulation, text, wishes)
    margins = np.array([wishes.margin(name) for name in LIMITS])
    ranges = _ranges(choices)
    base = _base(programs, job, runs, seed, ranges, budget.require_first)
    problem = Problem(programs, text, job, runs, seed, choices, ranges, margins, once, base, budget)
    why = base.simulation.why
    if why is None or not any(ranges):
        return problem
    others = replace(wishes, words=tuple(name for name in wishes.words if name not in ("J", "L")))
    remark = f"J and L are kept as they are: {why}"
    if not others.words:
        raise WishError(remark)
    choices = choices_of(once.simulation, text, others)
    return problem._replace(
        choices=Choices(choices.variables, (*choices.remarks, remark)),
        ranges=ScriptRanges(),
        base=_base(programs, job, runs, seed, ScriptRanges(), budget.require_first),
    )


def _expected(programs: Programs, job: Job) -> Trials:
    """One run on the expected lot, as of `grind run`."""
    return trials_of(programs, job, 1, [(0,)], spread=0.0)


def _base(
    programs: Programs, job: Job, runs: int, seed: int, ranges: ScriptRanges, between: Between = nothing
) -> Trials:
    picks, spark_outs = ranges
    return trials_of(programs, job, runs, lots_of(seed, 0, 1), picks=picks, spark_outs=spark_outs, between=between)


def with_words(problem: Problem, point: Point) -> ProgramText:
    """The text with the words of a point, a comment at each block that has changed; all else stays.

    Raises:
        GrindError: the text cannot be made to say it.
    """
    chosen = [(each, each.levels[number]) for each, number in zip(problem.choices.variables, point, strict=True)]
    moved = {each.name for each, level in chosen if level != each.own}
    changes, passes = [], []
    for variable, level in chosen:
        at = variable.at
        # a block that would take over what has changed in the one before needs a word of its own
        takes_over = isinstance(at, Spot) and at.missing and variable.name in INHERITED and variable.name in moved
        if level == variable.own and not takes_over:
            continue
        if isinstance(at, Spot):
            word, number = word_of(at.source, at.letter), like(level, at.form)
            changes.append(
                added_word(at.source, at.letter, number) if word is None else other_number(at.source, word, number)
            )
        elif variable.name == "passes":
            passes.append((at, level))
        else:
            changes += at.changes(variable.name, level)
    text = problem.text.changed(changes)
    for at, level in sorted(passes, key=lambda each: -each[0].sources[0].line):
        text = at.with_passes(text, level)
    return text


def _ranges(choices: Choices) -> ScriptRanges:
    picks = [value for each in choices.variables if each.name == "J" for value in each.settings.tolist()]
    spark_outs = [int(value) for each in choices.variables if each.name == "L" for value in each.settings.tolist()]
    return ScriptRanges(
        (min(picks), max(picks)) if picks else (), (min(spark_outs), max(spark_outs)) if spark_outs else ()
    )


def _optimised(problem: Problem, job: str, progress: Progress) -> Optimised:
    variables, budget = problem.choices.variables, problem.budget
    start = tuple(each.start for each in variables)
    search = problem.search(problem.trials(1, SEARCHED), progress, "searching")
    known = budget.spent
    search.run(start, problem.seed)
    seconds = (budget.spent - known) / len(search.costs)
    feasible = [point for point in search.ranked if search.costs[point] < INFEASIBLE]
    point = _chosen(problem, feasible) if feasible else search.ranked[0]
    text = with_words(problem, point)
    programs = read(text.text, problem.programs.name, problem.programs.folder)
    lots = JUDGED if problem.base.simulation.compiled else budget.judged(JUDGED, seconds / SEARCHED)
    same = text.text == problem.text.text and not any(problem.ranges)
    before = problem.trials(3, lots)
    after = before if same else problem.trials_of(programs, 3, lots)
    _require_said(problem, before, after, point)
    progress("judging", 0)
    old = before.measure(before.own[None])
    new = old if same else after.measure(after.own[None])
    difference = _paired(new.cost[0] - old.cost[0])
    beyond = new.violation(problem.margins)[0]
    sought = feasible and before.simulation.compiled
    prices = _prices(problem, before, point, Budget(0.5 * budget.seconds), progress) if sought else {}
    limits = _limits(problem, old, new, prices)
    on = lots_said(len(before.seeds), "unseen lots")
    verdict, reason = _verdict(bool(feasible), difference, limits, beyond, on)
    if verdict is not Verdict.BETTER and search.ended_early and len(search.costs) == 1:
        enough = f"try some {ENOUGH_TRIALS} with --budget {time_said(ENOUGH_TRIALS * seconds)}"
        verdict, reason = Verdict.UNTRIED, f"the first one took all the time of the search; {enough}"
    better = verdict is Verdict.BETTER
    quantities = _quantities(problem.once, problem.once if same else _expected(programs, problem.job), old, new)
    return Optimised(
        program=problem.programs.name,
        job=job,
        verdict=verdict,
        reason=reason,
        words=tuple(_word(each, number) for each, number in zip(variables, point, strict=True)),
        quantities=quantities,
        limits=limits,
        remarks=(*problem.choices.remarks, *_undressed(before, after, problem.runs), *_few(len(before.seeds), lots)),
        before=problem.text.text,
        after=text.text if better else problem.text.text,
        data=text.bytes() if better else problem.text.bytes(),
        parts=problem.runs,
        lots=len(before.seeds),
        seed=problem.seed,
        evaluations=len(search.costs),
        ended_early=search.ended_early,
    )


def _chosen(problem: Problem, ranked: list[Point]) -> Point:
    """The best of the first programs on lots that no search has seen; the nearest to the limits if none keeps them.

    Without the time for that it is the first of them.
    """
    count, lots = (FINALISTS, CHOSEN) if problem.base.simulation.compiled else STEP_BY_STEP
    finalists = ranked[:count]
    try:
        found = problem.measure(problem.trials(2, lots), finalists, problem.budget.require_comparison)
    except TimeUp:
        return finalists[0]
    beyond = found.violation(problem.margins).sum(axis=1)
    cost = np.where(beyond > 0.0, INFEASIBLE * (1.0 + beyond), found.cost.mean(axis=1))
    return finalists[int(cost.argmin())]


def _require_said(problem: Problem, before: Trials, after: Trials, point: Point) -> None:
    """Refuse a text that does not say what was searched: what its blocks set is read off the text itself."""
    asked = problem.settings(before.own, np.array([point]))[0]
    said = after.own
    columns = [k for k in range(asked.shape[1]) if k != DRESS_SECONDS]
    if asked.shape != said.shape or not np.allclose(asked[:, columns], said[:, columns], rtol=SAME, atol=0.0):
        raise GrindError(
            f"{problem.programs.name}: other numbers in its words do not change its cycles as they say, so that no "
            "better program can be written; vary fewer words with --vary"
        )


def _verdict(
    feasible: bool, difference: Interval, limits: tuple[LimitUse, ...], beyond: Array, on: str
) -> tuple[Verdict, str]:
    worst = limits[int(beyond.argmax())]
    if not feasible:
        return Verdict.INFEASIBLE, (
            f"the limit of {worst.name} forbids all programs tried: with the nearest one 95 of 100 parts stay "
            f"below {100.0 * worst.after:.0f} % of it, and {100.0 * worst.margin:.0f} % is asked"
        )
    if beyond.max() > 0.0:
        return Verdict.NOT_BETTER, (
            f"the best one is beyond the limit of {worst.name} on {on}: 95 of 100 parts stay below "
            f"{100.0 * worst.after:.1f} % of it, and {100.0 * worst.margin:.0f} % is asked"
        )
    said = f"{difference.value:+.3f} $ a part ({difference.low:+.3f} to {difference.high:+.3f})"
    if difference.high >= 0.0:
        return Verdict.NOT_BETTER, f"the best one costs {said} more than the program as it is"
    return Verdict.BETTER, f"{said} on {on}, the same for both"


def _paired(difference: Array) -> Interval:
    return bootstrap(lambda values: np.asarray(values.mean(axis=-1)), difference)


def _quantities(once: Trials, once_after: Trials, old: Measures, new: Measures) -> tuple[Quantity, ...]:
    expected = [_shown(each) for each in (once, once_after)]
    found = []
    for name, unit in QUANTITIES.items():
        scale = 100.0 if unit == "%" else 1.0
        before, after = (scale * getattr(each, name)[0] for each in (old, new))
        found.append(
            Quantity(
                name=name,
                unit=unit,
                before=_paired(before),
                after=_paired(after),
                difference=_paired(after - before),
                expected=(scale * expected[0][name], scale * expected[1][name]),
            )
        )
    return tuple(found)


def _shown(once: Trials) -> dict[str, float]:
    """Means of a part with one run of a program, as `grind run` shows them."""
    found = once.measure(once.own[None], handover=False)
    return {name: float(getattr(found, name)[0, 0]) for name in QUANTITIES}


def _limits(problem: Problem, old: Measures, new: Measures, prices: dict[str, Interval]) -> tuple[LimitUse, ...]:
    limits = problem.job.limits
    values = {
        "power": limits.power / 1000.0,
        "temp": limits.rise,
        "Ra": limits.roughness,
        "size": limits.size,
    }
    return tuple(
        LimitUse(
            name=name,
            limit=values[name],
            unit=UNITS[name],
            margin=float(problem.margins[k]),
            before=float(old.ratios[0, k]),
            after=float(new.ratios[0, k]),
            price=prices.get(name),
            binds=name in prices and prices[name].low > WORTH_NAMING * float(new.cost.mean()),
        )
        for k, name in enumerate(LIMITS)
    )


def _prices(problem: Problem, judged: Trials, best: Point, budget: Budget, progress: Progress) -> dict[str, Interval]:
    """What each limit costs: what the best words without it save on unseen lots."""
    with_all, prices = problem.measure(judged, [best]).cost[0], {}
    for k, name in enumerate(LIMITS):
        free = without(problem.job, name)
        if free is None:
            continue
        margins = problem.margins.copy()
        margins[k] = np.inf
        other = problem.with_job(free, margins, budget)
        search = other.search(other.trials(1, SEARCHED), progress, f"without the limit of {name}")
        search.run(best, problem.seed, GENERATIONS // FEWER)
        point = _chosen(other, [best, *search.ranked])
        found = other.measure(other.trials(3, JUDGED), [point]).cost[0]
        prices[name] = _paired(with_all - found)
    return prices


def without(job: Job, limit: str) -> Job | None:
    """The job without a limit; None if it has none."""
    machine = job.setup.machine
    if limit == "power":
        stronger = replace(machine, power_limit=min(4.0 * machine.power_limit, 500_000.0))
        return replace(job, setup=replace(job.setup, machine=stronger))
    name, free = FREE[limit]
    kinds = [job.part, *(each.part for each in job.parts if each.part is not None)]
    if free == NO_LIMIT and all(getattr(asked, name) == NO_LIMIT for kind in kinds for asked in (kind, *kind.stages)):
        return None

    def freed(part: Part) -> Part:
        other: dict[str, Any] = {name: free}
        return replace(part, stages=tuple(replace(stage, **other) for stage in part.stages), **other)

    parts = tuple(each if each.part is None else replace(each, part=freed(each.part)) for each in job.parts)
    return replace(job, part=freed(job.part), parts=parts)


def _few(judged: int, lots: int) -> list[str]:
    """A remark if there was no time for all the lots of the judgement; a job that states its parts has one."""
    if judged == lots < JUDGED:
        return [f"judged on {lots} lots, for {JUDGED} take longer than the time allows: --budget gives it more"]
    return []


def _undressed(before: Trials, after: Trials, runs: int) -> list[str]:
    """A warning if the wheel is no longer dressed."""
    before_cycles = any(block.plan.pre_dress for block in after.simulation.blocks)
    if before.own[:, D].any() and not after.own[:, D].any() and not before_cycles:
        return [
            f"no block dresses the wheel any more: that holds for batches of {runs} runs, after which it is dressed; "
            "let --parts be how many you grind with a wheel, or see with `grind sweep` how often to dress it"
        ]
    return []


def _bound(variable: Variable, number: int) -> str:
    """Which end of what was tried a value is; empty for none, and for the least that there can be."""
    if number == len(variable.levels) - 1:
        return "highest"
    return "lowest" if number == 0 and variable.levels[0] > LEAST.get(variable.name, 0) else ""


def _word(variable: Variable, number: int) -> WordChange:
    inch = variable.unit != 1
    units = {"E": ("mm/min", "in/min"), "J": ("mm", "in"), "lead": ("mm/min", "in/min"), "depth": ("mm", "in")}
    return WordChange(
        name=variable.name,
        place=variable.place,
        before=f"{variable.own.normalize():f}",
        after=f"{variable.levels[number].normalize():f}",
        unit=units[variable.name][inch] if variable.name in units else "",
        at_bound=_bound(variable, number),
    )

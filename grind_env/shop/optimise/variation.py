"""A program of which some words are varied: what is searched, and what it costs with other words."""

import math
from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grind_env.arrays import Array
from grind_env.control import Programs
from grind_env.machine.job import Job
from grind_env.shop.optimise.budget import Budget
from grind_env.shop.optimise.editing import ProgramText
from grind_env.shop.optimise.search import Point, Search
from grind_env.shop.optimise.spots import Spot
from grind_env.shop.optimise.variables import INHERITED, Choices, choices_of
from grind_env.shop.optimise.wishes import WishError, Wishes
from grind_env.shop.trials import LIMITS, Between, LotUse, Measures, Trials, lots_of, nothing, settings_like, trials_of

INFEASIBLE = 1e9
"""$; what a program that is beyond a limit costs in the search, times one and how far it is beyond."""

Progress = Callable[[str, int], object]


class ScriptRanges(NamedTuple):
    """The lowest and the highest J, `picks` in mm, and L that may be chosen; empty where they are not varied."""

    picks: tuple[float, ...] = ()
    spark_outs: tuple[int, ...] = ()


class Variation(NamedTuple):
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

    def trials(self, use: LotUse, lots: int) -> Trials:
        """The program as it is, on lots of its own for each use."""
        return self.base.on(lots_of(self.seed, use, lots))

    def trials_of(self, programs: Programs, use: LotUse, lots: int) -> Trials:
        """Another text, with its own words only."""
        return trials_of(programs, self.job, self.runs, lots_of(self.seed, use, lots))

    def with_job(self, job: Job, margins: Array, budget: Budget) -> "Variation":
        """The same with another job, other margins, shape (4,), and another time."""
        base = _base(self.programs, job, self.runs, self.seed, self.ranges)
        return self._replace(job=job, margins=margins, base=base, budget=budget)

    @property
    def besides(self) -> bool:
        """Whether others than E and D are varied."""
        return any(each.name not in ("E", "D") for each in self.choices.variables)

    def settings(self, own: Array, points: NDArray[np.int64]) -> Array:
        """Settings of the blocks of the trials; points of shape (C, variables)."""
        table = settings_like(own, len(points))
        for k, variable in enumerate(self.choices.variables):
            table[:, variable.blocks, variable.column] = variable.settings[points[:, k], None]
        return table

    def measure(self, trials: Trials, points: list[Point], between: Between = nothing) -> Measures:
        """What programs with other words come to."""
        return trials.measure(self.settings(trials.own, np.array(points)), besides=self.besides, between=between)

    def with_words(self, point: Point) -> ProgramText:
        """The text with the words of a point, a comment at each block that has changed; all else stays.

        Raises:
            GrindError: the text cannot be made to say it.
        """
        chosen = [(each, each.levels[number]) for each, number in zip(self.choices.variables, point, strict=True)]
        moved = {each.name for each, level in chosen if level != each.own}
        changes, passes = [], []
        for variable, level in chosen:
            at = variable.at
            # a block that would take over what has changed in the one before needs a word of its own
            takes_over = isinstance(at, Spot) and at.missing and variable.name in INHERITED and variable.name in moved
            if level == variable.own and not takes_over:
                continue
            if isinstance(at, Spot):
                changes.append(at.change(level))
            elif variable.name == "passes":
                passes.append((at, level))
            else:
                changes += at.changes(variable.name, level)
        text = self.text.changed(changes)
        for at, level in sorted(passes, key=lambda each: -each[0].sources[0].line):
            text = at.with_passes(text, level)
        return text

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


def variation_of(
    programs: Programs, text: ProgramText, job: Job, wishes: Wishes, runs: int, seed: int, seconds: float = math.inf
) -> Variation:
    """What is to be searched; where there is not even time to look at the batch, `TimeUp` ends it.

    Raises:
        GrindError: as `optimise`.
    """
    once = one_run(programs, job)
    budget = Budget(seconds)  # from here on, for the first run compiles what has never been compiled on this machine
    choices = choices_of(once.simulation, text, wishes)
    margins = np.array([wishes.margin(name) for name in LIMITS])
    ranges = _ranges(choices)
    base = _base(programs, job, runs, seed, ranges, budget.require_first)
    seen = once.simulation
    if not base.alike:
        seen = base.as_written(programs)
        choices = choices_of(seen, text, wishes)
        ranges = _ranges(choices)
        base = _base(programs, job, runs, seed, ranges, budget.require_first)
    variation = Variation(programs, text, job, runs, seed, choices, ranges, margins, once, base, budget)
    why = base.simulation.why
    if why is None or not any(ranges):
        return variation
    others = replace(wishes, words=tuple(name for name in wishes.words if name not in ("J", "L")))
    remark = f"J and L are kept as they are: {why}"
    if not others.words:
        raise WishError(remark)
    choices = choices_of(seen, text, others)
    return variation._replace(
        choices=Choices(choices.variables, (*choices.remarks, remark)),
        ranges=ScriptRanges(),
        base=_base(programs, job, runs, seed, ScriptRanges(), budget.require_first),
    )


def one_run(programs: Programs, job: Job) -> Trials:
    """One run on the expected lot, as of `grind run`."""
    return trials_of(programs, job, 1, [(0,)], spread=0.0)


def _base(
    programs: Programs, job: Job, runs: int, seed: int, ranges: ScriptRanges, between: Between = nothing
) -> Trials:
    picks, spark_outs = ranges
    return trials_of(
        programs, job, runs, lots_of(seed, LotUse.BASE, 1), picks=picks, spark_outs=spark_outs, between=between
    )


def _ranges(choices: Choices) -> ScriptRanges:
    picks = [value for each in choices.variables if each.name == "J" for value in each.settings.tolist()]
    spark_outs = [int(value) for each in choices.variables if each.name == "L" for value in each.settings.tolist()]
    return ScriptRanges(
        (min(picks), max(picks)) if picks else (), (min(spark_outs), max(spark_outs)) if spark_outs else ()
    )

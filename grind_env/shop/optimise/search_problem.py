"""A program with variable words: its search space, and the cost of each variation."""

from collections.abc import Callable
from dataclasses import replace
from decimal import Decimal
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from grind_env.array_types import Array
from grind_env.control import Programs, read
from grind_env.envs.job.job_simulation import JobSimulation
from grind_env.machine.job import Job
from grind_env.machine.script.repeated_script import SAMPLE_RUNS, is_straight
from grind_env.shop.optimise.counter_writer import Counting, counting_of
from grind_env.shop.optimise.result import Trade
from grind_env.shop.optimise.search import Budget, Point, Search
from grind_env.shop.optimise.variables import COLUMNS, INHERITED, SearchSpace, SearchVariable, choices_of, join_equal
from grind_env.shop.optimise.word_editing import ProgramText, Spot, like
from grind_env.shop.possible_machines import Fleet, compile_all, fleet_of
from grind_env.shop.search_options import LIMITS, OptionError, SearchOptions
from grind_env.shop.trials import CORES, Between, LotUse, Measures, Trials, lots_of, most_risk, risk, trials_of

INFEASIBLE = 1e9  #: cost of a program beyond a limit in the search, $, times 1 plus its excess

DRAWING_SHARE = 0.2  #: share of the budget up to which possible machines are drawn
USUAL_RUNS = 50  #: usual number of runs of a batch; shorter batches have proportionally more lots
#: number of lots of search, comparison and judgement; more if batches are short, fewer if the control executes the
#: program
LOTS = {LotUse.SEARCH: 20, LotUse.COMPARISON: 256, LotUse.JUDGEMENT: 256}
#: parts of a batch above which comparison and judgement have at most this number of lots, one on each machine
MANY_PARTS, FEWEST = 100, 192
#: greatest factor on the lots of short batches: in the search, which tries thousands of programs, and half of it in the
#: comparison of hundreds
MOST_LOTS_FACTOR = 4
#: range and number of the ratios of E to the programmed E at the begin of a search, as in `grind sweep`
RATIOS, RATIO_VALUES = (0.5, 2.0), 9
FEWER_RATIOS = 4  #: intervals in blocks are combined with every n-th ratio only, because there are many

#: share of the permitted values for programs in a comparison, so that they keep the limits on other lots, too
SURE = 0.96
LOTS_AT_ONCE = 1280  #: lots of all programs together between two checks of the clock

#: shares of the way from the programmed words to the best ones, and from the programmed dress interval to the best
STEPS, PARTS = (0.5, 0.25, 0.75, 1.0), (0.0, 0.5, 1.0)

Progress = Callable[[str, int], object]


class Variation(NamedTuple):
    """Program with variable words."""

    programs: Programs
    text: ProgramText  #: text of its file
    job: Job
    runs: int  #: number of its runs in a batch
    seed: int  #: seed of lots and search
    options: SearchOptions  #: options of the search
    # variables and intervals; a point of the search has the number of a level for each variable, then of an interval
    choices: SearchSpace
    margins: Array  #: margins of the limits, as shares of them, shape (4,)
    once: Trials  #: one run of the program on the expected lot
    base: Trials  #: the batch of the unchanged program, on any lots
    budget: Budget  #: time or number of programs
    fleet: Fleet | None = None  #: possible machines; None for the machine of the job alone

    def trials(self, use: LotUse, lots: int | None = None) -> Trials:
        """Return trials of the unchanged program on the lots and machines of a use; by default the lots of `LOTS`."""
        trials = replace(self.base, confidence=self.options.confidence)
        seeds = lots_of(self.seed, use, self._lots(use) if lots is None else lots)
        return trials.with_lots(seeds) if self.fleet is None else self.fleet.trials_for(trials, use, seeds)

    def read_trials(self, programs: Programs) -> Trials:
        """Return trials of another text of the program, on one lot."""
        return trials_of(programs, self.job, self.runs, lots_of(self.seed, LotUse.JUDGEMENT, 1))

    def _lots(self, use: LotUse) -> int:
        """Return the number of lots for a use; more for short batches, which rarely show scrap of one part in 200."""
        if not self.base.simulation.compiled:
            return LOTS[use]
        more = -(-USUAL_RUNS // self.runs)
        most = {LotUse.SEARCH: MOST_LOTS_FACTOR, LotUse.COMPARISON: -(-min(more, MOST_LOTS_FACTOR) // 2)}
        lots = LOTS[use] * min(more, most.get(use, more))
        return min(lots, FEWEST) if self.base.simulation.parts > MANY_PARTS and use is not LotUse.SEARCH else lots

    @property
    def reading_seconds(self) -> float:
        """Return the time, s, to execute a changed text of the program for all runs."""
        same = is_straight(self.programs) and len(self.choices.intervals) == 1
        return self.base.execution * (min(SAMPLE_RUNS, self.runs) if same else self.runs)

    def with_job(self, job: Job, margins: Array, budget: Budget) -> "Variation":
        """Return a copy with another job, other margins, shape (4,), and another budget."""
        return self._replace(job=job, margins=margins, base=self.base.with_job(job), budget=budget)

    def for_machine(self, job: Job) -> "Variation":
        """Return a copy for the job of another, known machine."""
        base = _base(self.programs, job, self.runs, self.seed, self.choices)
        return self._replace(job=job, base=base, once=one_run(self.programs, job), fleet=None)

    @property
    def counts(self) -> list[int]:
        return [*(len(each.levels) for each in self.choices.variables), len(self.choices.intervals)]

    @property
    def start(self) -> Point:
        """Return the point of the unchanged program, or the nearest one."""
        return (*(each.start for each in self.choices.variables), 0)

    def steps_to(self, point: Point) -> list[Point]:
        """Return points between the unchanged program and another point, safe steps first.

        The dress interval changes independently of the words, because it and E are uncertain for different reasons.
        """
        start = self.start
        ways = [
            (
                *(round(own + share * (end - own)) for own, end in zip(start, point[:-1], strict=False)),
                round(part * point[-1]),
            )
            for share, part in product(STEPS, PARTS)
        ]
        return [way for way in dict.fromkeys(ways) if way not in (start, point)]

    def settings(self, own: Array, points: NDArray[np.int64]) -> Array:
        """Return the settings of the blocks of all runs; points have shape (C, coordinates)."""
        table = np.repeat(own[None], len(points), axis=0)
        varied = np.zeros(len(own), bool)
        for k, variable in enumerate(self.choices.variables):
            blocks = self._blocks_of_all_runs(variable)
            table[:, blocks, COLUMNS[variable.name]] = variable.settings[points[:, k], None]
            varied[blocks if variable.name == "D" else []] = True
        executions, run = table[..., COLUMNS["D"]], self.base.run_of_block
        for k, number in enumerate(points[:, -1].tolist()):
            due = self.choices.intervals[number].due(varied & (executions[k] > 0.0), run)
            executions[k] *= due | ~varied
        return table

    def _blocks_of_all_runs(self, variable: SearchVariable) -> NDArray[np.int64]:
        blocks = np.array(variable.blocks)
        if not self.base.alike:
            return blocks
        return np.asarray(np.add.outer(np.arange(self.runs) * len(self.base.blocks), blocks).ravel())

    def measure(self, trials: Trials, points: ArrayLike, between: Between = lambda: None) -> Measures:
        settings = self.settings(trials.own, np.array(points))
        others = any(each.name not in ("E", "D") for each in self.choices.variables)
        return trials.measure(settings, other_settings=others, between=between)

    def counting(self, point: Point) -> Counting | None:
        """Return the counting text of a point's interval; None if every part or no part is dressed."""
        chosen = zip(self.choices.variables, point, strict=False)
        dressing = [each for each, number in chosen if each.name == "D" and each.levels[number]]
        if not dressing:
            return None
        spots = [twin.at.source for each in dressing for twin in (each, *each.twins) if isinstance(twin.at, Spot)]
        return counting_of(self.choices.intervals[point[-1]], self.programs, spots, self.job.variables)

    def with_words(self, point: Point) -> ProgramText:
        """Return the text with the words of a point, a comment at each block that has changed; all else stays."""
        chosen = [
            (twin, each.levels[number])
            for each, number in zip(self.choices.variables, point, strict=False)
            for twin in (each, *each.twins)
        ]
        moved = {each.name for each, level in chosen if level != each.own}
        counting = self.counting(point)
        changes, passes = [], []
        for variable, level in chosen:
            at = variable.at
            executions = counting.word(level) if counting and variable.name == "D" and level > 0 else None
            # a block that would take over a changed word from the block before needs its own word
            takes_over = isinstance(at, Spot) and at.missing and variable.name in INHERITED and variable.name in moved
            if level == variable.own and not takes_over and executions is None:
                continue
            if isinstance(at, Spot):
                changes.append(at.change(executions or like(level, at.form)))
            elif variable.name == "passes":
                passes.append((at, level))
            else:
                changes += at.changes(variable.name, level)
        text = self.text.changed(changes, () if counting is None else counting.edits(self.text))
        for at, level in sorted(passes, key=lambda each: -each[0].sources[0].line):
            text = at.with_passes(text, level)
        return text

    def read(self, point: Point) -> Programs:
        return read(self.with_words(point).text, self.programs.name, self.programs.folder)

    def shares(self, trials: Trials, found: Measures, old: Measures) -> Array:
        """Return the shares of limits, options and risk that C candidates use, shape (C, limits + options + 1).

        The last share is `risk` over `most_risk`.
        """
        means = [getattr(found, name).mean(axis=1) / most for name, most in self.options.constraint.items()]
        return np.column_stack(
            [found.ratios / self.margins, *means, self.risk(trials, found, old) / most_risk(self.job)]
        )

    def risk(self, trials: Trials, found: Measures, old: Measures) -> Array:
        """Return the risk as in `trials.risk`; 0 if the old program misses a requirement: a new one may cost more."""
        if any(getattr(old, name).mean() > most for name, most in self.options.constraint.items()):
            return np.zeros(len(found.cost))
        return risk(trials, found, old, self.options.quantity)

    def worth(self, shares: Array, found: Measures) -> Array:
        """Return the objective of C candidates, shape (C,); `INFEASIBLE` or more if a requirement is missed."""
        beyond = np.maximum(shares - 1.0, 0.0).sum(axis=1)
        less = getattr(found, self.options.quantity).mean(axis=1)
        return np.asarray(np.where(beyond > 0.0, INFEASIBLE * (1.0 + beyond), less))

    def search(
        self, trials: Trials, label: str, progress: Progress, tried: dict[Point, Trade], *, comparing: bool = False
    ) -> Search:
        """Return a search on some lots; `tried` gets the result of each candidate.

        The search ends early enough for the steps after it. In a comparison, programs must keep `SURE` of the permitted
        values.
        """
        budget, first = self.budget, list[Measures]()

        def is_up() -> bool:
            return budget.is_comparison_up if comparing else budget.is_search_up

        def costs(points: NDArray[np.int64]) -> Array:
            between = budget.require_search if search.costs else budget.require_first
            found = self.measure(trials, points, between)
            first[:] = first or [found]
            shares = self.shares(trials, found, first[0]) / (SURE if comparing else 1.0)
            means = found.cost.mean(axis=1), found.seconds.mean(axis=1), shares.max(axis=1)
            beyond = map(tuple, (shares[:, : len(LIMITS)] > 1.0).tolist())
            trades = zip(*(each.tolist() for each in means), beyond, strict=True)
            tried.update(zip(map(tuple, points.tolist()), map(Trade._make, trades), strict=True))
            return self.worth(shares, found)

        at_once = min(trials.at_once, max(LOTS_AT_ONCE // len(trials.seeds), CORES))
        most = budget.programs / 4 if comparing else budget.programs
        search = Search(costs, self.counts, is_up, at_once, lambda count: progress(label, count), most)
        return search

    def grid(self) -> list[Point]:
        """Return the first points of the search: all E in one ratio to the program's, with each interval.

        Dresses are the program's, in all its blocks or in the first of them only, such as before roughing. Every second
        ratio with intervals 1, 2, 4, .. comes first, because time may be short.
        """
        variables, start = self.choices.variables, self.start
        dressing = [k for k, each in enumerate(variables) if each.name == "D"]
        by_blocks = list(start)
        if dressing and not any(variables[k].levels[start[k]] for k in dressing):
            by_blocks[dressing[0]] = min(by_blocks[dressing[0]] + 1, self.counts[dressing[0]] - 1)
        first = list(by_blocks)
        for k in dressing[1:]:
            first[k] = 0 if variables[k].levels[0] == 0 else first[k]
        coarse, between = list[Point](), list[Point]()
        for pattern in (by_blocks, first):
            for number, ratio in enumerate(np.geomspace(*RATIOS, RATIO_VALUES).tolist()):
                point = list(pattern)
                for k, each in enumerate(variables):
                    if each.name == "E":
                        point[k] = each.nearest(each.own * Decimal(repr(ratio)))
                for k, interval in enumerate(self.choices.intervals):
                    if interval.of != "block" or number % FEWER_RATIOS == 0:
                        is_coarse = number % 2 == 0 and interval.every & (interval.every - 1) == 0
                        (coarse if is_coarse else between).append((*point[:-1], k))
        return list(dict.fromkeys(coarse + between))


def variation_of(
    programs: Programs,
    text: ProgramText,
    job: Job,
    options: SearchOptions,
    runs: int,
    seed: int,
    budget: Budget | None = None,
) -> Variation:
    """Return the search problem of a program; raise `TimeUp` if time is too short to execute the batch.

    The clock of the budget starts after compilation.
    """
    once = one_run(programs, job)
    compile_all(once)
    budget = Budget() if budget is None else replace(budget, began=Budget().began)
    margins = np.array([options.margins.get(name, 1.0) for name in LIMITS])
    choices = _choices(once.simulation, text, options, runs)
    base = _base(programs, job, runs, seed, choices, budget.require_first)
    seen, of_all = (once.simulation, False) if base.alike else (base.as_written(programs), True)
    if of_all:
        choices = _choices(seen, text, options, runs, of_all=True)
        base = _base(programs, job, runs, seed, choices, budget.require_first)
    why = base.simulation.why
    if why is not None and any(each.name in ("J", "L") for each in choices.variables):
        others = replace(options, words=tuple(name for name in options.words if name not in ("J", "L")))
        remark = f"J and L are kept as they are: {why}"
        if not others.words:
            raise OptionError(remark)
        choices = _choices(seen, text, others, runs, of_all=of_all)
        choices = choices._replace(remarks=(*choices.remarks, remark))
        base = _base(programs, job, runs, seed, choices, budget.require_first)
    fleet = fleet_of(base, seed, untried=options.untried, is_up=lambda: budget.spent > DRAWING_SHARE * budget.seconds)
    return Variation(programs, text, job, runs, seed, options, choices, margins, once, base, budget, fleet)


def _choices(
    simulation: JobSimulation, text: ProgramText, options: SearchOptions, runs: int, *, of_all: bool = False
) -> SearchSpace:
    """Return the search space; words of equal parts are one variable unless `options.free`."""
    space = choices_of(simulation, text, options, runs, of_all=of_all)
    return space if options.free else space._replace(variables=join_equal(space.variables, simulation))


def one_run(programs: Programs, job: Job) -> Trials:
    """Return one run on the expected lot, as in `grind run`."""
    return trials_of(programs, job, 1, [(0,)], spread=0.0)


def _base(
    programs: Programs, job: Job, runs: int, seed: int, choices: SearchSpace, between: Between = lambda: None
) -> Trials:
    """Return the batch of the unchanged program, whose J and L may go from their lowest to their highest levels."""
    picks = [value for each in choices.variables if each.name == "J" for value in each.settings.tolist()]
    spark_outs = [int(value) for each in choices.variables if each.name == "L" for value in each.settings.tolist()]
    return trials_of(
        programs,
        job,
        runs,
        lots_of(seed, LotUse.BASE, 1),
        picks=(min(picks), max(picks)) if picks else (),
        spark_outs=(min(spark_outs), max(spark_outs)) if spark_outs else (),
        between=between,
    )

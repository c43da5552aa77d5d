"""Search over whole numbers: differential evolution, then single steps from the best point.

Differential evolution (Storn & Price 1997; SciPy) handles whole numbers such as D, needs no gradient of a cost with
limits, and evaluates a generation at once, which is one replay of many machines. The steps after it end at a point that
no single change, and no change of two values by one level each, improves.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import combinations, product
from time import monotonic

import numpy as np
from numpy.typing import NDArray

from grind_env.array_types import Array

Point = tuple[int, ...]

#: number of points of a generation: per variable, at least, and at most
PER_VARIABLE, LEAST_POPULATION, MOST_POPULATION = 10, 24, 120
GENERATIONS = 40
#: strategy that found the optimum of Oracle6 with 16 of 16 seeds (SciPy's default: 7 of 8) after some 2600 points
STRATEGY = "randtobest1bin"
SETTLED = 1e-3  #: relative spread of the costs of a generation at which it has settled
AT_ONCE = 64  #: greatest number of points between two checks of the clock
MOST_PAIRS = 14  #: greatest number of variables with which changes of two at once are tried
COMPARISON_SHARE = 0.3  #: share of the time that a search leaves for the comparison of its best programs
MOST_JUDGING = 0.4  #: greatest share of the time for the judgement
#: greatest time up to the end of the first trial: a multiple of the budget, plus a time, s
FIRST_TRIAL_FACTOR, FIRST_TRIAL_SECONDS = 1.5, 4.0
ENOUGH_TRIALS = 100  #: number of trials for which a message names the time, if one trial has taken the whole budget


class TimeUp(Exception):
    """Signal that the time of a budget is up during a run."""


@dataclass(slots=True)
class Budget:
    """Budget of a search: a time, or a number of programs."""

    seconds: float = math.inf  #: time, s; infinite if programs are counted
    programs: float = math.inf  #: greatest number of programs of a search; a comparison has a quarter of it
    judging: float = 0.0  #: time reserved for the judgement, s
    began: float = field(default_factory=lambda: monotonic())  #: time of the clock at its begin, s

    @property
    def spent(self) -> float:
        """Return the time since the search began, s."""
        return monotonic() - self.began

    def keep(self, seconds: float) -> None:
        """Reserve some time for the judgement, up to `MOST_JUDGING`."""
        self.judging = min(seconds, MOST_JUDGING * self.seconds)

    @property
    def is_search_up(self) -> bool:
        """Return whether it is time for the comparison."""
        return self.spent > (1.0 - COMPARISON_SHARE) * self.seconds - self.judging

    @property
    def is_comparison_up(self) -> bool:
        """Return whether it is time for the judgement."""
        return self.spent > self.seconds - self.judging

    def require_search(self) -> None:
        """Raise `TimeUp` once the time of search and comparison is up."""
        if self.is_comparison_up:
            raise TimeUp

    def require_first(self) -> None:
        """Raise `TimeUp` once the time of the first trial is up."""
        if self.spent > FIRST_TRIAL_FACTOR * self.seconds + FIRST_TRIAL_SECONDS:
            raise TimeUp


def time_text(seconds: float) -> str:
    """Return a time as a text for --budget, rounded up."""
    return f"{max(-(-seconds // 1), 1):.0f}s" if seconds <= 120.0 else f"{-(-seconds // 60):.0f}min"


@dataclass(slots=True)
class Search:
    """Search, with the costs of all points evaluated so far."""

    # costs of points, shape (C, variables) -> (C,); called once for each point. `TimeUp` from it ends the search
    # without these points
    objective: Callable[[NDArray[np.int64]], Array]
    counts: Sequence[int]  #: number of values of each variable
    is_up: Callable[[], bool] = lambda: False  #: whether the time is up
    at_once: int = AT_ONCE  #: greatest number of points in a call of the objective
    # called with the number of points after each call of the objective
    advance: Callable[[int], object] = lambda count: None
    most: float = math.inf  #: greatest number of points to evaluate
    costs: dict[Point, float] = field(default_factory=dict)  #: costs of all points evaluated
    ended_early: bool = False  #: whether the time, or `most`, ended the search

    @property
    def ranked(self) -> list[Point]:
        return sorted(self.costs, key=lambda point: (self.costs[point], point))

    def costs_of(self, points: Sequence[Point]) -> Array:
        """Return the costs of points; each point is evaluated once."""
        new = [point for point in dict.fromkeys(points) if point not in self.costs]
        while new:
            left = self.most - len(self.costs)
            if self.costs and (left <= 0 or self.is_up()):
                raise TimeUp
            count = int(max(min(self.at_once, AT_ONCE, left), 1))
            some, new = new[:count], new[count:]
            self.costs.update(zip(some, self.objective(np.array(some, np.int64)).tolist(), strict=True))
            self.advance(len(some))
        return np.array([self.costs[point] for point in points])

    def run(self, start: Point, seed: int, generations: int = GENERATIONS, grid: Sequence[Point] = ()) -> Point:
        """Return the cheapest point of a start, a grid, an evolution and steps; the start has no time limit."""
        self.costs_of([start])
        if all(count == 1 for count in self.counts):
            return start
        try:
            self.costs_of(grid)
            if generations:
                self._evolve(self.ranked[0], seed, generations)
            self._descend()
        except TimeUp:
            self.ended_early = True
        return self.ranked[0]

    def _evolve(self, start: Point, seed: int, generations: int) -> None:
        from scipy.optimize import differential_evolution

        free = [k for k, count in enumerate(self.counts) if count > 1]
        size = min(max(PER_VARIABLE * len(free), LEAST_POPULATION), MOST_POPULATION)

        def costs(points: Array) -> Array:
            whole = np.rint(points.T.reshape(-1, len(free))).astype(int)
            rows = np.tile(np.array(start), (len(whole), 1))
            rows[:, free] = whole
            return self.costs_of([tuple(row) for row in rows.tolist()])

        differential_evolution(
            costs,
            [(0, self.counts[k] - 1) for k in free],
            strategy=STRATEGY,
            integrality=[True] * len(free),
            init="sobol",
            popsize=-(-size // len(free)),
            maxiter=generations,
            tol=SETTLED,
            x0=[start[k] for k in free],
            rng=np.random.default_rng(seed),
            polish=False,
            vectorized=True,
            updating="deferred",
        )

    def _descend(self) -> None:
        """Go to the cheapest neighbour while one is cheaper; change two values only if no single change helps."""
        best = self.ranked[0]
        while True:
            for neighbours in (self._steps(best), self._pairs(best)):
                self.costs_of(neighbours)
                if (better := self.ranked[0]) != best:
                    break
            else:
                return
            best = better

    def _steps(self, point: Point) -> list[Point]:
        """Return points that differ in one value, by 1, 2, 4, ... levels."""
        found = []
        for k, count in enumerate(self.counts):
            steps = [2**power for power in range(max(count.bit_length() - 1, 1))]
            found += [self._moved(point, {k: sign * step}) for step in steps for sign in (-1, 1)]
        return found

    def _pairs(self, point: Point) -> list[Point]:
        """Return points that differ in two values by one level each; none if there are many variables."""
        free = [k for k, count in enumerate(self.counts) if count > 1]
        if len(free) > MOST_PAIRS:
            return []
        ways = product(combinations(free, 2), product((-1, 1), repeat=2))
        return [self._moved(point, {one: a, other: b}) for (one, other), (a, b) in ways]

    def _moved(self, point: Point, ways: dict[int, int]) -> Point:
        return tuple(
            min(max(value + ways.get(k, 0), 0), count - 1)
            for k, (value, count) in enumerate(zip(point, self.counts, strict=True))
        )

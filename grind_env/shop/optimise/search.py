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

from grind_env.arrays import Array
from grind_env.extras import needing

Point = tuple[int, ...]

PER_VARIABLE, LEAST_POPULATION, MOST_POPULATION = 10, 24, 120
"""Points of a generation."""
GENERATIONS = 40
STRATEGY = "randtobest1bin"
"""Found the optimum of Oracle6 with 16 seeds of 16, and SciPy's usual one with 7 of 8, both after some 2600 points."""
SETTLED = 1e-3
"""Relative spread of the costs of a generation at which it has settled."""
AT_ONCE = 64
"""Points between two looks at the clock, at most."""
MOST_PAIRS = 14
"""Variables up to which changes of two at once are tried."""
COMPARING = 0.3
"""Share of the time that a search leaves for the comparison of its best programs."""
MOST_JUDGING = 0.4
"""Share that the judgement is given at most."""
FIRST, FIRST_BESIDES = 1.5, 4.0
"""Times the budget, and s beside it, for all up to the end of the first trial; none is left without that."""
ENOUGH_TRIALS = 100
"""For which a time is named where one trial has taken all of it."""


class TimeUp(Exception):
    """The time is up in the midst of something."""


@dataclass(slots=True)
class Budget:
    """Some time of the clock, or some programs."""

    seconds: float = math.inf  # of the clock; infinite where programs are counted
    programs: float = math.inf  # that a search tries at most; a comparison has a quarter as many
    judging: float = 0.0  # time that is kept for the judgement, s
    began: float = field(default_factory=lambda: monotonic())  # reading of the clock at its begin, s

    @property
    def spent(self) -> float:
        """Return the time since the search began, s."""
        return monotonic() - self.began

    def keep(self, seconds: float) -> None:
        """Keep some time for the judgement, up to `MOST_JUDGING`."""
        self.judging = min(seconds, MOST_JUDGING * self.seconds)

    @property
    def is_search_up(self) -> bool:
        """Return whether it is time for the comparison."""
        return self.spent > (1.0 - COMPARING) * self.seconds - self.judging

    @property
    def is_comparison_up(self) -> bool:
        """Return whether it is time for the judgement."""
        return self.spent > self.seconds - self.judging

    def require_search(self) -> None:
        """Raise `TimeUp` once the time of search and comparison is up."""
        if self.is_comparison_up:
            raise TimeUp

    def require_first(self) -> None:
        """Raise it once the time of the first trial is up."""
        if self.spent > FIRST * self.seconds + FIRST_BESIDES:
            raise TimeUp


def time_said(seconds: float) -> str:
    """Return a time as --budget takes it, rounded up."""
    return f"{max(-(-seconds // 1), 1):.0f}s" if seconds <= 120.0 else f"{-(-seconds // 60):.0f}min"


@dataclass(slots=True)
class Search:
    """Evaluations so far."""

    # costs of points, shape (C, variables) -> (C,); called once for each point. `TimeUp` from it ends the search
    # without those points
    objective: Callable[[NDArray[np.int64]], Array]
    counts: Sequence[int]  # how many values each variable has
    is_up: Callable[[], bool] = lambda: False  # whether the time is up
    at_once: int = AT_ONCE  # points that the objective gets at a time, at most
    # called with the number of points after each call of the objective
    advance: Callable[[int], object] = lambda count: None
    most: float = math.inf  # points that are evaluated
    costs: dict[Point, float] = field(default_factory=dict)  # of all points evaluated
    ended_early: bool = False  # whether the time, or `most`, was up before it had ended

    @property
    def ranked(self) -> list[Point]:
        return sorted(self.costs, key=lambda point: (self.costs[point], point))

    def costs_of(self, points: Sequence[Point]) -> Array:
        """Costs of points, which are remembered."""
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
        """Return the cheapest point: from a start, whatever the time, and a grid on by evolution, then in steps."""
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
        with needing("shop", "the search needs"):
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
        """Go to the cheapest neighbour as long as there is a cheaper one; by two values only where one does not do."""
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
        """Points that differ in one value, by 1, 2, 4, ... levels."""
        found = []
        for k, count in enumerate(self.counts):
            steps = [2**power for power in range(max(count.bit_length() - 1, 1))]
            found += [self._moved(point, {k: sign * step}) for step in steps for sign in (-1, 1)]
        return found

    def _pairs(self, point: Point) -> list[Point]:
        """Points that differ in two values by one level each; none of many variables."""
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

"""Two searches for the minimum of a function, a refined grid and CMA-ES, with a cache of costs."""

import json
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from itertools import islice
from pathlib import Path
from typing import Any, NamedTuple

import cma
import numpy as np

from grind_env.files import read_text
from grind_env.policies.tuned_parameters import write_whole

#: function that returns the costs of several points, which it may evaluate together
Costs = Callable[[Sequence[Any]], Sequence[float]]

TOGETHER = 16  #: number of grid points that are evaluated together

STEPS = (1.05, 1.02, 1.01)  #: factors of the steps that refine a number, one after the other


class BestPoint(NamedTuple):
    """Best point of a search, its cost, and the number of evaluations."""

    point: Any
    cost: float
    evaluations: int


def grid_search(costs: Costs, points: Iterator[Any]) -> BestPoint:
    """Return the cheapest of the points; of equal costs, the first one."""
    found: list[tuple[float, Any]] = []
    while some := list(islice(points, TOGETHER)):
        found += zip(costs(some), some, strict=True)
    least, point = min(found, key=lambda pair: pair[0])
    return BestPoint(point, least, len(found))


def refine(cost: Callable[[float], float], start: BestPoint, low: float, high: float) -> BestPoint:
    """Move a positive number up and down by ever smaller factors while its cost falls, within `low`..`high`."""
    value, least, evaluations = start
    for step in STEPS:
        for factor in (step, 1.0 / step):
            while low <= (trial := value * factor) <= high:
                evaluations += 1
                if (trial_cost := cost(trial)) >= least:
                    break
                value, least = trial, trial_cost
    return BestPoint(value, least, evaluations)


def evolve(costs: Costs, start: Any, evaluations: int, seed: int) -> BestPoint:
    """Return the best point of CMA-ES (Hansen) from `start`, shape (n,), with an initial step of 1 in every direction.

    Non-finite costs count as the worst of their generation.
    """
    rng = np.random.default_rng(seed)
    options = {
        "maxfevals": evaluations,
        "verbose": -9,
        "seed": np.nan,  # draw from the generator below, not from numpy's global one
        "randn": lambda *shape: rng.standard_normal(shape),
    }
    strategy = cma.CMAEvolutionStrategy(np.asarray(start, np.float64), 1.0, options)
    best, least = np.asarray(start, np.float64), np.inf
    while not strategy.stop():
        points = strategy.ask()
        values = list(costs(points))
        strategy.tell(points, values)
        k = int(np.argmin(values))
        if values[k] < least:
            best, least = np.asarray(points[k]), values[k]
    return BestPoint(best, least, int(strategy.countevals))


class CachedCosts:
    """Costs of points, cached in a file: a restarted search repeats itself without new evaluations.

    Points requested together are one line of the file; a line cut short by a kill is evaluated again.
    """

    def __init__(
        self, costs: Costs, path: Path | None = None, advance: Callable[[int], object] = lambda n: None
    ) -> None:
        self.costs, self.path, self.advance = costs, path, advance
        self.known = dict[tuple[float, ...], float]()
        for line in read_text(path).splitlines() if path is not None and path.exists() else []:
            with suppress(ValueError):
                points, found = json.loads(line)
                self.known |= zip(map(tuple, points), found, strict=True)

    def __call__(self, points: Sequence[Any]) -> list[float]:
        """Return the costs at points, each shape (entries,)."""
        wanted = [tuple(float(value) for value in point) for point in points]
        if new := [k for k, point in enumerate(wanted) if point not in self.known]:
            found = self.costs([points[k] for k in new])
            self.add({wanted[k]: float(cost) for k, cost in zip(new, found, strict=True)})
        self.advance(len(wanted))
        return [self.known[point] for point in wanted]

    def add(self, found: dict[tuple[float, ...], float]) -> None:
        """Add costs to the cache, by their points."""
        self.known |= found
        if self.path is not None:
            if not self.path.exists():
                write_whole(self.path, "")
            with self.path.open("a", encoding="utf-8") as file:
                file.write(f"\n{json.dumps([[*found], [*found.values()]])}\n")

import itertools

import numpy as np
import pytest

from agents.tuning.search import BestPoint, evolve, grid_search, refine


def test_grid_search_finds_the_least_and_counts():
    found = grid_search(lambda points: [(x - 2) ** 2 + y for x, y in points], itertools.product(range(20), (3, 1)))
    assert found == ((2, 1), 1, 40)
    # of equals the first one is taken
    assert grid_search(lambda points: [0.0] * len(points), iter(range(40))).point == 0


def test_refine_finds_a_minimum_to_one_percent_and_stays_within_its_bounds():
    for least in (7.3, 12.0, 19.1):
        start = BestPoint(10.0, abs(np.log(10.0 / least)), 0)
        found = refine(lambda x, least=least: abs(np.log(x / least)), start, 1.0, 30.0)
        assert found.point == pytest.approx(least, rel=0.01)
    assert 19.0 < refine(lambda x: -x, BestPoint(10.0, -10.0, 0), 1.0, 20.0).point <= 20.0


def test_evolve_finds_a_minimum_within_its_budget_and_repeats_it():
    target = np.array([1.0, -2.0, 0.5])

    def cost(x):
        return float(((x - target) ** 2 * [1.0, 10.0, 100.0]).sum())

    def costs(points):
        return [cost(point) for point in points]

    np.random.seed(1)
    first = evolve(costs, np.zeros(3), 600, seed=3)
    np.random.seed(2)
    again = evolve(costs, np.zeros(3), 600, seed=3)
    assert first.point == pytest.approx(target, abs=1e-3)
    assert first.evaluations <= 610
    assert np.array_equal(first.point, again.point)
    assert first.cost == cost(first.point)

import numpy as np
import pytest

from agents.statistics import Interval, bootstrap, cost_per_good_part, normalised_score


def mean(x):
    return x.mean(axis=-1)


def test_cost_per_good_part_divides_the_sums():
    assert cost_per_good_part(np.array([10.0, 30.0]), np.array([4.0, 6.0])) == 4.0


@pytest.mark.parametrize(
    ("cost", "score"), [([4.0, 6.0], 0.0), ([1.0, 3.0], 100.0), ([2.5, 4.5], 50.0), ([9.0, 7.0], -100.0)]
)
def test_score_of_known_costs(cost, score):
    assert normalised_score(np.array(cost), np.array([4.0, 6.0]), np.array([1.0, 3.0])) == score


def test_score_without_a_range_is_not_a_number():
    same = np.array([2.0, 3.0])
    assert np.isnan(normalised_score(same, same, same))


def test_resampling_is_paired():
    # half-way between the anchors in every episode: any resample of the episodes scores 50
    rng = np.random.default_rng(1)
    planner, fixed = rng.exponential(2.0, 40), rng.exponential(9.0, 40) + 5.0
    interval = bootstrap(normalised_score, 0.5 * (planner + fixed), fixed, planner)
    assert interval == pytest.approx((50.0, 50.0, 50.0))


def test_the_interval_of_a_mean_is_that_of_the_normal_law():
    x = np.random.default_rng(2).normal(7.0, 3.0, 400)
    interval = bootstrap(mean, x)
    assert interval.value == x.mean()
    assert interval.half_width == pytest.approx(1.96 * x.std() / 20.0, rel=0.06)


def test_the_interval_covers_the_truth_as_often_as_it_says():
    # ratio of the sums of a skew cost (mean 3) and a share of good parts (mean 0.75): the true ratio is 4
    rng = np.random.default_rng(3)
    covered = 0
    for k in range(400):
        cost, good = rng.gamma(2.0, 1.5, 64), rng.beta(6.0, 2.0, 64)
        interval = bootstrap(cost_per_good_part, cost, good, seed=k, resamples=400)
        covered += interval.low <= 4.0 <= interval.high
    assert 0.91 <= covered / 400 <= 0.975


def test_the_same_seed_gives_the_same_interval():
    x = np.arange(20.0)
    assert bootstrap(mean, x, seed=4) == bootstrap(mean, x, seed=4)
    assert bootstrap(mean, x, seed=4) != bootstrap(mean, x, seed=5)


def test_samples_of_different_episodes_are_refused():
    with pytest.raises(ValueError, match="same episodes"):
        bootstrap(cost_per_good_part, np.ones(3), np.ones(4))


def test_half_width():
    assert Interval(1.0, 0.5, 2.5).half_width == 1.0

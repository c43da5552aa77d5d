import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from grind_env.policies import score_statistics

# runs x tasks
SCORES = np.array([[0.0, 90.0, 40.0], [20.0, 110.0, 50.0], [-20.0, 100.0, 60.0], [10.0, 95.0, 70.0]])


def mean(x):
    return x.mean(axis=-1)


def test_cost_per_good_part_divides_the_sums():
    assert score_statistics.cost_per_good_part(np.array([10.0, 30.0]), np.array([4.0, 6.0])) == 4.0


@pytest.mark.parametrize(
    ("cost", "score"), [([4.0, 6.0], 0.0), ([1.0, 3.0], 100.0), ([2.5, 4.5], 50.0), ([9.0, 7.0], -100.0)]
)
def test_score_of_known_costs(cost, score):
    assert score_statistics.normalised_score(np.array(cost), np.array([4.0, 6.0]), np.array([1.0, 3.0])) == score


def test_the_cost_without_a_good_part_is_infinite():
    none = score_statistics.bootstrap(score_statistics.cost_per_good_part, np.array([3.0, 4.0, 5.0]), np.zeros(3))
    assert none == (np.inf, np.inf, np.inf)
    # one good part in forty episodes: many resamples have none, so the upper end is infinite
    some = score_statistics.bootstrap(score_statistics.cost_per_good_part, np.ones(40), np.eye(40)[0])
    assert some.value == 40.0 and 0.0 < some.low < 40.0 and some.high == np.inf


def test_score_without_a_range_is_not_a_number():
    same = np.array([2.0, 3.0])
    assert np.isnan(score_statistics.normalised_score(same, same, same))


def test_resampling_is_paired():
    # half-way between the anchors in every episode: any resample of the episodes scores 50
    rng = np.random.default_rng(1)
    planner, fixed = rng.exponential(2.0, 40), rng.exponential(9.0, 40) + 5.0
    interval = score_statistics.bootstrap(score_statistics.normalised_score, 0.5 * (planner + fixed), fixed, planner)
    assert interval == pytest.approx((50.0, 50.0, 50.0))


def test_the_interval_of_a_mean_matches_the_normal_law():
    x = np.random.default_rng(2).normal(7.0, 3.0, 400)
    interval = score_statistics.bootstrap(mean, x)
    assert interval.value == x.mean()
    assert interval.half_width == pytest.approx(1.96 * x.std() / 20.0, rel=0.06)


def test_the_interval_covers_the_truth_at_its_confidence():
    # ratio of the sums of a skew cost (mean 3) and a share of good parts (mean 0.75): the true ratio is 4
    rng = np.random.default_rng(3)
    covered = 0
    for k in range(400):
        cost, good = rng.gamma(2.0, 1.5, 64), rng.beta(6.0, 2.0, 64)
        interval = score_statistics.bootstrap(score_statistics.cost_per_good_part, cost, good, seed=k, resamples=400)
        covered += interval.low <= 4.0 <= interval.high
    assert 0.91 <= covered / 400 <= 0.975


def test_the_same_seed_gives_the_same_interval():
    x = np.arange(20.0)
    assert score_statistics.bootstrap(mean, x, seed=4) == score_statistics.bootstrap(mean, x, seed=4)
    assert score_statistics.bootstrap(mean, x, seed=4) != score_statistics.bootstrap(mean, x, seed=5)


def test_samples_of_different_episodes_are_refused():
    with pytest.raises(ValueError, match="same episodes"):
        score_statistics.bootstrap(score_statistics.cost_per_good_part, np.ones(3), np.ones(4))


def test_aggregates_by_hand():
    # sorted: -20 0 10 | 20 40 50 60 70 90 | 95 100 110
    assert score_statistics.interquartile_mean(SCORES) == 55.0
    # means of the tasks: 2.5, 98.75, 55
    assert score_statistics.mean_score(SCORES) == pytest.approx((2.5 + 98.75 + 55.0) / 3.0)


@given(st.integers(1, 9), st.integers(1, 4), st.integers(0, 1000))
def test_the_interquartile_mean_matches_scipy(n, tasks, seed):
    rng = np.random.default_rng(seed)
    ours = rng.integers(-9, 9, (n, tasks)).astype(float)
    assert score_statistics.interquartile_mean(ours) == pytest.approx(stats.trim_mean(ours, 0.25, axis=None))


@pytest.mark.parametrize("measure", [score_statistics.interquartile_mean, score_statistics.mean_score])
def test_each_resample_is_aggregated_separately(measure):
    stack = np.stack([SCORES, SCORES + 3.0, SCORES[::-1] * 0.5])
    assert measure(stack) == pytest.approx(np.array([measure(each) for each in stack]))


def test_resampled_means_match_the_bootstrap():
    values = np.random.default_rng(5).exponential(3.0, (3, 50))
    draws = score_statistics.resampled_means(values, seed=6)
    for k in range(3):
        assert score_statistics.percentile_interval(values[k].mean(), draws[:, k]) == pytest.approx(
            score_statistics.bootstrap(mean, values[k], seed=6)
        )
    # paired: half-way between two rows in every episode
    halves = score_statistics.resampled_means(np.array([values[0], values[1], 0.5 * (values[0] + values[1])]))
    assert halves[:, 2] == pytest.approx(0.5 * (halves[:, 0] + halves[:, 1]))


def test_runs_are_drawn_within_their_task():
    draws = score_statistics.resampled_runs(np.broadcast_to(SCORES, (500, *SCORES.shape)))
    for task in range(3):
        drawn, counts = np.unique(draws[..., task], return_counts=True)
        assert drawn.tolist() == sorted(SCORES[:, task])
        # 2000 draws of four runs
        assert stats.chisquare(counts).pvalue > 1e-4
    # not the same runs in all tasks
    assert not (np.argsort(SCORES[:, 0])[0] == (draws == SCORES.min(axis=0)).argmax(axis=1)).all()


def test_the_interval_of_one_task_matches_scipy():
    runs = np.random.default_rng(8).normal(60.0, 9.0, (12, 1))
    ours = score_statistics.mean_score(score_statistics.resampled_runs(np.broadcast_to(runs, (8000, 12, 1)), seed=9))
    theirs = stats.bootstrap((runs[:, 0],), np.mean, method="percentile", n_resamples=8000, rng=10)
    interval = score_statistics.percentile_interval(float(runs.mean()), ours)
    assert (interval.low, interval.high) == pytest.approx(tuple(theirs.confidence_interval), abs=0.3)

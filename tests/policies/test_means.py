import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from grind_env.policies.learned.view import MEMORIES, RunningMeans


@given(st.lists(st.floats(-10.0, 10.0), min_size=1, max_size=30), st.integers(0, 2**32 - 1))
def test_a_mean_weighs_what_was_seen_k_blocks_ago_by_a_power_of_k(first: list[float], seed: int) -> None:
    rng = np.random.default_rng(seed)
    seen = np.stack([np.array(first), rng.normal(size=len(first))], axis=1).astype(np.float32)
    means = RunningMeans(2)
    means.begin(3)
    now = np.ones(3, bool)
    for row in seen:
        found = means.take(np.tile(row, (3, 1)), now)
    ages = np.arange(len(seen))[::-1]
    wanted = [np.average(seen, axis=0, weights=memory**ages) for memory in MEMORIES]
    assert found.dtype == np.float32
    np.testing.assert_allclose(found, np.tile(np.concatenate(wanted), (3, 1)), rtol=1e-5, atol=1e-5)


def test_episodes_begin_anew_alone_and_only_those_asked_take_in() -> None:
    means = RunningMeans(1)
    means.begin(3)
    means.take(np.full((3, 1), 4.0, np.float32), np.ones(3, bool))
    means.restart(np.array([False, True, False]))
    found = means.take(np.full((3, 1), 2.0, np.float32), np.array([True, True, False]))
    long = MEMORIES[1]
    assert found[0, 1] == np.float32((long * 4.0 + 2.0) / (long + 1.0))
    assert found[1].tolist() == [2.0, 2.0]
    assert found[2].tolist() == [4.0, 4.0]

import numpy as np

from grind_env.envs.learning import eased


def test_the_reward_of_a_learner_is_that_of_the_published_agents_to_the_bit():
    rewards = np.random.default_rng(0).normal(-3.0, 6.0, 1000).astype(np.float32)
    eased_rewards = eased(rewards)
    assert eased_rewards.dtype == np.float32 and (eased_rewards == -10.0).any()
    np.testing.assert_array_equal(eased_rewards, np.maximum(rewards + np.float32(1.0), np.float32(-10.0)))

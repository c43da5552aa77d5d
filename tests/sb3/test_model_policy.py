"""A model as a policy does what it does in its own environment, on the same episodes."""

import gymnasium as gym
import numpy as np
import pytest
from stable_baselines3 import A2C, DQN
from stable_baselines3.common.vec_env import VecNormalize

import grind_env
from grind_env.envs.wrappers import VectorBeliefFilter, VectorHistoryStack
from grind_env.errors import GrindError
from grind_env.policies.evaluation import evaluate
from grind_env.policies.problem import find_problem
from grind_env.sb3 import ModelPolicy, SB3VecEnv

FLAGSHIP = "grind/PowerLimited-v0"
SEEDS = range(2_000_000, 2_000_003)
WRAPPERS = {"bare": lambda env: env, "belief": VectorBeliefFilter, "stack": VectorHistoryStack}


def vec_env(wrap="bare", **arguments) -> SB3VecEnv:
    return SB3VecEnv(WRAPPERS[wrap](gym.make_vec(FLAGSHIP, 3, autoreset_mode="SameStep", **arguments)))


def model_of(env, seed: int = 0) -> A2C:
    return A2C("MlpPolicy", env, seed=seed, device="cpu")


@pytest.mark.parametrize(
    ("wrap", "action", "scaled"),
    [("bare", "box", True), ("belief", "multidiscrete", False), ("belief", "box", True), ("stack", "discrete", False)],
)
def test_it_costs_what_the_model_costs_in_its_own_environment(wrap, action, scaled):
    env = vec_env(wrap, action=action)
    if scaled:
        env = VecNormalize(env, norm_reward=False)
        env.obs_rms.mean += 0.1
        env.training = False
    model = model_of(env)
    found = evaluate(ModelPolicy(model), find_problem(FLAGSHIP).simulation(), SEEDS)
    env.seed(SEEDS.start)
    seen, cost, done = env.reset(), np.zeros(3), np.zeros(3, bool)
    while not done.all():
        seen, _, done, infos = env.step(model.predict(seen, deterministic=True)[0])
        cost += [info["block_cost"] for info in infos]
    np.testing.assert_allclose(found.cost, cost)


@pytest.mark.parametrize(("algorithm", "action"), [(A2C, "box"), (A2C, "multidiscrete"), (DQN, "discrete")])
def test_a_model_that_has_diverged_is_refused_in_a_sentence(algorithm, action):
    model = algorithm("MlpPolicy", vec_env(action=action), device="cpu")
    *_, last = model.policy.parameters()
    last.data.fill_(np.nan)
    with pytest.raises(GrindError, match=f"{algorithm.__name__} has weights that are no finite numbers: its training"):
        grind_env.evaluate(ModelPolicy(model), FLAGSHIP, episodes=2)


def test_judging_a_model_leaves_its_training_as_it_was():
    ends = []
    for judged in (False, True):
        model = model_of(vec_env("belief")).learn(30)
        if judged:
            evaluate(ModelPolicy(model), find_problem(FLAGSHIP).simulation(), SEEDS)
        ends.append(model.learn(30, reset_num_timesteps=False).policy.state_dict())
    assert all(np.array_equal(ends[0][name], ends[1][name]) for name in ends[0])


def test_grind_env_evaluate_takes_it():
    judged = grind_env.evaluate(ModelPolicy(model_of(vec_env()), "untrained"), FLAGSHIP, episodes=2)
    assert judged.policy == "untrained" and judged.sees == "measurements" and judged.score is not None


def test_what_it_cannot_judge_is_refused():
    with pytest.raises(GrindError, match="no environment"):
        model = model_of(vec_env())
        model.env = None
        ModelPolicy(model)
    with pytest.raises(GrindError, match="hidden state"):
        ModelPolicy(model_of(vec_env(observation="full")))
    with pytest.raises(GrindError, match="pre-dress"):
        ModelPolicy(model_of(vec_env(predress=True)))
    with pytest.raises(GrindError, match="was trained for power_limited"):
        evaluate(ModelPolicy(model_of(vec_env())), find_problem("grind/Slot-v0").simulation(), SEEDS)
    with pytest.raises(GrindError, match="trained in no environment of grind_env"):
        ModelPolicy(A2C("MlpPolicy", "CartPole-v1"))

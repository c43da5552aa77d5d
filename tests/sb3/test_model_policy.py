"""`ModelPolicy` acts like its Stable-Baselines3 model in the environment of its training."""

import gymnasium as gym
import numpy as np
import pytest
import torch
from stable_baselines3 import A2C, DQN
from stable_baselines3.common.vec_env import VecFrameStack, VecNormalize

import grind_env
from grind_env.envs.wrappers import BeliefFilter, ForLearning, VectorBeliefFilter, VectorForLearning, VectorHistoryStack
from grind_env.errors import GrindError
from grind_env.policies.evaluation import run_seeds
from grind_env.policies.problem_lookup import find_problem
from grind_env.sb3 import ModelPolicy, SB3VecEnv, load_zip, model_observations
from grind_env.task_version import TASK_VERSION
from tests.examples import nightly

FLAGSHIP = "grind/PowerLimited-v0"
SEEDS = range(2_000_000, 2_000_003)
WRAPPERS = {
    "bare": lambda env: env,
    "belief": VectorBeliefFilter,
    "stack": VectorHistoryStack,
    "learning": lambda env: VectorForLearning(VectorBeliefFilter(env)),
    "stack of beliefs": lambda env: VectorForLearning(VectorHistoryStack(VectorBeliefFilter(env), 3)),
}


def vec_env(wrap="bare", **arguments) -> SB3VecEnv:
    return SB3VecEnv(WRAPPERS[wrap](gym.make_vec(FLAGSHIP, 3, autoreset_mode="SameStep", **arguments)))


def model_of(env, seed: int = 0) -> A2C:
    return A2C("MlpPolicy", env, seed=seed, device="cpu")


@pytest.mark.parametrize(
    ("wrap", "action", "scaled"),
    [
        ("bare", "box", True),
        ("belief", "multidiscrete", False),
        nightly("belief", "box", True),
        nightly("stack", "discrete", False),
        nightly("learning", "multidiscrete", False),
        nightly("stack of beliefs", "box", False),
    ],
)
def test_model_policy_costs_the_same_as_the_model_in_its_environment(wrap, action, scaled):
    env = vec_env(wrap, action=action)
    if scaled:
        env = VecNormalize(env, norm_reward=False)
        env.obs_rms.mean += 0.1
        env.training = False
    model = model_of(env)
    found = run_seeds(ModelPolicy(model), find_problem(FLAGSHIP).simulation(), SEEDS)
    env.seed(SEEDS.start)
    seen, cost, done = env.reset(), np.zeros(3), np.zeros(3, bool)
    while not done.all():
        seen, _, done, infos = env.step(model.predict(seen, deterministic=True)[0])
        cost += [info["block_cost"] for info in infos]
    np.testing.assert_allclose(found.cost, cost)


@pytest.mark.parametrize(("algorithm", "action"), [(A2C, "box"), (A2C, "multidiscrete"), (DQN, "discrete")])
def test_a_diverged_model_is_refused(algorithm, action):
    model = algorithm("MlpPolicy", vec_env(action=action), device="cpu")
    *_, last = model.policy.parameters()
    last.data.fill_(np.nan)
    with pytest.raises(GrindError, match=f"{algorithm.__name__} has weights that are no finite numbers: its training"):
        grind_env.evaluate(ModelPolicy(model), FLAGSHIP, episodes=2)


@pytest.mark.nightly
def test_evaluating_a_model_does_not_change_its_further_training():
    ends = []
    for judged in (False, True):
        model = model_of(vec_env("belief")).learn(30)
        if judged:
            run_seeds(ModelPolicy(model), find_problem(FLAGSHIP).simulation(), SEEDS)
        ends.append(model.learn(30, reset_num_timesteps=False).policy.state_dict())
    assert all(np.array_equal(ends[0][name], ends[1][name]) for name in ends[0])


def test_grind_env_evaluate_accepts_a_model_policy():
    judged = grind_env.evaluate(ModelPolicy(model_of(vec_env()), "untrained"), FLAGSHIP, episodes=2)
    assert judged.policy == "untrained" and judged.sees == "measurements" and judged.score is not None


def test_a_model_from_an_unsuitable_environment_is_refused():
    with pytest.raises(GrindError, match="hidden state"):
        ModelPolicy(model_of(vec_env(observation="full")))
    with pytest.raises(GrindError, match="pre-dress"):
        ModelPolicy(model_of(vec_env(predress=True)))
    with pytest.raises(GrindError, match="was trained for power_limited"):
        run_seeds(ModelPolicy(model_of(vec_env())), find_problem("grind/Slot-v0").simulation(), SEEDS)
    with pytest.raises(GrindError, match="does not say what it saw: train it in an environment of grind_env"):
        ModelPolicy(A2C("MlpPolicy", "CartPole-v1"))
    with pytest.raises(GrindError, match=r"does not say what it saw.*no wrappers around the observation"):
        ModelPolicy(model_of(VecFrameStack(vec_env(), 2)))


@pytest.mark.parametrize("wrap", ["bare", nightly("belief"), nightly("stack of beliefs")])
def test_a_loaded_model_decides_like_the_saved_one(wrap, tmp_path):
    simulation = find_problem(FLAGSHIP).simulation()
    model = model_of(vec_env(wrap, action="multidiscrete"))
    with torch.no_grad():
        model.policy.action_net.weight *= 100.0
    model.save(tmp_path / "agent")
    policies = [
        ModelPolicy(model),
        ModelPolicy(A2C.load(tmp_path / "agent", device="cpu")),
        load_zip(tmp_path / "agent.zip", simulation),
    ]
    live, loaded, unzipped = (run_seeds(policy, simulation, SEEDS) for policy in policies)
    assert len(np.unique(live.speeds)) > 1
    for other in (loaded, unzipped):
        assert np.array_equal(other.speeds, live.speeds) and np.array_equal(other.executions, live.executions)


@pytest.mark.nightly
def test_a_model_trained_in_a_single_environment_can_be_loaded_and_evaluated(tmp_path):
    env = ForLearning(BeliefFilter(gym.make(FLAGSHIP, action="multidiscrete")))
    model_of(env).save(tmp_path / "agent")
    loaded = A2C.load(tmp_path / "agent", device="cpu")
    assert loaded.observation_space.shown == vec_env("learning", action="multidiscrete").observation_space.shown
    assert grind_env.evaluate(ModelPolicy(loaded), FLAGSHIP, episodes=2).score is not None


def test_a_model_without_its_vecnormalize_statistics_is_refused(tmp_path):
    env = VecNormalize(vec_env(), norm_reward=False)
    model_of(env).learn(30).save(tmp_path / "agent")
    env.save(tmp_path / "scale.pkl")
    simulation = find_problem(FLAGSHIP).simulation()
    with pytest.raises(GrindError, match=r"VecNormalize had scaled.*load it with that"):
        ModelPolicy(A2C.load(tmp_path / "agent", device="cpu"))
    with pytest.raises(GrindError, match=r"agent.zip: agent saw what a VecNormalize had scaled"):
        load_zip(tmp_path / "agent.zip", simulation)
    with_scale = A2C.load(tmp_path / "agent", env=VecNormalize.load(tmp_path / "scale.pkl", vec_env()), device="cpu")
    assert run_seeds(ModelPolicy(with_scale), simulation, SEEDS).cost.shape == (3,)


def test_a_model_file_of_another_task_or_task_version_is_refused(tmp_path, monkeypatch):
    model_of(vec_env(action="multidiscrete")).save(tmp_path / "agent")
    rush, simulation = (find_problem(name).simulation() for name in ("rush", "power_limited"))
    with pytest.raises(GrindError, match=r"agent.zip: agent was trained for power_limited, not for rush"):
        load_zip(tmp_path / "agent.zip", rush)
    monkeypatch.setattr(model_observations, "TASK_VERSION", 99)
    with pytest.raises(GrindError, match=rf"agent.zip: agent is of task version {TASK_VERSION}.*train it anew"):
        load_zip(tmp_path / "agent.zip", simulation)
    monkeypatch.undo()
    changed = find_problem("power_limited")
    monkeypatch.setattr(changed.simulation(), "entries", simulation.entries[1:])
    with pytest.raises(GrindError, match=r"another version of power_limited, with other observations"):
        load_zip(tmp_path / "agent.zip", changed.simulation())

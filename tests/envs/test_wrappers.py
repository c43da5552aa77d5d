"""Wrappers: vector and single form agree in every autoreset mode, and both keep their contract."""

import pickle
import warnings
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.envs.registration import EnvSpec
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode, SyncVectorEnv

from grind_env.belief.wheel_belief import BeliefError
from grind_env.envs.observation_memory import WrapperError
from grind_env.envs.space_metadata import ShownBox, memories_of
from grind_env.envs.wrappers import (
    BeliefFilter,
    ForLearning,
    HistoryStack,
    VectorBeliefFilter,
    VectorForLearning,
    VectorHistoryStack,
)
from grind_env.policies.evaluation import start_episodes
from grind_env.policies.problem_lookup import find_problem
from grind_env.policies.registry import make_policy
from tests.envs.contract import check_vector_env
from tests.envs.harness import IDS, actions, assert_same, native, refusal, sb3_check_env
from tests.envs.walks import Walk

OTHER_FORMS = ["grind/Job-v0", "grind/Reciprocation-v0", "grind/WidePlates-v0"]
MEASURED = {"observation": "measured", "show_block": False}


def with_belief(env_id: str) -> Any:
    return BeliefFilter(gym.make(env_id, **MEASURED), members=8)


def test_vector_and_single_history_stacks_agree() -> None:
    check_vector_env(
        lambda mode: VectorHistoryStack(SyncVectorEnv([Walk] * 3, autoreset_mode=mode), 3),
        single=lambda: HistoryStack(Walk(), 3),
        steps=30,
    )


def test_vector_and_single_belief_filters_agree() -> None:
    check_vector_env(
        lambda mode: VectorBeliefFilter(native("grind/PowerLimited-v0", 3, mode, **MEASURED), members=8),
        single=lambda: with_belief("grind/PowerLimited-v0"),
        steps=130,
    )


@pytest.mark.nightly
def test_vector_and_single_learning_wrappers_agree() -> None:
    check_vector_env(
        lambda mode: VectorForLearning(VectorBeliefFilter(native("grind/Oracle6-v0", 3, mode, **MEASURED), members=8)),
        single=lambda: ForLearning(with_belief("grind/Oracle6-v0")),
        steps=16,
    )


@pytest.mark.parametrize("env_id", [*IDS, *OTHER_FORMS])
def test_for_learning_standardises_observations_and_clips_rewards(env_id: str) -> None:
    arguments = {"num_envs": 4, "action": "multidiscrete", "autoreset_mode": "SameStep"}
    plain, easier = (gym.make_vec(env_id, **arguments) for _ in range(2))
    easier = VectorForLearning(easier)
    seen, eased = plain.reset(seed=5)[0], easier.reset(seed=5)[0]
    mean, deviation = easier.memory.mean, easier.memory.deviation
    assert easier.single_observation_space.contains(eased[0]) and eased.dtype == np.float32
    easier.action_space.seed(0)
    for _ in range(4):
        np.testing.assert_allclose(eased, np.clip((seen - mean) / deviation, -10.0, 10.0), rtol=1e-5, atol=1e-5)
        action = easier.action_space.sample()
        seen, earned, *_ = plain.step(action)
        eased, reward, *_ = easier.step(action)
        np.testing.assert_array_equal(reward, np.where(earned > -11.0, earned + 1.0, -10.0))


def test_standardised_observations_of_a_good_policy_have_about_unit_spread() -> None:
    simulation = find_problem("power_limited").simulation()
    env = VectorForLearning(gym.make_vec("grind/PowerLimited-v0", num_envs=2))
    policy, episodes, seen = make_policy("adaptive_rule", simulation), start_episodes(simulation, range(70, 80)), []
    policy.begin(simulation, 10)
    while not simulation.over(episodes).any():
        seen.append(simulation.observe(episodes))
        simulation.step(episodes, *policy.act(seen[-1], None))
    spread = np.std((np.concatenate(seen) - env.memory.mean) / env.memory.deviation, axis=0)
    assert np.all(spread > 0.2) and np.all(spread < 2.0)


def test_the_observation_space_records_its_wrappers_and_survives_pickling() -> None:
    env = VectorForLearning(VectorHistoryStack(VectorBeliefFilter(gym.make_vec("grind/Slot-v0", num_envs=2)), 3))
    shown = pickle.loads(pickle.dumps(env.single_observation_space)).shown
    assert shown == env.single_observation_space.shown and shown.task == "slot"
    assert [type(each).__name__ for each in shown.memories] == ["BeliefForm", "Stack", "Standard"]
    simulation = env.unwrapped.simulation
    space = memories_of(simulation, env.single_action_space, shown.memories)[-1].space
    assert space == env.single_observation_space and isinstance(gym.make("grind/Slot-v0").observation_space, ShownBox)


@pytest.mark.parametrize("make", [Walk, lambda: gym.make("CartPole-v1")])
def test_for_learning_refuses_foreign_environments(make: Any) -> None:
    with pytest.raises(WrapperError, match="no environment of grind_env in which E and D are chosen"):
        ForLearning(make())


def test_the_callers_options_and_info_are_left_alone() -> None:
    env = VectorHistoryStack(SyncVectorEnv([Walk] * 3, autoreset_mode=AutoresetMode.DISABLED), 2)
    env.reset(seed=0)
    options = {"reset_mask": np.array([True, False, False])}
    env.reset(options=options)
    assert list(options) == ["reset_mask"]


@pytest.mark.parametrize("wrap", [HistoryStack, BeliefFilter, lambda env: HistoryStack(BeliefFilter(env))])
@pytest.mark.parametrize("env_id", ["grind/PowerLimited-v0", "grind/Oracle6-v0"])
def test_both_checkers_pass_without_a_warning(env_id: str, wrap: Any) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        # Gymnasium warns of every wrapper
        warnings.filterwarnings("ignore", ".*is different from the unwrapped version.*")
        check_env(wrap(gym.make(env_id, **MEASURED)))
        sb3_check_env(wrap(gym.make(env_id, **MEASURED)))


def test_a_wrapped_env_can_be_made_again_from_its_spec() -> None:
    env = HistoryStack(BeliefFilter(gym.make("grind/PowerLimited-v0", **MEASURED), members=4), n=2)
    again = gym.make(EnvSpec.from_json(env.spec.to_json()))
    assert again.observation_space == env.observation_space
    assert_same(env.reset(seed=1), again.reset(seed=1))
    for action in actions(5, 1)[:, 0]:
        assert_same(env.step(action), again.step(action))


def test_the_belief_filter_refuses_foreign_environments_and_a_single_member() -> None:
    for make in (
        lambda: BeliefFilter(Walk()),
        lambda: BeliefFilter(HistoryStack(gym.make("grind/Oracle6-v0"))),
        lambda: VectorBeliefFilter(SyncVectorEnv([Walk] * 3)),
        lambda: VectorBeliefFilter(VectorHistoryStack(native("grind/Oracle6-v0", 2))),
    ):
        with pytest.raises(WrapperError, match="no grinding environment with its own observation"):
            make()
    with pytest.raises(BeliefError, match="members is 1"):
        BeliefFilter(gym.make("grind/Oracle6-v0"), members=1)


@pytest.mark.parametrize("env_id", ["grind/Reciprocation-v0", "grind/WidePlates-v0", "grind/Job-v0"])
def test_the_belief_follows_blocks_of_every_cycle(env_id: str) -> None:
    single, many = BeliefFilter(gym.make(env_id, **MEASURED)), VectorBeliefFilter(native(env_id, 2, **MEASURED))
    observations = [single.reset(seed=4)[0], many.reset(seed=[3, 4])[0][1]]
    for _ in range(2):
        np.testing.assert_array_equal(*observations)
        wear, spread = (
            observations[0][[name in entry.name for entry in single.observation_info()]]
            for name in ("belief_wear_flat", "belief_wear_flat_spread")
        )
        assert wear[0] > 0.0 and spread[0] >= 0.0
        action = np.array([0.3, 0.1], np.float32)
        observations = [single.step(action)[0], many.step(np.tile(action, (2, 1)))[0][1]]


@pytest.mark.parametrize("value", [1.5, "3", None, True, [4]])
def test_stack_length_and_number_of_members_must_be_whole_numbers(value: Any) -> None:
    for name, wrap, env in (
        ("n", HistoryStack, gym.make("grind/Oracle6-v0")),
        ("n", VectorHistoryStack, native("grind/Oracle6-v0", 2)),
        ("members", BeliefFilter, gym.make("grind/Oracle6-v0")),
        ("members", VectorBeliefFilter, native("grind/Oracle6-v0", 2)),
    ):
        assert refusal(WrapperError, wrap, env, **{name: value}) == f"{name} is {value!r}, but must be a whole number"
    HistoryStack(gym.make("grind/Oracle6-v0"), n=np.int64(2))


@pytest.mark.parametrize(
    ("single", "vector"),
    [(ForLearning, VectorForLearning), (BeliefFilter, VectorBeliefFilter), (HistoryStack, VectorHistoryStack)],
)
def test_a_wrapper_refuses_an_environment_of_the_other_form(single: Any, vector: Any) -> None:
    with pytest.raises(WrapperError, match="is no vector environment: take the wrapper without 'Vector' in its name"):
        vector(gym.make("grind/PowerLimited-v0"))
    with pytest.raises(WrapperError, match="is no single environment: take the wrapper with 'Vector' in its name"):
        single(gym.make_vec("grind/PowerLimited-v0", 2))

"""`max_episode_steps` of the vector environments acts like Gymnasium's `TimeLimit`."""

import itertools
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.envs.registration import EnvSpec
from gymnasium.wrappers import TimeAwareObservation
from gymnasium.wrappers.vector import RecordEpisodeStatistics

from grind_env import examples
from tests.envs.contract import check_vector_env
from tests.envs.harness import BLOCKS, MODES, every_id, native, quiet, sampled
from tests.examples import few

STEPS = {
    "grind/PowerLimited-v0": 3,
    "grind/Oracle6-v0": 6,  # the last step of an episode both terminates and truncates it
    "grind/JobShop-v0": 1,
    "grind/Reciprocation-v0": 2,
    "grind/WidePlates-v0": 2,
    "grind/Job-v0": 1,
}


@pytest.mark.parametrize(("env_id", "steps"), few(STEPS.items(), 2))
def test_a_limit_acts_like_time_limit_of_single_envs_in_every_mode(env_id: str, steps: int) -> None:
    options = {**quiet(env_id), "max_episode_steps": steps}
    check_vector_env(
        lambda mode: native(env_id, 2, mode, **options), single=lambda: gym.make(env_id, **options), steps=2 * steps + 2
    )


@pytest.mark.parametrize("env_id", every_id())
def test_every_id_takes_max_episode_steps_and_stores_it_in_its_spec(env_id: str) -> None:
    env = gym.make_vec(env_id, 2, max_episode_steps=1)
    twin = gym.make_vec(EnvSpec.from_json(env.spec.to_json()))
    [batch] = sampled(env_id, 1, 2)
    for each in (env, twin, gym.make_vec(env_id, 2, max_episode_steps=np.int64(1))):
        each.reset(seed=0)
        assert each.step(batch)[3].tolist() == [True, True]
    spec = gym.spec(env_id)
    parts = {name: getattr(spec, name) for name in ("id", "entry_point", "vector_entry_point", "kwargs")}
    made = gym.make_vec(EnvSpec(**parts, max_episode_steps=2), 2)
    made.reset(seed=0)
    assert not made.step(batch)[3].any()


#: ids, arguments and number of steps of an episode
LENGTHS: list[tuple[str, dict[str, Any], int]] = [
    ("grind/PowerLimited-v0", {}, BLOCKS["grind/PowerLimited-v0"]),
    ("grind/Oracle6-v0", {}, 6),
    ("grind/WidePlates-v0", {}, 16),
    ("grind/Job-v0", {"program": str(examples.path("rail_g83.nc")), "parts": 3}, 3 * 2),
]


def remade(env: gym.Env[Any, Any]) -> list[gym.Env[Any, Any]]:
    """Return environments made from the spec of one, and from the spec as JSON."""
    assert env.spec is not None
    return [gym.make(env.spec), gym.make(EnvSpec.from_json(env.spec.to_json()))]


def play(env: gym.Env[Any, Any]) -> tuple[int, bool, bool]:
    """Play a random episode within the observation space; return its steps, terminated and truncated."""
    env.action_space.seed(0)
    shown, _ = env.reset(seed=0)
    for step in itertools.count(1):
        assert env.observation_space.contains(shown)
        shown, _, terminated, truncated, _ = env.step(env.action_space.sample())
        if terminated or truncated:
            assert env.observation_space.contains(shown)
            return step, terminated, truncated


@pytest.mark.parametrize(("env_id", "arguments", "steps"), few(LENGTHS), ids=[row[0] for row in LENGTHS])
def test_a_wrapper_finds_the_episode_length_and_no_episode_is_cut_short(
    env_id: str, arguments: dict[str, Any], steps: int
) -> None:
    plain = gym.make(env_id, **arguments)
    for env in (plain, *remade(plain)):
        assert play(env) == (steps, True, False)
    for env in (*remade(TimeAwareObservation(plain)), *map(TimeAwareObservation, remade(plain))):
        assert (env.get_wrapper_attr("max_timesteps"), *play(env)) == (steps + 1, steps, True, False)
    # a limit of the user truncates and stays in the spec
    limited = gym.make(env_id, max_episode_steps=steps - 1, **arguments)
    for env in (limited, *remade(limited), gym.make(plain.spec, max_episode_steps=steps - 1)):
        assert (TimeAwareObservation(env).max_timesteps, *play(env)) == (steps - 1, steps - 1, False, True)
    name = f"{env_id.removesuffix('-v0')}-v9"
    gym.register(
        name, gym.spec(env_id).entry_point, max_episode_steps=1, kwargs={**gym.spec(env_id).kwargs, **arguments}
    )
    try:
        assert (TimeAwareObservation(gym.make(name)).max_timesteps, *play(gym.make(name))) == (1, 1, False, True)
    finally:
        del gym.registry[name]


@pytest.mark.parametrize(("env_id", "arguments", "steps"), few(LENGTHS), ids=[row[0] for row in LENGTHS])
@pytest.mark.parametrize("mode", MODES)
def test_the_spec_of_a_vector_env_has_the_length_and_cuts_no_episode_short(
    env_id: str, arguments: dict[str, Any], steps: int, mode: Any
) -> None:
    env = native(env_id, 2, mode.value, **arguments)
    made = [env, gym.make_vec(env.spec), gym.make_vec(EnvSpec.from_json(env.spec.to_json()))]
    aware = gym.make_vec(
        env_id,
        2,
        vectorization_mode="sync",
        vector_kwargs={"autoreset_mode": mode},
        wrappers=[TimeAwareObservation],
        **arguments,
    )
    for each in (*made, RecordEpisodeStatistics(env), aware):
        assert each is aware or each.spec.max_episode_steps == steps + 1
        each.action_space.seed(0)
        each.reset(seed=0)
        for step in range(1, steps + 1):
            _, _, terminated, truncated, _ = each.step(each.action_space.sample())
            assert terminated.tolist() == [step == steps] * 2
            assert not truncated.any()
    for limit in (1, steps, steps + 5):
        assert native(env_id, 2, mode, max_episode_steps=limit, **arguments).spec.max_episode_steps == limit

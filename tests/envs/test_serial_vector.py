from typing import Any

import gymnasium as gym
import numpy as np
import pytest

from grind_env.envs.actions import ActionError
from grind_env.envs.contexts import ContextError
from grind_env.errors import GrindError
from tests.envs.harness import assert_same, native

SERIAL = pytest.mark.parametrize("env_id", ["grind/Stroke-v0", "grind/Job-v0"])


@SERIAL
@pytest.mark.parametrize(
    ("form", "actions", "part"),
    [
        ("box", np.array([[0.0, 0.0], [np.nan, 0.0]]), "action 1 has nan for E"),
        ("box", np.zeros((2, 3)), "shape (2, 3)"),
        ("box", np.zeros((3, 2)), "shape (3, 2)"),
        ("box", 0.5, "shape ()"),
        ("box", None, "shape ()"),
        ("box", "fast", "numbers"),
        ("multidiscrete", [[0, 0], [24, 0]], "action 1 has 24 for E"),
        ("discrete", [0, 0.5], "action 1 has 0.5"),
        ("discrete", [0, 0, 0], "shape (3,)"),
        ("dict", {"E": [9000.0, 2999.0], "D": [0, 0]}, "action 1 has 2999 for E"),
        ("dict", {"E": [9000.0, 9000.0], "D": [0, -1]}, "action 1 has -1 for D"),
        ("dict", {"E": [9000.0, 9000.0]}, "keys E, D"),
        ("dict", [[0.0, 0.0]] * 2, "keys E, D"),
    ],
)
def test_bad_actions_move_no_env(env_id: str, form: str, actions: Any, part: str) -> None:
    env, twin = native(env_id, 2, action=form), native(env_id, 2, action=form)
    for each in (env, twin):
        each.reset(seed=1)
    with pytest.raises(ActionError) as caught:
        env.step(actions)
    assert part in str(caught.value) and "\n" not in str(caught.value)
    good = env.action_space.sample()
    assert_same(env.step(good), twin.step(good))


@SERIAL
def test_the_action_of_an_env_that_begins_anew_is_ignored(env_id: str) -> None:
    env = native(env_id, 2)
    env.reset(seed=0)
    env.unwrapped._autoreset_envs[1] = True
    stepped = env.step(np.array([[0.0, 0.0], [7.0, np.nan]], np.float32))
    assert stepped[1][1] == 0.0 and stepped[1][0] < 0.0


@SERIAL
def test_no_env_moves_before_all_have_begun(env_id: str) -> None:
    env = native(env_id, 2)
    for chosen in ([True, False], [False, True]):
        with pytest.raises(gym.error.ResetNeeded, match="some sub-environments have not begun"):
            env.step(np.zeros((2, 2), np.float32))
        assert env.reset(seed=0, options={"reset_mask": np.array(chosen)})[0] in env.observation_space
    twin = native(env_id, 2)
    twin.reset(seed=0)
    assert_same(env.step(np.zeros((2, 2), np.float32)), twin.step(np.zeros((2, 2), np.float32)))


@SERIAL
@pytest.mark.parametrize("env_seed", [[1], "a", [1.5, 2]])
def test_bad_seeds_are_refused_as_by_the_native_environments(env_id: str, env_seed: Any) -> None:
    for each in (env_id, "grind/PowerLimited-v0"):
        with pytest.raises(GrindError, match="seed is"):
            native(each, 2).reset(seed=env_seed)


@SERIAL
def test_seeds_of_numpy_are_those_of_python(env_id: str) -> None:
    first = native(env_id, 2).reset(seed=[4, 5])
    for seed in (4, np.int64(4), np.array([4, 5])):
        assert_same(native(env_id, 2).reset(seed=seed), first)


@SERIAL
@pytest.mark.parametrize("mask", [[True, False], np.array([1, 0]), np.array([True]), np.array([False, False])])
def test_bad_masks_are_refused(env_id: str, mask: Any) -> None:
    with pytest.raises(GrindError, match="reset_mask must be"):
        native(env_id, 2).reset(options={"reset_mask": mask})


@SERIAL
def test_an_episode_that_is_over_asks_for_a_reset(env_id: str) -> None:
    env = native(env_id, 2, "Disabled")
    env.reset(seed=0)
    env.unwrapped._autoreset_envs[1] = True
    with pytest.raises(gym.error.ResetNeeded, match="episode 1 is over"):
        env.step(np.zeros((2, 2), np.float32))


@pytest.mark.parametrize("env_id", ["grind/Job-v0", "grind/Wen-v0"])
def test_what_has_no_contexts_says_so(env_id: str) -> None:
    for env in (gym.make(env_id), native(env_id, 2)):
        env.reset(seed=0, options={})
        with pytest.raises(ContextError, match="no reset option 'context'"):
            env.reset(options={"context": {"kA": 2.0}})


def test_a_stroke_takes_a_context_and_a_split() -> None:
    env = gym.make("grind/Stroke-v0").unwrapped
    starts = [env.reset(seed=seed, options={"context": "nominal"})[0] for seed in (0, 1)]
    assert_same(starts[0], starts[1])
    steps = []
    for seed in (0, 1):
        env.reset(seed=seed)  # the context holds
        steps.append([env.step(np.zeros(2, np.float32)) for _ in range(20)])
    assert_same(steps[0], steps[1])
    env.reset(seed=0, options={"context": {"noise": 2.0, "stock": 0.5}})
    assert all(row.stock == pytest.approx(0.5 * env.task.kinds[0].stock) for row in env.episode.tape)
    noise = env.noise.copy()
    env.reset(seed=0, options={"context": {"noise": 1.0, "stock": 0.5}})
    np.testing.assert_allclose(noise, 2.0 * env.noise)
    with pytest.raises(ContextError, match="no factor 'ka'"):
        env.reset(options={"context": {"ka": 1.0}})
    assert env.given.fixed.noise == 1.0

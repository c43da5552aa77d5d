import copy
import itertools
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode, VectorEnv

from tests.envs.harness import (
    BLOCKS,
    IDS,
    MODES,
    Array,
    actions,
    assert_same,
    info_of,
    native,
    row_of,
    sync,
)

pytestmark = pytest.mark.bits


def masked_reset(env: VectorEnv, mask: list[bool], seed: Any = None) -> Any:
    # SyncVectorEnv takes the mask out of the dict that it is given
    return env.reset(seed=seed, options={"reset_mask": np.array(mask)})


def both(a: VectorEnv, b: VectorEnv, call: Any) -> Any:
    """The result of a call on both envs, which must be the same."""
    result = call(a)
    assert_same(result, call(b))
    return result


@pytest.mark.parametrize("observation", ["measured", "full"])
@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("env_id", IDS)
def test_native_and_sync_give_the_same_bits(env_id: str, mode: AutoresetMode, observation: str) -> None:
    n, steps = 4, 2 * BLOCKS[env_id] + 7
    # of the six combinations each id has three with the blocks shown
    kwargs = {"show_block": (observation == "full") ^ (mode == MODES[0]), "observation": observation}
    a, b = native(env_id, n, mode, **kwargs), sync(env_id, n, mode, **kwargs)
    plan = actions(steps, n)
    both(a, b, lambda env: env.reset(seed=5))
    over = np.zeros(n, bool)
    ends = np.zeros(n, int)
    for k, action in enumerate(plan):
        if k == 2:  # so that the episodes end at different steps
            both(a, b, lambda env: masked_reset(env, [False, True, False, True], [None, 77, None, None]))
        if k == 4:
            both(a, b, lambda env: masked_reset(env, [True, False, False, False]))
        if mode == AutoresetMode.DISABLED and over.any():
            mask = over.tolist()
            both(a, b, lambda env, mask=mask: masked_reset(env, mask))
        elif mode == AutoresetMode.NEXT_STEP:
            action = np.where(over[:, None], np.float32(np.nan), action)  # which must be ignored
        _, _, terminated, truncated, _ = both(a, b, lambda env, action=action: env.step(action))
        assert not truncated.any()
        over = terminated
        ends += over
    assert (ends >= 2).all() or (mode == AutoresetMode.NEXT_STEP and (ends >= 1).all())
    assert len({*a.unwrapped.episodes.block.tolist()}) == 3
    both(a, b, lambda env: env.reset(seed=[4, None, 2, 1]))
    both(a, b, lambda env: env.step(plan[0]))
    both(a, b, lambda env: env.reset())


@pytest.mark.parametrize("env_id", IDS)
def test_single_and_native_give_the_same_bits(env_id: str) -> None:
    n, blocks = 3, BLOCKS[env_id]
    plan = actions(2 * blocks, n)
    vector = native(env_id, n, AutoresetMode.DISABLED, show_block=True)
    singles = [gym.make(env_id, show_block=True) for _ in range(n)]
    for episode in range(2):
        # the second reset goes on with the generators of the first
        seed = 20 if episode == 0 else None
        observations, _ = vector.reset(seed=seed)
        for i, env in enumerate(singles):
            assert_same(env.reset(seed=None if seed is None else seed + i), (observations[i], {}))
        for action in plan[episode * blocks : (episode + 1) * blocks]:
            stepped = vector.step(action)
            for i, env in enumerate(singles):
                assert_same(row_of(stepped, i), env.step(action[i]))


def test_same_step_hands_out_the_last_observation_and_info_of_the_episode() -> None:
    same = native("grind/PowerLimited-v0", 2, AutoresetMode.SAME_STEP)
    single = gym.make("grind/PowerLimited-v0", show_block=False)
    same.reset(seed=[9, 10])
    single.reset(seed=9)
    for action in actions(60, 2):
        observations, rewards, terminated, _, info = same.step(action)
        observation, reward, _, _, single_info = single.step(action[0])
    assert terminated.all()
    assert_same(info["final_obs"][0], observation)
    assert_same(info_of(info["final_info"], 0), single_info)
    assert float(rewards[0]) == reward
    assert_same(observations[0], single.reset()[0])


def garbage(value: Any) -> None:
    """Overwrite everything in a result, as a careless caller may."""
    if isinstance(value, dict):
        for each in value.values():
            garbage(each)
    elif isinstance(value, tuple):
        for each in value:
            garbage(each)
    elif isinstance(value, np.ndarray) and value.dtype == object:
        for each in value:
            garbage(each)
        value[:] = None
    elif isinstance(value, np.ndarray):
        value[...] = value == 0


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("make", [native, sync])
def test_results_belong_to_the_caller(make: Any, mode: AutoresetMode) -> None:
    spoilt, twin = (make("grind/Oracle6-v0", 3, mode, show_block=True) for _ in range(2))
    over: Array = np.zeros(3, bool)
    results = [(spoilt.reset(seed=1), twin.reset(seed=1))]
    for k, action in enumerate(actions(20, 3)):
        if k == 2:
            masked_reset(spoilt, [False, True, False])
            masked_reset(twin, [False, True, False])
        if mode == AutoresetMode.DISABLED and over.any():
            mask = over.tolist()
            results.append((masked_reset(spoilt, mask), masked_reset(twin, mask)))
        results.append((spoilt.step(action.copy()), twin.step(action)))
        assert_same(*results[-1])
        over = results[-1][0][2].copy()
        garbage(results[-1][0])


def arrays(value: Any) -> list[Array]:
    if isinstance(value, np.ndarray):
        return [value, *(part for each in value if value.dtype == object for part in arrays(each))]
    parts = value.values() if isinstance(value, dict) else value if isinstance(value, tuple) else ()
    return [array for part in parts for array in arrays(part)]


@pytest.mark.parametrize("mode", MODES)
def test_no_two_arrays_of_a_result_share_memory(mode: AutoresetMode) -> None:
    env = native("grind/Oracle6-v0", 2, mode, show_block=True)
    env.reset(seed=1)
    masked_reset(env, [True, False])
    env.step(np.zeros((2, 2)))
    masked_reset(env, [True, False])
    for _ in range(5):
        result = env.step(np.zeros((2, 2)))
    assert result[2].tolist() == [False, True]
    found = arrays(result)
    assert len(found) > 20
    assert not any(np.shares_memory(a, b) for a, b in itertools.combinations(found, 2))


@pytest.mark.parametrize("mode", MODES)
def test_old_results_keep_their_values(mode: AutoresetMode) -> None:
    env = native("grind/Oracle6-v0", 3, mode, show_block=True)
    kept = [env.reset(seed=1)]
    copies = copy.deepcopy(kept)
    for action in actions(20, 3):
        if mode == AutoresetMode.DISABLED and len(kept) > 1 and kept[-1][2].any():
            masked_reset(env, kept[-1][2].tolist())
        kept.append(env.step(action))
        copies.append(copy.deepcopy(kept[-1]))
    assert_same(kept, copies)

"""Vector environments against Gymnasium's `SyncVectorEnv` of their single form: equal calls give equal bits."""

from collections.abc import Callable
from copy import deepcopy
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.vector import AutoresetMode, SyncVectorEnv, VectorEnv
from gymnasium.vector.utils import batch_space, concatenate, create_empty_array, iterate

from tests.envs.harness import Array, assert_same


def check_vector_env(make: Callable[[AutoresetMode], VectorEnv], single: Callable[[], gym.Env], steps: int) -> None:
    """Compare every call in every autoreset mode; every episode, also a restarted one, must end within `steps`."""
    for mode in AutoresetMode:
        env = make(mode)
        sync = SyncVectorEnv([single] * env.num_envs, autoreset_mode=mode)
        for other in AutoresetMode:
            make(other)
        assert env.metadata["autoreset_mode"] is mode
        for name in ("observation_space", "action_space"):
            assert getattr(env, f"single_{name}") == getattr(single(), name)
            assert getattr(env, name) == batch_space(getattr(env, f"single_{name}"), env.num_envs)
        Comparison(env, sync, mode).play(steps)
        env.close()
        env.close()


class Comparison:
    """Caller of both environments; it overwrites every other result, and the rest must keep their values."""

    def __init__(self, env: VectorEnv, sync: SyncVectorEnv, mode: AutoresetMode) -> None:
        self.env, self.sync, self.mode = env, sync, mode
        self.kept: list[tuple[Any, Any]] = []
        self.over = np.zeros(env.num_envs, bool)
        env.action_space.seed(0)

    def both(self, call: Callable[[Any], Any], other: Callable[[Any], Any] | None = None) -> Any:
        """Return a copy of the result of a call, which must be the same in both environments."""
        result = call(self.env)
        copy = deepcopy(result)
        assert_same((other or call)(self.sync), copy)
        if len(self.kept) % 2:
            overwrite(result)
        self.kept.append((result, copy))
        return copy

    def reset(self, mask: Array, first: int | None = None) -> None:
        """Reset some episodes, with seeds or with the random state as it is."""
        seeds = None if first is None else [first + i if chosen else None for i, chosen in enumerate(mask)]
        self.both(lambda env: env.reset(seed=seeds, options={"reset_mask": mask.copy()}))
        self.over &= ~mask

    def step(self) -> None:
        """Take random actions; where a step only resets, the two environments get different ones."""
        space, one = self.env.action_space, self.env.single_action_space
        drawn, unlike = (list(iterate(space, space.sample())) for _ in range(2))
        idle = self.over & (self.mode is AutoresetMode.NEXT_STEP)
        other = [unlike[i] if idle[i] else each for i, each in enumerate(drawn)]
        actions, others = (concatenate(one, rows, create_empty_array(one, len(rows))) for rows in (drawn, other))
        before = deepcopy(actions)
        result = self.both(lambda env: env.step(actions), lambda env: env.step(others))
        assert_same(actions, before)
        self.over = result[2] | result[3]

    def play(self, steps: int) -> None:
        """Play with resets by the caller before, at and after an end."""
        count = self.env.num_envs
        ended = np.zeros(count, bool)
        begun = [lambda: self.reset(~self.over, 99), lambda: self.reset(self.over.copy(), 50)]
        self.both(lambda env: env.reset(seed=5))
        for k in range(steps):
            if k == 2:  # so that the episodes end at different steps
                self.reset(np.arange(count) == count - 1, 77)
            if begun and self.over.any() and not self.over.all():
                begun.pop(0)()
            if self.mode is AutoresetMode.DISABLED and self.over.any():
                self.reset(self.over.copy())
            self.step()
            ended |= self.over
        assert ended.all(), "an episode has not ended"
        self.both(lambda env: env.reset(seed=[4, *[None] * (count - 1)]))
        self.over[:] = False
        self.step()
        self.both(lambda env: env.reset())
        for result, copy in self.kept[::2]:
            assert_same(result, copy)


def overwrite(value: Any) -> None:
    """Overwrite everything in a result, as a careless caller may."""
    if isinstance(value, np.ndarray) and value.dtype != object:
        value[...] = value == 0
    elif isinstance(value, dict | tuple | np.ndarray):
        for each in value.values() if isinstance(value, dict) else value:
            overwrite(each)

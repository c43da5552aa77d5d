"""Vector environments of single ones that run one after the other."""

import copy
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.vector import AutoresetMode, SyncVectorEnv
from numpy.typing import ArrayLike, NDArray

from grind_env.envs.actions import ActionError
from grind_env.envs.choice import Choice
from grind_env.envs.tasks import TaskError
from grind_env.envs.vector_env import autoreset, reset_mask, seed_list

Single = gym.Env[NDArray[np.float32], NDArray[np.float32]]


class SerialVectorEnv(SyncVectorEnv):
    """Copies of one environment in gymnasium's `SyncVectorEnv`: a step takes as long as all of theirs together.

    Args:
        env: the first of them, not yet begun.
        decode: the choice of an action, or an `ActionError`.
        num_envs: number of sub-environments.
        autoreset_mode: `AutoresetMode` or its value: `"NextStep"`, `"SameStep"` or `"Disabled"`.

    Raises:
        TaskError: there is no such mode, or `num_envs` is below 1.
    """

    def __init__(
        self,
        env: Single,
        decode: Callable[[ArrayLike], Choice],
        num_envs: int,
        autoreset_mode: AutoresetMode | str,
    ) -> None:
        if num_envs < 1:
            raise TaskError(f"num_envs is {num_envs}, but must be at least 1")
        envs = [env, *(copy.deepcopy(env) for _ in range(num_envs - 1))]
        super().__init__([partial(_itself, each) for each in envs], autoreset_mode=autoreset(autoreset_mode))
        self._decode = decode

    def reset(self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None) -> Any:
        """Start episodes: all, or those in `options["reset_mask"]`, bool of shape (num_envs,).

        Raises:
            GrindError: if the seeds or the options do not fit the sub-environments.
        """
        seeds = seed_list(seed, self.num_envs)
        reset_mask(options, self.num_envs)
        # a copy: gymnasium takes the mask out of the dict, which wrappers look into afterwards
        return super().reset(seed=seeds, options=None if options is None else dict(options))

    def step(self, actions: Any) -> Any:
        """Step every sub-environment.

        Raises:
            gymnasium.error.ResetNeeded: a sub-environment has not begun; without autoreset, its episode is over.
            ActionError: the actions are not one for each sub-environment, or one is not in the action space.
        """
        if self.autoreset_mode == AutoresetMode.DISABLED and self._autoreset_envs.any():
            over = np.flatnonzero(self._autoreset_envs)[0]
            raise gym.error.ResetNeeded(f"episode {over} is over: reset it with options={{'reset_mask': ...}}")
        try:
            count = len(actions)
        except TypeError:
            raise ActionError(f"actions are {actions!r}, but must be {self.num_envs}: one for each env") from None
        if count != self.num_envs:
            raise ActionError(f"there are {count} actions, but must be {self.num_envs}: one for each env")
        self._check(actions)
        return super().step(actions)

    def _check(self, actions: Any) -> None:
        """Decode all actions before the first env moves; that of an env which begins anew is ignored."""
        ignored = self._autoreset_envs if self.autoreset_mode == AutoresetMode.NEXT_STEP else ()
        for i, action in enumerate(actions):
            if len(ignored) and ignored[i]:
                continue
            try:
                self._decode(action)
            except ActionError as error:
                raise ActionError(f"env {i}: {error}") from None


def _itself(env: Single) -> Single:
    return env

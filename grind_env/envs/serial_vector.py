"""Vector environments of single ones that run one after the other."""

import copy
from functools import partial
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.vector import AutoresetMode, SyncVectorEnv
from numpy.typing import NDArray

from grind_env.envs.actions import ActionError
from grind_env.envs.tasks import TaskError
from grind_env.envs.vector_env import autoreset

Single = gym.Env[NDArray[np.float32], NDArray[np.float32]]


class SerialVectorEnv(SyncVectorEnv):
    """Copies of one environment in gymnasium's `SyncVectorEnv`: a step takes as long as all of theirs together.

    Args:
        env: the first of them, not yet begun.
        num_envs: number of sub-environments.
        autoreset_mode: `AutoresetMode` or its value: `"NextStep"`, `"SameStep"` or `"Disabled"`.

    Raises:
        TaskError: there is no such mode, or `num_envs` is below 1.
    """

    def __init__(self, env: Single, num_envs: int, autoreset_mode: AutoresetMode | str) -> None:
        if num_envs < 1:
            raise TaskError(f"num_envs is {num_envs}, but must be at least 1")
        envs = [env, *(copy.deepcopy(env) for _ in range(num_envs - 1))]
        super().__init__([partial(_itself, each) for each in envs], autoreset_mode=autoreset(autoreset_mode))

    def reset(self, *, seed: Any = None, options: dict[str, Any] | None = None) -> Any:
        """Start episodes: all, or those in `options["reset_mask"]`, bool of shape (num_envs,)."""
        # a copy: gymnasium takes the mask out of the dict, which wrappers look into afterwards
        return super().reset(seed=seed, options=None if options is None else dict(options))

    def step(self, actions: Any) -> Any:
        """Step every sub-environment.

        Raises:
            gymnasium.error.ResetNeeded: a sub-environment has not begun; without autoreset, its episode is over.
            ActionError: the actions are not one for each sub-environment, or one is not in the action space.
        """
        if len(actions) != self.num_envs:
            raise ActionError(f"there are {len(actions)} actions, but must be {self.num_envs}: one for each env")
        return super().step(actions)


def _itself(env: Single) -> Single:
    return env

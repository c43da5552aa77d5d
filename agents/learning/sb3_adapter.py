"""Stable-Baselines3's VecEnv over the native vector environment.

SB3 resets within the step in which an episode ends, and wants a list of info dicts with the last observation of
each finished episode; a Gymnasium VectorEnv in SAME_STEP mode holds the same in arrays.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode
from numpy.typing import NDArray
from stable_baselines3.common.vec_env import VecEnv
from stable_baselines3.common.vec_env.base_vec_env import VecEnvIndices, VecEnvObs, VecEnvStepReturn

from grind_env.envs.vector_env import GrindVectorEnv
from grind_env.errors import GrindError


def alike(options: Sequence[dict[str, Any]]) -> list[tuple[dict[str, Any], NDArray[np.bool_]]]:
    """Environments with equal reset options: these options, and which they are, bool of shape (N,)."""
    found: list[tuple[dict[str, Any], NDArray[np.bool_]]] = []
    for i, each in enumerate(options):
        for known, mask in found:
            if known == each:
                mask[i] = True
                break
        else:
            found.append((each, np.arange(len(options)) == i))
    return found


class SB3VecEnv(VecEnv):
    """`GrindVectorEnv` for Stable-Baselines3.

    Args:
        env: a vector environment in SAME_STEP mode.

    Raises:
        GrindError: if the environment is in another autoreset mode.
    """

    def __init__(self, env: GrindVectorEnv) -> None:
        if env.autoreset_mode != AutoresetMode.SAME_STEP:
            raise GrindError(
                f"the env has autoreset mode {env.autoreset_mode.value!r}, but Stable-Baselines3 needs"
                " autoreset_mode='SameStep'"
            )
        self.env = env
        super().__init__(env.num_envs, env.single_observation_space, env.single_action_space)

    def reset(self) -> VecEnvObs:
        """Start an episode in every environment, with the last `seed()` and `set_options()`."""
        seeds = self._seeds if any(seed is not None for seed in self._seeds) else None
        for options, mask in alike(self._options):
            observations, _ = self.env.reset(seed=seeds, options={**options, "reset_mask": mask})
        self.reset_infos = [{} for _ in range(self.num_envs)]
        self._reset_seeds()
        self._reset_options()
        return np.asarray(observations)

    def step_async(self, actions: NDArray[Any]) -> None:
        """Keep the actions for `step_wait`."""
        self._actions = actions

    def step_wait(self) -> VecEnvStepReturn:
        """Step; infos are empty but for episodes that end, which carry `terminal_observation`."""
        observations, rewards, terminated, truncated, info = self.env.step(self._actions)
        done = terminated | truncated
        infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        for i in np.flatnonzero(done):
            infos[i] = {
                "terminal_observation": info["final_obs"][i],
                "TimeLimit.truncated": bool(truncated[i] and not terminated[i]),
            }
        return observations, rewards.astype(np.float32), done, infos

    def close(self) -> None:
        """Close the environment."""
        self.env.close()

    def get_attr(self, attr_name: str, indices: VecEnvIndices = None) -> list[Any]:
        """The attribute of the vector environment, once for each index."""
        return [getattr(self.env, attr_name)] * len(list(self._get_indices(indices)))

    def set_attr(self, attr_name: str, value: Any, indices: VecEnvIndices = None) -> None:
        """Refused: the environments share their attributes."""
        raise GrindError(f"{attr_name} cannot be set for single environments: make the env with it instead")

    def env_method(
        self, method_name: str, *method_args: Any, indices: VecEnvIndices = None, **method_kwargs: Any
    ) -> list[Any]:
        """Call a method of the vector environment once, and return its result for each index."""
        result = getattr(self.env, method_name)(*method_args, **method_kwargs)
        return [result] * len(list(self._get_indices(indices)))

    def env_is_wrapped(self, wrapper_class: type[Any], indices: VecEnvIndices = None) -> list[bool]:
        """False for each index: the native environment has no single wrappers."""
        return [False] * len(list(self._get_indices(indices)))

    def get_images(self) -> Sequence[NDArray[np.uint8] | None]:
        """No images: the vector environment does not render."""
        return [None] * self.num_envs

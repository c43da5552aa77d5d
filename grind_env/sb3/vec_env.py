"""Stable-Baselines3's VecEnv over a Gymnasium VectorEnv.

SB3 resets within the step in which an episode ends, and wants a list of info dicts with the last observation of
each finished episode; a Gymnasium VectorEnv in SAME_STEP mode holds the same in arrays.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv, VectorWrapper
from numpy.typing import NDArray
from stable_baselines3.common.vec_env import VecEnv
from stable_baselines3.common.vec_env.base_vec_env import VecEnvIndices, VecEnvObs, VecEnvStepReturn

from grind_env.errors import GrindError

AnyVectorEnv = VectorEnv[Any, Any, Any]
#: key of an info under which `RecordEpisodeStatistics` and SB3's `Monitor` write return and length of an episode
EPISODE = "episode"


def alike(options: Sequence[dict[str, Any]]) -> list[tuple[dict[str, Any], NDArray[np.bool_]]]:
    """Return the distinct reset options, each with the mask of its environments, bool of shape (N,)."""
    found: list[tuple[dict[str, Any], NDArray[np.bool_]]] = []
    for i, each in enumerate(options):
        for known, mask in found:
            if known == each:
                mask[i] = True
                break
        else:
            found.append((each, np.arange(len(options)) == i))
    return found


def single_infos(info: dict[str, Any], n: int) -> list[dict[str, Any]]:
    """Return the info of each of N environments from a VectorEnv's arrays, with masks under names with a `_`.

    `DictInfoToList` of Gymnasium does the same with NumPy scalars, in nearly twice the time.
    """
    found: list[dict[str, Any]] = [{} for _ in range(n)]
    for name, values in info.items():
        if name.startswith("_"):
            continue
        if isinstance(values, dict):
            rows = single_infos(values, n)
        else:
            rows = values.tolist() if values.ndim == 1 else list(values)
        mask = info.get(f"_{name}", np.ones(n, bool))
        for each, row, present in zip(found, rows, mask.tolist(), strict=True):
            if present:
                each[name] = row
    return found


class SB3VecEnv(VecEnv):
    """A vector environment for Stable-Baselines3, with the same results as `DummyVecEnv` of single environments.

    Args:
        env: a vector environment in SAME_STEP mode, wrapped or not.

    Raises:
        GrindError: if the environment is in another autoreset mode.
    """

    def __init__(self, env: AnyVectorEnv) -> None:
        mode = env.metadata.get("autoreset_mode")
        if mode != AutoresetMode.SAME_STEP:
            raise GrindError(
                f"the env has {mode or 'no autoreset mode'}, but Stable-Baselines3 needs autoreset_mode='SameStep'"
            )
        self.env = env
        super().__init__(env.num_envs, env.single_observation_space, env.single_action_space)
        self.metadata = env.metadata  # SB3's recorder reads the frame rate

    def reset(self) -> VecEnvObs:
        """Start an episode in every environment, with the last `seed()` and `set_options()`."""
        # Gymnasium's types allow a single seed only; its vector environments also take a list of seeds
        seeds: Any = self._seeds if any(seed is not None for seed in self._seeds) else None
        for options, mask in alike(self._options):
            observations, info = self.env.reset(seed=seeds, options={**options, "reset_mask": mask})
            infos = single_infos(info, self.num_envs)
            self.reset_infos = [infos[i] if mask[i] else self.reset_infos[i] for i in range(self.num_envs)]
        self._reset_seeds()
        self._reset_options()
        return np.asarray(observations)

    def step_async(self, actions: NDArray[Any]) -> None:
        """Store the actions for `step_wait`."""
        self._actions = actions

    def step_wait(self) -> VecEnvStepReturn:
        """Step; the info of an episode that ends has `terminal_observation`."""
        observations, rewards, terminated, truncated, info = self.env.step(self._actions)
        infos = single_infos(info, self.num_envs)
        done = terminated | truncated
        for i in np.flatnonzero(done):
            final, last = infos[i].pop("final_info"), infos[i].pop("final_obs")
            # a wrapper of Gymnasium puts the statistics of the finished episode into the info of the reset
            statistics = {EPISODE: infos[i].pop(EPISODE)} if EPISODE in infos[i] else {}
            self.reset_infos[i], infos[i] = infos[i], {**final, **statistics, "terminal_observation": last}
        for each, cut in zip(infos, (truncated & ~terminated).tolist(), strict=True):
            each["TimeLimit.truncated"] = cut
        return observations, rewards.astype(np.float32), done, infos

    def close(self) -> None:
        """Close the environment."""
        self.env.close()

    def get_attr(self, attr_name: str, indices: VecEnvIndices = None) -> list[Any]:
        """Return an attribute of the vector environment, or of one that it wraps, once for each index."""
        return [getattr(self._owner(attr_name), attr_name)] * len(list(self._get_indices(indices)))

    def set_attr(self, attr_name: str, value: Any, indices: VecEnvIndices = None) -> None:
        """Raise an error: the environments share their attributes.

        Raises:
            GrindError: always.
        """
        raise GrindError(f"{attr_name} cannot be set for single environments: make the env with it instead")

    def env_method(
        self, method_name: str, *method_args: Any, indices: VecEnvIndices = None, **method_kwargs: Any
    ) -> list[Any]:
        """Call a method of the vector environment, or of one that it wraps, and return the result for each index."""
        result = getattr(self._owner(method_name), method_name)(*method_args, **method_kwargs)
        return [result] * len(list(self._get_indices(indices)))

    def env_is_wrapped(self, wrapper_class: type[Any], indices: VecEnvIndices = None) -> list[bool]:
        """Return False for each index: wrappers are around all environments at once."""
        return [False] * len(list(self._get_indices(indices)))

    def get_images(self) -> Sequence[NDArray[np.uint8] | None]:
        """Return the picture of each environment; None for each without `render_mode="rgb_array"`."""
        if self.render_mode != "rgb_array":
            return [None] * self.num_envs
        pictures: Any = self.env.render()  # Gymnasium's types allow texts, too
        return list(pictures)

    def _owner(self, name: str) -> AnyVectorEnv:
        """Return the outermost environment that has this attribute, or else the innermost one."""
        env = self.env
        while isinstance(env, VectorWrapper) and not hasattr(env, name):
            env = env.env
        return env

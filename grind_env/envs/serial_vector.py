"""Vector environments of single ones that run one after the other."""

import copy
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any, Generic, TypeVar

import gymnasium as gym
import numpy as np
from gymnasium.vector import AutoresetMode, SyncVectorEnv
from gymnasium.wrappers import TimeLimit
from numpy.typing import NDArray

from grind_env.envs.actions import ActionCodec
from grind_env.envs.arguments import check_count, check_steps
from grind_env.envs.vector_common import (
    VECTOR_RENDER_MODES,
    autoreset,
    beside_mask,
    refuse_out_of_turn,
    reset_mask,
    seed_list,
)
from grind_env.errors import GrindError

Single = TypeVar("Single", bound=gym.Env[NDArray[np.float32], Any])


class SerialVectorEnv(SyncVectorEnv, Generic[Single]):
    """Copies of one environment in gymnasium's `SyncVectorEnv`: a step takes as long as all of theirs together.

    Args:
        env: the first of them, not yet begun.
        codec: its actions.
        num_envs: number of sub-environments.
        autoreset_mode: `AutoresetMode` or its value: `"NextStep"`, `"SameStep"` or `"Disabled"`.
        max_episode_steps: steps after which an episode is truncated, as by `TimeLimit`; None for never.

    Raises:
        TaskError: there is no such mode, or `num_envs` or `max_episode_steps` is below 1.
    """

    def __init__(
        self,
        env: Single,
        codec: ActionCodec,
        num_envs: int,
        autoreset_mode: AutoresetMode | str,
        max_episode_steps: int | None,
    ) -> None:
        steps = check_steps(max_episode_steps)
        self.singles = [env, *(copy.deepcopy(env) for _ in range(check_count(num_envs) - 1))]
        super().__init__(
            [partial(_limited, each, steps) for each in self.singles], autoreset_mode=autoreset(autoreset_mode)
        )
        self.metadata["render_modes"] = [*VECTOR_RENDER_MODES]
        self.codec = codec
        self.begun = np.zeros(num_envs, bool)
        # gymnasium has none for an env that the first reset leaves out
        self._env_obs = list(self._observations.copy())

    def reset(self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None) -> Any:
        """Start episodes: all, or those in `options["reset_mask"]`, bool of shape (num_envs,).

        Args:
            seed: of the generators, which else go on.
            options: beside the mask those of the single environment; a list has one entry for each sub-environment.

        Raises:
            GrindError: if the seeds or the options do not fit the sub-environments; none has then begun anew.
        """
        seeds = seed_list(seed, self.num_envs)
        mask = reset_mask(options, self.num_envs)
        self.give(beside_mask(options), mask)
        # a dict of its own: gymnasium takes the mask out of it, and wrappers look into that of the user afterwards
        begin = super().reset(seed=seeds, options={"reset_mask": mask})
        self.begun |= mask
        return begin

    def give(self, options: Mapping[str, Any], mask: NDArray[np.bool_]) -> None:
        """Give the episodes that start what the options of a reset say.

        Args:
            options: without the mask.
            mask: which start, shape (num_envs,).

        Raises:
            GrindError: if an option is not legal; nothing has then been given.
        """
        raise NotImplementedError

    def keep(self) -> Callable[[], None]:
        """Return a function that undoes a failed step; a subclass whose environments can fail must undo those too."""
        before = list(self._env_obs)
        # a limit counts what it has stepped; the environments within stay the same
        envs = [copy.copy(env) if isinstance(env, TimeLimit) else env for env in self.envs]

        def take_back() -> None:
            self._env_obs, self.envs = before, envs

        return take_back

    def step(self, actions: Any) -> Any:
        """Step every sub-environment, or none if one cannot be stepped.

        Raises:
            gymnasium.error.ResetNeeded: a sub-environment has not begun; without autoreset, its episode is over.
            ActionError: the actions are not one for each sub-environment, or one is not in the action space.
            GrindError: the control or the machine refuses a block; nothing has then been ground.
        """
        refuse_out_of_turn(bool(self.begun.all()), self._autoreset_envs, self.autoreset_mode)
        values = self.codec.table(actions, self.num_envs)
        if self.autoreset_mode == AutoresetMode.NEXT_STEP:
            # the action of an episode that is over is ignored, and it begins anew
            values = np.where(self._autoreset_envs[:, None], self.codec.neutral, values)
        self.codec.choose(values)
        take_back = self.keep()
        try:
            return super().step(actions)
        except GrindError:
            take_back()
            raise


def _limited(env: Single, steps: int | None) -> gym.Env[NDArray[np.float32], Any]:
    return env if steps is None else TimeLimit(env, steps)

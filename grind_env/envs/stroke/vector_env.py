"""`grind/Stroke-v0`, many times side by side."""

from collections.abc import Mapping
from functools import partial
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode
from numpy.typing import NDArray

from grind_env.envs.arguments import refuse_render
from grind_env.envs.contexts import read_all_options, read_options
from grind_env.envs.serial_vector import SerialVectorEnv
from grind_env.envs.stroke.env import StrokeEnv
from grind_env.envs.vector_common import VECTOR_RENDER_MODES


class StrokeVectorEnv(SerialVectorEnv[StrokeEnv]):
    """N times `StrokeEnv`, one after the other (gymnasium's `SyncVectorEnv`), not a native vector environment.

    Args:
        num_envs: number of sub-environments.
        observation: `"measured"` or `"full"`.
        show_block: put the blocks that led to the strokes into `info["block"]`.
        action: form of the action: `"box"`, `"multidiscrete"`, `"discrete"` or `"dict"`.
        predress: False, as for `StrokeEnv`.
        autoreset_mode: `AutoresetMode` or its value: `"NextStep"`, `"SameStep"` or `"Disabled"`.
        render_mode: as for `GrindVectorEnv`.
        cycle: None, as for `StrokeEnv`.
        max_episode_steps: as for `GrindVectorEnv`.
    """

    def __init__(
        self,
        num_envs: int = 1,
        observation: str = "measured",
        show_block: bool = False,
        action: str = "box",
        predress: bool = False,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        render_mode: str | None = None,
        cycle: str | None = None,
        max_episode_steps: int | None = None,
    ) -> None:
        refuse_render(render_mode, VECTOR_RENDER_MODES)
        env = StrokeEnv(observation, show_block, action, predress, render_mode, cycle)
        super().__init__(env, env.codec, num_envs, autoreset_mode, max_episode_steps)

    def give(self, options: Mapping[str, Any], mask: NDArray[np.bool_]) -> None:
        """Give the episodes that start their contexts and splits, see `grind_env.envs.contexts`.

        Raises:
            ContextError: if an option is not legal.
        """
        given = read_all_options(
            options, [env.given for env in self.singles], partial(read_options, self.singles[0].task)
        )
        for i in np.flatnonzero(mask).tolist():
            self.singles[i].given = given[i]

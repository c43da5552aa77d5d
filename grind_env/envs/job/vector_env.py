"""`grind/Job-v0`, many times side by side."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode
from numpy.typing import NDArray

from grind_env.envs.arguments import refuse_render
from grind_env.envs.contexts import read_all_options
from grind_env.envs.job.env import JobEnv
from grind_env.envs.serial_vector import SerialVectorEnv
from grind_env.envs.vector_common import VECTOR_RENDER_MODES


class JobVectorEnv(SerialVectorEnv[JobEnv]):
    """N times `JobEnv`, one after the other (gymnasium's `SyncVectorEnv`): the control is no compiled code.

    Args:
        program: file of the part program; the example plate if not given.
        job: its job file; the program's name with `.toml` if not given.
        num_envs: number of sub-environments.
        observation: `"measured"` or `"full"`.
        spread: factor on all that is random.
        show_block: put the text of the blocks that were run into `info["block"]`.
        action: form of the action: `"box"`, `"multidiscrete"`, `"discrete"` or `"dict"`.
        predress: False, as for `JobEnv`.
        autoreset_mode: `AutoresetMode` or its value: `"NextStep"`, `"SameStep"` or `"Disabled"`.
        render_mode: as for `GrindVectorEnv`.
        cycle: None, as for `JobEnv`.
        max_episode_steps: as for `GrindVectorEnv`.
    """

    def __init__(
        self,
        program: str | None = None,
        job: str | None = None,
        num_envs: int = 1,
        observation: str = "measured",
        spread: float = 1.0,
        show_block: bool = False,
        action: str = "box",
        predress: bool = False,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        render_mode: str | None = None,
        cycle: str | None = None,
        max_episode_steps: int | None = None,
    ) -> None:
        refuse_render(render_mode, VECTOR_RENDER_MODES)
        env = JobEnv(program, job, observation, spread, show_block, action, predress, render_mode, cycle)
        super().__init__(env, env.codec, num_envs, autoreset_mode, max_episode_steps)

    def give(self, options: Mapping[str, Any], mask: NDArray[np.bool_]) -> None:
        """Give the episodes that start their contexts and splits, see `grind_env.envs.contexts`.

        Raises:
            ContextError: if an option is not legal.
        """
        given = read_all_options(options, [env.given for env in self.singles], self.singles[0].read_given)
        for i in np.flatnonzero(mask).tolist():
            self.singles[i].given = given[i]

    def keep(self) -> Callable[[], None]:
        """Return a function that undoes a failed step."""
        each = [super().keep(), *(env.keep() for env in self.singles)]

        def take_back() -> None:
            for one in each:
                one()

        return take_back

"""`grind/WidePlates-v0`, many times side by side."""

from gymnasium.vector import AutoresetMode

from grind_env.envs.tasks import read_task
from grind_env.envs.vector_env import GrindVectorEnv
from grind_env.envs.wide_plates.env import TASK


class WidePlatesVectorEnv(GrindVectorEnv):
    """N times `WidePlatesEnv`, with the numbers of `gymnasium.vector.SyncVectorEnv` bit by bit.

    Args:
        num_envs: number of sub-environments.
        observation: as for `WidePlatesEnv`.
        show_block: put the text of the blocks that were run into `info["block"]`.
        action: as for `WidePlatesEnv`.
        predress: as for `WidePlatesEnv`.
        cycle: as for `WidePlatesEnv`.
        autoreset_mode: `AutoresetMode` or its value: `"NextStep"`, `"SameStep"` or `"Disabled"`.
        render_mode: as for `GrindVectorEnv`.
        max_episode_steps: as for `GrindVectorEnv`.
    """

    load = staticmethod(read_task)

    def __init__(
        self,
        num_envs: int = 1,
        observation: str | None = None,
        show_block: bool = False,
        action: str = "box",
        predress: bool = False,
        cycle: str = "G83",
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        render_mode: str | None = None,
        max_episode_steps: int | None = None,
    ) -> None:
        super().__init__(
            num_envs,
            TASK,
            observation,
            show_block,
            action,
            predress,
            cycle,
            autoreset_mode,
            render_mode,
            max_episode_steps,
        )

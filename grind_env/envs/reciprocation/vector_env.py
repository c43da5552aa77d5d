"""`grind/Reciprocation-v0`, many times side by side."""

from gymnasium.vector import AutoresetMode

from grind_env.envs.reciprocation.program import TASK
from grind_env.envs.tasks import read_task
from grind_env.envs.vector_env import GrindVectorEnv


class ReciprocationVectorEnv(GrindVectorEnv):
    """N times `ReciprocationEnv`, in one compiled step; arguments as for `GrindVectorEnv`, without the task."""

    load = staticmethod(read_task)

    def __init__(
        self,
        num_envs: int = 1,
        observation: str | None = None,
        show_block: bool = False,
        action: str = "box",
        predress: bool = False,
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
            autoreset_mode=autoreset_mode,
            render_mode=render_mode,
            max_episode_steps=max_episode_steps,
        )

"""`grind/Stroke-v0`, many times side by side."""

from gymnasium.vector import AutoresetMode

from grind_env.envs.stroke.env import TASK, check_arguments, stroke_form
from grind_env.envs.tasks import read_task
from grind_env.envs.vector_env import GrindVectorEnv


class StrokeVectorEnv(GrindVectorEnv):
    """N times `StrokeEnv`, in one compiled step; arguments as for `GrindVectorEnv`, without the task.

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

    load = staticmethod(read_task)
    form_of = staticmethod(stroke_form)

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
        check_arguments(observation, predress, cycle)
        super().__init__(
            num_envs,
            TASK,
            observation,
            show_block,
            action,
            autoreset_mode=autoreset_mode,
            render_mode=render_mode,
            max_episode_steps=max_episode_steps,
        )

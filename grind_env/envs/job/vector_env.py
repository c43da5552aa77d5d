"""`grind/Job-v0`, many times side by side."""

from collections.abc import Mapping, Sequence
from typing import Any

from gymnasium.vector import AutoresetMode

from grind_env.envs.actions import ActionCodec
from grind_env.envs.arguments import check_flags, refuse_cycle, refuse_predress
from grind_env.envs.blocks.tables import Outcome
from grind_env.envs.contexts import Given
from grind_env.envs.job.env import load_simulation, read_given
from grind_env.envs.job.simulation import JobSimulation
from grind_env.envs.job.view import RunBlock, job_view, text_of
from grind_env.envs.vector_env import GrindVectorEnv
from grind_env.render.view import View


class JobVectorEnv(GrindVectorEnv):
    """N times `JobEnv`, in one compiled step if the program has a script.

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
        parts: how often the program is run.
    """

    simulation: JobSimulation

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
        parts: int = 1,
    ) -> None:
        check_flags(show_block=show_block, predress=predress)
        refuse_predress(predress, "the program says where a cycle of grind/Job-v0 is a G82.1")
        refuse_cycle(cycle, "the program of grind/Job-v0 says which cycles it runs")
        simulation = load_simulation(program, job, parts, spread, observation)
        codec = ActionCodec(simulation.task, action)
        self._set_up(num_envs, simulation, codec, show_block, autoreset_mode, render_mode, max_episode_steps)

    def _read_given(self, options: Mapping[str, Any] | None, before: Given) -> Given:
        return read_given(self.simulation, options, before)

    def _block(self, i: int, choice: tuple[float, ...]) -> RunBlock:
        speed, executions = choice
        return RunBlock(int(self.episodes.block[i]), float(speed), int(executions))

    def _text(self, block: Any) -> str:
        return text_of(self.simulation, block)

    def _view(self, i: int, blocks: Sequence[Any], outcomes: Sequence[Outcome]) -> View:
        return job_view(self.simulation, self.episodes, i, blocks, outcomes, (self.codec.low, self.codec.high))

"""`grind/Reciprocation-v0`: the literal G81, one part a step."""

from grind_env.control import read
from grind_env.envs.blocks.program import job_from_surface
from grind_env.envs.env import GrindEnv
from grind_env.envs.reciprocation.program import TASK, request_times
from grind_env.envs.tasks import read_task


class ReciprocationEnv(GrindEnv):
    """Choose the table speed and the dressing of every part that is ground with a continuous infeed.

    ## Description

    A step is one part: `G81 X.. I.. E.. P..` sets the table going, `G01 Y.. F..` feeds the wheel down at 0.5 mm/min
    while it reciprocates, a dwell sparks out, and `G80` stops it. A stroke is as deep as the infeed goes in its time,
    so that it gets thinner as **E** rises, and heavier on the wheel as E falls. G81 has no D word: the agent's **D**
    is that many requests of the operator for a dress, at equal fractions of depth, each of which the control serves
    at the next reversal point. Plates, wheel and what is random are those of `grind/PowerLimited-v0`.

    Actions, observation, reward and episode are those of `GrindEnv`, with E from 3 to 30 m/min and D from 0 to 3;
    `predress=True` lets an action ask for the G81.1 form. The coming block has no pick to be observed; `last_pick` is
    what the infeed covered in a stroke of the last block. `info["block"]` holds all blocks of the step, a line each.

    `part_program()` is the episode as a program; `operator_dress_at()` says when the operator has to ask for a dress.

    Args:
        observation: `"measured"` or `"full"`; `"measured"` by default.
        show_block: put the text of the blocks that were run into `info["block"]`.
        action: form of the action: `"box"`, `"multidiscrete"`, `"discrete"` or `"dict"`.
        predress: let an action ask for a dress before the first stroke, G81.1.
        render_mode: as for `GrindEnv`.
    """

    load = staticmethod(read_task)

    def __init__(
        self,
        observation: str | None = None,
        show_block: bool = True,
        action: str = "box",
        predress: bool = False,
        render_mode: str | None = None,
    ) -> None:
        super().__init__(TASK, observation, show_block, action, predress, render_mode=render_mode)

    def operator_dress_at(self) -> tuple[float, ...]:
        """Times of the control, s, at which the operator asks for a dress when that program runs."""
        return request_times(read(self.part_program()), job_from_surface(self.task).control)

"""`grind/Reciprocation-v0`: the literal G81, one part a step."""

from typing import Any

import numpy as np

from grind_env.control import read
from grind_env.envs.env import GrindEnv
from grind_env.envs.form import Form
from grind_env.envs.observations import Reading, readings
from grind_env.envs.program import job_from_surface
from grind_env.envs.reciprocation.program import TASK, block_text, part_program, request_times
from grind_env.envs.reciprocation.step import step_feedings
from grind_env.envs.simulation import Simulation, Table
from grind_env.envs.tasks import Task, read_task
from grind_env.machine.feeding import Feeding, Motion

DEEPEST = 5.0
"""Upper end of `last_pick`, scaled: what the infeed covers in a stroke of 3 m/min is 0.06 mm."""


class ReciprocationSimulation(Simulation):
    """Steps episodes of the task with its continuous infeed; arguments as for `Simulation`."""

    def __init__(self, task: Task, *, full: bool = False, pre_dress: bool = False) -> None:
        super().__init__(task, full=full, pre_dress=pre_dress)
        self._feedings, self._motions = np.empty((0, 0)), np.empty((0, 0, 0))

    @staticmethod
    def _readings(task: Task, *, full: bool, pre_dress: bool) -> tuple[Reading, ...]:
        """Those of the task, without the pick, which the coming block does not have."""
        return tuple(
            entry._replace(high=DEEPEST) if entry.name == "last_pick" else entry
            for entry in readings(task, full=full, pre_dress=pre_dress)
            if entry.name != "pick"
        )

    def _grind(self, cycles: Table, *arguments: Any) -> None:
        n, most = len(cycles), self.task.action.executions
        if len(self._feedings) < n:
            self._feedings = np.empty((n, len(Feeding._fields)))
            self._motions = np.empty((n, 2 * (most + 1), len(Motion._fields)))
        step_feedings(self.task.infeed / 60.0, self._feedings[:n], self._motions[:n], cycles, *arguments)


G81 = Form("G81", read_task, ReciprocationSimulation, block_text, part_program)
"""A step is one part: a G81 with its infeeds and dwells."""


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

    form = G81

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

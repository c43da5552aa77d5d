"""Episodes of parts that are ground with a continuous infeed: a step is a G81."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from grind_env.envs.blocks.program import job_from_surface
from grind_env.envs.blocks.simulation import BlockSimulation
from grind_env.envs.infeed.program import block_text, part_program
from grind_env.envs.infeed.step import step_feedings
from grind_env.envs.observations import Reading, readings
from grind_env.envs.tasks import Task
from grind_env.machine.job import Job
from grind_env.machine.loops.feeding import Motion

DEEPEST = 5.0
"""Upper end of `last_pick`, scaled: what the infeed covers in a stroke of 3 m/min is 0.06 mm."""


class InfeedSimulation(BlockSimulation):
    """Steps episodes of a task with its continuous infeed; arguments as for `BlockSimulation`."""

    def __init__(self, task: Task, *, full: bool = False, pre_dress: bool = False) -> None:
        super().__init__(task, full=full, pre_dress=pre_dress)
        self._motions = np.empty((0, 0, 0))

    def text(self, block: Any) -> str:
        """As `Simulation.text`."""
        return block_text(self.task, block)

    def program(self, blocks: Sequence[Any]) -> str:
        """As `Simulation.program`."""
        return part_program(self.task, blocks)

    def _job(self, blocks: Sequence[Any]) -> Job:
        return job_from_surface(self.task)

    @staticmethod
    def _readings(task: Task, *, full: bool, pre_dress: bool) -> tuple[Reading, ...]:
        """Those of the task, without the pick, which the coming block does not have."""
        return tuple(
            entry._replace(high=DEEPEST) if entry.name == "last_pick" else entry
            for entry in readings(task, full=full, pre_dress=pre_dress)
            if entry.name != "pick"
        )

    def _grind(self, tables: tuple[Any, ...], episodes: tuple[Any, ...], *arguments: Any) -> None:
        n, most = len(episodes[0]), self.task.action.executions
        if len(self._motions) < n:
            self._motions = np.empty((n, 2 * (most + 1), len(Motion._fields)))
        step_feedings((*tables, self._motions[:n], self.task.infeed / 60.0), episodes, *arguments)

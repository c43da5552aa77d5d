"""Episodes of parts that are ground with a continuous infeed: a step is a G81."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from grind_env.arrays import Table
from grind_env.envs.blocks.program import DRESS_PROGRAM, REQUEST, CycleBlock, approach, job_from_surface, number
from grind_env.envs.blocks.simulation import BlockSimulation
from grind_env.envs.episodes import Episodes
from grind_env.envs.infeed.infeed import segments
from grind_env.envs.infeed.step import feedings_step, infeed_of
from grind_env.envs.observations import Reading, readings
from grind_env.envs.tables import KindRow, kind_row
from grind_env.envs.tasks import Task
from grind_env.machine.job import Job
from grind_env.machine.loops.feeding import Feeding, FeedMotion
from grind_env.machine.loops.rows import RULES_FROM

DEEPEST = 5.0
"""Upper end of `last_pick`, scaled: what the infeed covers in a stroke of 3 m/min is 0.06 mm."""


class InfeedSimulation(BlockSimulation):
    """Steps episodes of a task with its continuous infeed; arguments as for `BlockSimulation`."""

    _step_of = staticmethod(feedings_step)

    def block(self, episodes: Episodes, i: int, speed: float, executions: float, pre_dress: float = 0.0) -> CycleBlock:
        """As `Simulation.block`; how long a stroke takes on a table with a speed of its own, a copy shows."""
        block: CycleBlock = super().block(episodes, i, speed, executions, pre_dress)
        if self.process.before is None:
            return block
        cycles, *others = self._scratch(1)
        choice = tuple(np.array([number]) for number in (speed, executions, pre_dress))
        self._run(episodes.pick([i]), choice, np.arange(1), (cycles, *others))
        found = Feeding(*cycles[0, RULES_FROM : RULES_FROM + len(Feeding._fields)].tolist())
        return block._replace(stroke=(found.travel, found.dwell))

    def text(self, block: CycleBlock) -> str:
        """Write a line each: G81 or G81.1, infeeds and dwells, some of which ask for a dress, and G80."""
        task, kind, machine, overrun = self.task, block.kind, self.task.machine, self.task.setup.overrun
        row = KindRow(*map(float, kind_row(task, kind)))
        requests, rate, dwell = float(block.executions), task.infeed / 60.0, machine.reversal_dwell
        infeed = infeed_of(row, block.stock, block.speed, dwell, requests, machine.acceleration, rate)
        if block.stroke is not None:
            infeed = infeed._replace(travel=block.stroke[0], dwell=block.stroke[1])
        words = f"X{number(kind.length + overrun)} I{number(-overrun)} E{number(block.speed)} P{DRESS_PROGRAM}"
        lines = [f"{'G81.1' if block.pre_dress else 'G81'} {words}"]
        for k, part in enumerate(segments(infeed)):
            request = f" ({REQUEST})" if k < block.executions else ""
            lines += [f"G01 Y{number(-part.end)} F{number(task.infeed)}", f"G04 X{number(part.dwell)}{request}"]
        return "\n".join([*lines, "G80"])

    def _lines(self, block: CycleBlock) -> list[str]:
        return [*approach(self.task, 0.0), self.text(block)]

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

    def _scratch_shapes(self) -> tuple[tuple[int, ...], ...]:
        return *super()._scratch_shapes(), (2 * (self.task.action.executions + 1), len(FeedMotion._fields))

    def _tables(self, scratch: tuple[Table, ...]) -> tuple[Any, ...]:
        return *super()._tables(scratch), self.task.infeed / 60.0

"""The simulation of a task: actions set E and D in the script, and the noise tape has the stocks."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from grind_env.envs.block_kind_rows import kind_table
from grind_env.envs.block_rollouts import BlockBranches
from grind_env.envs.blocks.task_program_writer import TaskWriter
from grind_env.envs.blocks.task_script_tables import task_script
from grind_env.envs.compiled_observations import scaling
from grind_env.envs.cost import shop_row
from grind_env.envs.episode_generator import EpisodeGenerator
from grind_env.envs.episode_state import Episodes
from grind_env.envs.observations import constant_readings, readings
from grind_env.envs.picture_builder import TaskViewer, Viewer
from grind_env.envs.program_writer import ProgramWriter
from grind_env.envs.reset_options import without_effect
from grind_env.envs.simulation import NO_SETTINGS, Simulation
from grind_env.envs.step_arrays import Scratch, Tables
from grind_env.envs.task_gauges import GAUGE, noisy
from grind_env.envs.tasks import Task
from grind_env.machine.loops.concurrent_strokes import Feeding
from grind_env.machine.loops.row_io import RULES_FROM
from grind_env.process.gauge_readings import Gauge
from grind_env.process.process_interface import PROCESS, Process

if TYPE_CHECKING:
    from grind_env.plants import Plants

CYCLES = Tables._fields.index("cycles") - Tables._fields.index("parameters")


class BlockSimulation(Simulation):
    """Simulation of episodes of a task.

    Args:
        task: the task.
        full: whether observations show the hidden state.
        pre_dress: whether an action may ask for a dress before the block, and observations show the last one.
        process: the grinding process.
        gauge: the gauges.
        plants: out-of-model machines in place of process and gauge; each episode has one of them.
    """

    def __init__(
        self,
        task: Task,
        *,
        full: bool = False,
        pre_dress: bool = False,
        process: Process = PROCESS,
        gauge: Gauge = GAUGE,
        plants: "Plants | None" = None,
    ) -> None:
        if plants is not None:
            process, gauge = plants.first.process, noisy(plants.first.gauge)
        self.task, self.pre_dress, self.unfixable, self.plants = task, pre_dress, without_effect(task), plants
        self._grind_with(process, gauge)
        self.entries = readings(task, full=full, pre_dress=pre_dress)
        self.constant_readings = constant_readings(task, pre_dress=pre_dress)
        self.kinds, self.branches, self.shops = kind_table(task), BlockBranches(task), np.array([shop_row(task)])
        self.tables, self._lead, self._covered = task_script(task, self.kinds)
        self._base, self._cooler, self._infeed = self.branches.base[None], np.zeros((1, 1)), task.infeed / 60.0
        self._scratch = Scratch(2 * (task.action.executions + 1) if task.infeed > 0.0 else 0)
        self._scaling, self._generator = scaling(task, self.entries), EpisodeGenerator(task)

    @property
    def writer(self) -> ProgramWriter:
        return TaskWriter(self.task, self.process, self.with_full_tapes, self.stroke_times)

    @property
    def viewer(self) -> Viewer:
        return TaskViewer(self.task, self.writer.text)

    def stroke_times(self, episodes: Episodes, i: int, choice: Sequence[float]) -> tuple[float, float]:
        """Return the times of a stroke in the coming G81 block and of the rest at its end, s, from a step on a copy."""
        room = self._scratch.take(1)
        numbers = tuple(np.array([number]) for number in choice)
        self._run(episodes.pick([i]), (*numbers, NO_SETTINGS), np.arange(1), room)
        found = Feeding(*room[CYCLES][0, RULES_FROM : RULES_FROM + len(Feeding._fields)].tolist())
        self._scratch.give_back(room)
        return found.travel, found.dwell

"""Episodes of a task whose steps are cycle blocks: its program has holes for E and D, and its tape says the stocks."""

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from grind_env.control import read
from grind_env.envs.blocks.program import (
    block_text,
    coming_block,
    conditions,
    job_of,
    program_of,
    request_times,
)
from grind_env.envs.blocks.script import task_script
from grind_env.envs.branches import BlockBranches
from grind_env.envs.contexts import without_effect
from grind_env.envs.cost import Outcome, shop_row
from grind_env.envs.episode_generator import EpisodeGenerator
from grind_env.envs.episodes import Episodes
from grind_env.envs.gauge import GAUGE, noisy
from grind_env.envs.observations import constant_readings, readings, scaling
from grind_env.envs.simulation import NO_SETTINGS, Simulation, Written
from grind_env.envs.tables import kind_table
from grind_env.envs.tasks import Task
from grind_env.envs.transition import Scratch, Tables
from grind_env.envs.view import view_of
from grind_env.machine.grind import grind
from grind_env.machine.job import WheelStart
from grind_env.machine.loops.feeding import Feeding
from grind_env.machine.loops.rows import RULES_FROM
from grind_env.machine.record import GrindingRecord
from grind_env.process.gauge import Gauge
from grind_env.process.process import PROCESS, Process
from grind_env.render.view import EpisodePicture

if TYPE_CHECKING:
    from grind_env.plants import Plants

CYCLES = Tables._fields.index("cycles") - Tables._fields.index("parameters")


class BlockSimulation(Simulation):
    """Steps episodes of one task.

    Args:
        task: the task.
        full: whether observations show the hidden state.
        pre_dress: whether a choice has a dress before the first plunge, and observations show the last one.
        process: what grinds.
        gauge: what is measured of it.
        plants: machines that are not the model, in place of both; each episode has one of them.
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
        self.task, self.pre_dress, self.barred, self.plants = task, pre_dress, without_effect(task), plants
        self._grind_with(process, gauge)
        self.entries = readings(task, full=full, pre_dress=pre_dress)
        self.usual = constant_readings(task, pre_dress=pre_dress)
        self.kinds, self.branches, self.shops = kind_table(task), BlockBranches(task), np.array([shop_row(task)])
        self.tables, self._lead, self._covered = task_script(task, self.kinds)
        self._base, self._cooler, self._infeed = self.branches.base[None], np.zeros((1, 1)), task.infeed / 60.0
        self._scratch = Scratch(2 * (task.action.executions + 1) if task.infeed > 0.0 else 0)
        self._scaling, self._generator = scaling(task, self.entries), EpisodeGenerator(task)

    def block(self, episodes: Episodes, i: int, speed: float, executions: float, pre_dress: float = 0.0) -> Any:
        block = coming_block(self.task, episodes, i, speed, executions, pre_dress)
        if self._infeed == 0.0 or self.process.before is None:
            return block
        # how long a stroke takes on a table with a speed of its own, a copy shows
        room = self._scratch.take(1)
        choice = tuple(np.array([number]) for number in (speed, executions, pre_dress))
        self._run(episodes.pick([i]), (*choice, NO_SETTINGS), np.arange(1), room)
        found = Feeding(*room[CYCLES][0, RULES_FROM : RULES_FROM + len(Feeding._fields)].tolist())
        self._scratch.give_back(room)
        return block._replace(stroke=(found.travel, found.dwell))

    def text(self, block: Any) -> str:
        return block_text(self.task, block)

    def program(self, blocks: Sequence[Any]) -> str:
        return program_of(self.task, blocks)

    def written(self, episodes: Episodes, i: int, blocks: Sequence[Any]) -> Written:
        program, found, start = self.program(blocks), blocks[0].wheel, self.task.start
        wheel = WheelStart(
            diameter=found.ds,
            diamond_flat=found.wd,
            wear_flat_area=None if start.wear_flat_area is None else found.A,
            volume_since_dress=None if start.wear_flat_area is None else found.V,
        )
        parts, own = conditions(self.task, self.tape(episodes, i)), blocks[0].own[: len(self.process.own._fields)]
        shop = replace(job_of(self.task, blocks), wheel=wheel, parts=tuple(parts), process=self.process, own=own)
        return Written(program, shop, request_times(read(program), shop))

    def record(self, episodes: Episodes, i: int, blocks: Sequence[Any]) -> GrindingRecord:
        program, shop, requests = self.written(episodes, i, blocks)
        return grind(read(program), shop, control=replace(shop.control, operator_dress_at=requests))

    def view(self, episodes: Episodes, i: int, blocks: Sequence[Any], outcomes: Sequence[Outcome]) -> EpisodePicture:
        return view_of(self.task, episodes, i, blocks, outcomes, self.text(blocks[-1]) if blocks else "")

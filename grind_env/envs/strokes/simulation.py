"""Episodes of `grind/Stroke-v0`: parts ground one stroke at a time, N of them side by side."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grind_env.envs.blocks.program import job
from grind_env.envs.blocks.simulation import BlockSimulation
from grind_env.envs.contexts import CONTEXT_FACTORS, Given
from grind_env.envs.episodes import Episodes
from grind_env.envs.observations import Reading
from grind_env.envs.strokes.episodes import StrokeEpisodes
from grind_env.envs.strokes.observe import observe_strokes
from grind_env.envs.strokes.program import StrokeBlock, block_text, coming_stroke, part_program
from grind_env.envs.strokes.readings import StrokeReadings, stroke_readings
from grind_env.envs.strokes.rules import Pace
from grind_env.envs.strokes.step import StrokeMemory, strokes_step
from grind_env.envs.strokes.view import in_strokes
from grind_env.envs.tables import KindRow, Outcome
from grind_env.envs.tape import TapeRow
from grind_env.envs.tasks import Task
from grind_env.machine.job import Job
from grind_env.machine.loops.tally import Plunges
from grind_env.process.gauge import Gauge
from grind_env.process.process import Process
from grind_env.render.view import View

STOCK = TapeRow._fields.index("stock")
ENDS, WAIT = KindRow._fields.index("ends_part"), KindRow._fields.index("wait")


class StrokeSimulation(BlockSimulation):
    """Steps episodes by strokes; arguments as for `BlockSimulation`. Every part is of the only kind of the task."""

    by_block = False

    def __init__(self, task: Task, **given: Any) -> None:
        super().__init__(task, **given)
        within, last = self.kinds.copy(), self.kinds.copy()
        # the loading is counted in the time of the first stroke
        within[:, WAIT] = last[:, WAIT] = within[:, ENDS] = 0.0
        self.kinds = np.concatenate([self.kinds, within, last])
        self._most = most_strokes(task)
        self._columns = np.array([StrokeReadings._fields.index(entry.name) for entry in self.entries])

    def restart_all(
        self, episodes: Episodes, index: Sequence[int], rngs: Sequence[np.random.Generator], given: Sequence[Given]
    ) -> None:
        """As `Simulation.restart_all`."""
        mine, rows = _stroke_episodes(episodes), np.array(index)
        super().restart_all(mine, index, rngs, given)
        mine.strokes[rows] = mine.plunges[rows] = 0.0

    def observe(self, episodes: Episodes) -> NDArray[np.float32]:
        """Observations of the coming strokes, shape (N, entries), float32; zeros for what is not after the last one."""
        mine = _stroke_episodes(episodes)
        observations = np.empty((len(mine.block), len(self.entries)), np.float32)
        state = mine.block, mine.wheels, self._heat, mine.memory, mine.tape, mine.strokes
        shown = self._columns, *self._scaling[1:], observations
        observe_strokes(self.kinds, self._materials, self.task.blocks, *state, *shown)
        return observations

    @property
    def most_steps(self) -> int:
        """Strokes of an episode at most."""
        return self._most

    def block(self, episodes: Episodes, i: int, speed: float, executions: float, pre_dress: float = 0.0) -> StrokeBlock:
        """As `Simulation.block`."""
        return coming_stroke(self.task, _stroke_episodes(episodes), i, speed, executions)

    def text(self, block: Any) -> str:
        """As `Simulation.text`."""
        return block_text(self.task, block)

    def program(self, blocks: Sequence[Any]) -> str:
        """As `Simulation.program`."""
        return part_program(self.task, blocks)

    def view(self, episodes: Episodes, i: int, blocks: Sequence[Any], outcomes: Sequence[Outcome]) -> View:
        """As `Simulation.view`."""
        kind, stocks = self.task.kinds[0], self.tape(episodes, i)[:, STOCK].tolist()
        strokes = sum(self.task.strokes(kind, stock) for stock in stocks)
        return in_strokes(super().view(episodes, i, blocks, outcomes), strokes)

    def _job(self, blocks: Sequence[Any]) -> Job:
        return job(self.task, *self.task.kinds)

    @staticmethod
    def _readings(task: Task, *, full: bool, pre_dress: bool) -> tuple[Reading, ...]:
        return stroke_readings(task, full=full)

    @staticmethod
    def _step_of(process: Process, gauge: Gauge) -> Callable[..., None]:
        return strokes_step(process, gauge)

    def _tables(self, n: int) -> tuple[Any, ...]:
        *others, _ = super()._tables(n)  # parameters of a part stay from stroke to stroke, in the episodes
        return tuple(others)

    def room(self, n: int, *, whole: bool = True) -> StrokeEpisodes:
        """As `Simulation.room`."""
        return StrokeEpisodes(
            **self._room(n, whole),
            strokes=np.empty((n, len(StrokeMemory._fields))),
            paces=np.empty((n, len(Pace._fields))),
            plunges=np.empty((n, len(Plunges._fields))),
            parameters=np.empty((n, self.branches.base.shape[1])),
        )


def most_strokes(task: Task) -> int:
    """Strokes of an episode whose parts all have the greatest stock that a context can fix."""
    kind = task.kinds[0]
    return task.blocks * (int(CONTEXT_FACTORS["stock"].high * kind.stock / kind.pick) + kind.sparkout + 2)


def _stroke_episodes(episodes: Episodes) -> StrokeEpisodes:
    assert isinstance(episodes, StrokeEpisodes)
    return episodes

"""An episode of `grind/Stroke-v0`: parts ground one stroke at a time, and the program that says the same."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from grind_env.envs.program import conditions, job
from grind_env.envs.rows import COST_TERMS
from grind_env.envs.stroke.program import StrokeProgram
from grind_env.envs.tape import TapeRow
from grind_env.envs.tasks import Task
from grind_env.machine.compiled import dress_wheel, expenses, handover_cost
from grind_env.machine.part import PartRun
from grind_env.machine.record import PART_ROW
from grind_env.process.state import Stroke, WheelState


@dataclass(frozen=True, slots=True, eq=False)
class StrokeRun:
    """What comes of one stroke.

    Attributes:
        stroke: the stroke.
        pick: depth by which it went deeper than the one before it, mm.
        costs: $, by the names of `COST_TERMS`.
        seconds: time with the dress before it and, for the first one, the loading.
        finished: the row of the part (`record.PART_ROW`) if this was its last stroke.
    """

    stroke: Stroke
    pick: float
    costs: dict[str, float]
    seconds: float
    finished: NDArray[np.void] | None


class StrokeEpisode:
    """Grinds the parts of a task one after the other; every part is a block of its only kind.

    Attributes:
        task: the task.
        tape: one row a part.
        wheel: as it is now.
        part: on the machine; None when the last one is finished.
        made: strokes made on it.
        program: what has been run.
    """

    def __init__(self, task: Task, tape: NDArray[np.float64], wheel: WheelState) -> None:
        self.task, self.wheel = task, wheel
        self.tape = [TapeRow(*row) for row in tape.tolist()]
        self.job = job(task, *task.kinds)
        self.program = StrokeProgram(task)
        self.made = 0
        self._conditions = conditions(task, tape)
        self._seconds = 0.0
        self.part: PartRun | None = self._load(1)

    @property
    def row(self) -> TapeRow:
        """The tape of the part on the machine, or of the last one."""
        return self.tape[(len(self.tape) if self.part is None else self.part.number) - 1]

    @property
    def strokes(self) -> int:
        """Strokes of that part: its picks, the last one shortened, and the spark-out."""
        return self._strokes_of(self.row)

    @property
    def all_strokes(self) -> int:
        """Strokes of all parts."""
        return sum(self._strokes_of(row) for row in self.tape)

    def _strokes_of(self, row: TapeRow) -> int:
        return self.task.strokes(self.task.kinds[0], row.stock)

    def depth(self, stroke: int) -> float:
        """Depth of a stroke of that part, from 0, mm; on the resolution of the control."""
        return round(min((stroke + 1) * self.task.kinds[0].pick, self.row.stock), 3)

    @property
    def coming_pick(self) -> float:
        """Depth by which the coming stroke goes deeper than the one before it, mm; 0 after the last one."""
        if self.part is None:
            return 0.0
        return self.depth(self.made) - (self.depth(self.made - 1) if self.made else 0.0)

    def step(self, speed: float, dress: bool) -> StrokeRun:
        """Make the coming stroke at E `speed` (mm/min), after a dress or not; there must be one left."""
        part, task = self.part, self.task
        assert part is not None
        pick, depth, removed = self.coming_pick, self.depth(self.made), 0.0
        stroke_seconds = seconds = self.program.stroke_time(speed)
        if self.made == 0:
            self.program.start_part(depth, speed, dress)
            seconds += task.setup.load
        else:
            seconds += self.program.next_stroke(pick, depth, speed, dress)
        if dress:
            self.wheel, removed = dress_wheel(
                self.wheel, float(task.dress.passes), task.dress_feed, task.dress.depth, part.p
            )
            part.dress(task.dress_seconds, removed)
            seconds += task.dress_seconds
        overrun = task.setup.overrun
        ends = -overrun, self.job.part.length + overrun
        self.wheel, made = part.grind(self.wheel, depth, speed / 60.0, ends, 0.0, stroke_seconds)
        self.made += 1
        self._seconds += seconds
        finished = self._unload(part) if self.made == self.strokes else None
        terms = (*expenses(seconds, made.stroke.worn + removed, float(dress), self.job.rates), 0.0, 0.0)
        costs = dict(zip(COST_TERMS, terms, strict=True))
        if finished is not None:
            costs["scrap"] = float(finished["scrap_cost"])
            costs["handover"] = self._handover(part) if self.part is None else 0.0
        return StrokeRun(made.stroke, pick, costs, seconds, finished)

    def _load(self, number: int) -> PartRun:
        self.made, self._seconds = 0, 0.0
        self.wheel = self.wheel._replace(W=0.0)  # touched off on the new part
        part = PartRun(number, self.job, self._conditions[number - 1], 0.0)
        part.deepest = self.tape[number - 1].stock
        return part

    def _unload(self, part: PartRun) -> NDArray[np.void]:
        self.program.end_part()
        row: NDArray[np.void] = np.array([part.row(self._seconds)], PART_ROW)[0]
        self.part = self._load(part.number + 1) if part.number < len(self.tape) else None
        return row

    def _handover(self, part: PartRun) -> float:
        dress = self.task.dress
        return handover_cost(
            self.wheel,
            float(dress.passes),
            self.task.dress_feed,
            dress.depth,
            self.task.dress_seconds,
            part.p,
            self.job.rates,
        )

"""Episodes of parts that are wider than the wheel: a step is a G83, which the lanes grind in zones.

Cost and memory are those of `envs.blocks.settling`.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grind_env.arrays import Table
from grind_env.control.cycles.traverse import TraverseCycle
from grind_env.envs.blocks.program import DRESS_PROGRAM, CycleBlock, approach, job_from_surface, number
from grind_env.envs.blocks.simulation import BlockSimulation
from grind_env.envs.contexts import Given
from grind_env.envs.episodes import Episodes
from grind_env.envs.observations import Reading, measured_first, readings
from grind_env.envs.strips.step import TAPER_NOISE, traverses_step
from grind_env.envs.tasks import CROSS_FEED, Task
from grind_env.machine.job import Job
from grind_env.machine.loops.zones import strip_centres, traverse_edges, zones_of

TAPER = "taper"
"""Name of the entry that only a part ground in strips has."""


@dataclass(slots=True)
class StripEpisodes(Episodes):
    """The state of N episodes under way.

    `taper` of the last finished part in um as gauged, shape (N,).
    """

    taper: Table


class StripSimulation(BlockSimulation):
    """Steps episodes of a task whose parts are wider than the wheel; arguments as for `BlockSimulation`.

    A part is judged where it is farthest from its size.
    """

    _step_of = staticmethod(traverses_step)

    def __init__(self, task: Task, **given: Any) -> None:
        super().__init__(task, **given)
        self._zones = part_in_zones(task)
        self._crossing = crossover(task), task.cross_pick

    def restart_all(
        self, episodes: Episodes, index: Sequence[int], rngs: Sequence[np.random.Generator], given: Sequence[Given]
    ) -> None:
        super().restart_all(episodes, index, rngs, given)
        _cross(episodes).taper[np.array(index)] = 0.0

    def observe(self, episodes: Episodes) -> NDArray[np.float32]:
        place = [entry.name for entry in self.entries].index(TAPER)
        reading = self.entries[place]
        taper = np.clip((_cross(episodes).taper - reading.offset) / reading.scale, reading.low, reading.high)
        observations = super().observe(episodes)
        observations[:, place] = taper
        return observations

    def read(self, observation: NDArray[np.float32]) -> dict[str, Table]:
        """As `Simulation.read`; the width that power was spent on is that of the wheel, and not of the part."""
        seen = super().read(observation)
        return seen | {"last_width": np.minimum(seen["last_width"], self.task.wheel.width)}

    def text(self, block: CycleBlock) -> str:
        task = self.task
        overrun, kind = task.setup.overrun, block.kind
        words = (
            "G83.1" if block.pre_dress else "G83",
            f"X{number(kind.length + overrun)}",
            f"I{number(-overrun)}",
            f"Y{number(-block.stock)}",
            f"J{number(-kind.pick)}",
            f"Z{number(crossover(task))}",
            f"K{number(task.cross_pick)}",
            f"L{kind.sparkout}",
            f"F{number(CROSS_FEED)}",
            f"E{number(block.speed)}",
            f"P{DRESS_PROGRAM}",
            f"D{block.executions}",
        )
        return " ".join(words)

    def _lines(self, block: CycleBlock) -> list[str]:
        return [*approach(self.task, 0.0), self.text(block), "G80"]

    def _job(self, blocks: Sequence[Any]) -> Job:
        return job_from_surface(self.task)

    @staticmethod
    def _readings(task: Task, *, full: bool, pre_dress: bool) -> tuple[Reading, ...]:
        """Those of the task with the size where it is worst, and the taper, which only a part ground in strips has."""
        factor, tolerance = task.spread.measurement, max(task.kinds[0].tolerance, 1.0)
        noise = f"{TAPER_NOISE * factor:.2g} um" if factor > 0.0 else "exact"
        taper = "range of the size across the last finished part"
        worst = "stock left on the last finished part where it is farthest from its size"
        plain = readings(task, full=full, pre_dress=pre_dress)
        shown = (each._replace(meaning=worst) if each.name == "size_error" else each for each in plain)
        return measured_first((*shown, Reading(TAPER, "um", 0.0, tolerance, 0.0, 5.0, noise, taper)))

    def room(self, n: int, *, whole: bool = True) -> StripEpisodes:
        return StripEpisodes(**self._room(n, whole), taper=np.empty(n))

    def _tables(self, scratch: tuple[Table, ...]) -> tuple[Any, ...]:
        return *super()._tables(scratch), np.empty((len(scratch[0]), *self._zones.shape)), self._zones, *self._crossing


def crossover(task: Task) -> float:
    """Z of the G83, mm: from one edge of the wheel on the edge of the part to the other one."""
    return task.kinds[0].width - task.wheel.width


def part_in_zones(task: Task) -> Table:
    """A new part, shape (zones, fields of `Zone`)."""
    kind = task.kinds[0]
    cycle = TraverseCycle(
        depth=kind.stock,
        primary_pick=kind.pick,
        secondary_pick=kind.pick,
        width=crossover(task),
        primary_cross_pick=task.cross_pick,
        secondary_cross_pick=task.cross_pick,
        at_depth=1.0 + kind.sparkout,
        executions=0.0,
        pre_dress=0.0,
    )
    edges = traverse_edges(cycle, 0.0, crossover(task))
    return zones_of(strip_centres(0.0, kind.width), edges, task.wheel.width)


def _cross(episodes: Episodes) -> StripEpisodes:
    assert isinstance(episodes, StripEpisodes)
    return episodes

"""Episodes of parts that are wider than the wheel: a step is a G83, which the lanes grind in zones.

Cost and memory are those of `envs.blocks.step.settle`.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grind_env.arrays import Table
from grind_env.control.cycles.traverse import TraverseCycle
from grind_env.envs.blocks.program import job_from_surface
from grind_env.envs.blocks.simulation import BlockSimulation
from grind_env.envs.contexts import Given
from grind_env.envs.episodes import Episodes
from grind_env.envs.observations import Reading, measured_first, readings
from grind_env.envs.strips.program import block_text, crossover, part_program
from grind_env.envs.strips.step import TAPER_NOISE, traverses_step
from grind_env.envs.tasks import Task
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

    _block_text = staticmethod(block_text)
    _part_program = staticmethod(part_program)
    _step_of = staticmethod(traverses_step)

    def __init__(self, task: Task, **given: Any) -> None:
        super().__init__(task, **given)
        self._zones = part_in_zones(task)
        self._crossing = crossover(task, task.kinds[0]), task.cross_pick

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

    def _job(self, blocks: Sequence[Any]) -> Job:
        return job_from_surface(self.task)

    @staticmethod
    def _readings(task: Task, *, full: bool, pre_dress: bool) -> tuple[Reading, ...]:
        """Those of the task with the size where it is worst, and the taper, which only a part ground in strips has."""
        plain = (_at_worst(entry) for entry in readings(task, full=full, pre_dress=pre_dress))
        return measured_first((*plain, taper_reading(task)))

    def room(self, n: int, *, whole: bool = True) -> StripEpisodes:
        return StripEpisodes(**self._room(n, whole), taper=np.empty(n))

    def _tables(self, scratch: tuple[Table, ...]) -> tuple[Any, ...]:
        return *super()._tables(scratch), np.empty((len(scratch[0]), *self._zones.shape)), self._zones, *self._crossing


def part_in_zones(task: Task) -> Table:
    """A new part, shape (zones, fields of `Zone`)."""
    kind = task.kinds[0]
    cycle = TraverseCycle(
        depth=kind.stock,
        primary_pick=kind.pick,
        secondary_pick=kind.pick,
        width=crossover(task, kind),
        primary_cross_pick=task.cross_pick,
        secondary_cross_pick=task.cross_pick,
        at_depth=1.0 + kind.sparkout,
        executions=0.0,
        pre_dress=0.0,
    )
    edges = traverse_edges(cycle, 0.0, crossover(task, kind))
    return zones_of(strip_centres(0.0, kind.width), edges, task.wheel.width)


def taper_reading(task: Task) -> Reading:
    """The entry of the observation that only a part ground in strips has."""
    factor = task.spread.measurement
    noise = f"{TAPER_NOISE * factor:.2g} um" if factor > 0.0 else "exact"
    meaning = "range of the size across the last finished part"
    return Reading(TAPER, "um", 0.0, max(task.kinds[0].tolerance, 1.0), 0.0, 5.0, noise, meaning)


def _at_worst(entry: Reading) -> Reading:
    if entry.name != "size_error":
        return entry
    return entry._replace(meaning="stock left on the last finished part where it is farthest from its size")


def _cross(episodes: Episodes) -> StripEpisodes:
    assert isinstance(episodes, StripEpisodes)
    return episodes

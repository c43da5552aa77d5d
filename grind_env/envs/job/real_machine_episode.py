"""An episode of a part program on a real machine, from readings that the user enters.

An observation has measured values and book-keeping: E and D, dresses, depths, volumes. The compiled step keeps the
book, with a wheel and a part without spread. Entered readings replace the simulated ones, without added noise, in the
same compiled account. So the observation equals the observation of an environment with the same readings.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grind_env.envs.block_settling import settle_of
from grind_env.envs.cost import Found, Outcome
from grind_env.envs.job.job_noise_tape import NEW_LOT
from grind_env.envs.job.job_simulation import JobSimulation
from grind_env.envs.past_readings import History
from grind_env.envs.simulation import BOOKED, DIAMETER, without_wheel_changes
from grind_env.envs.step_arrays import EpisodeArrays
from grind_env.envs.task_gauges import GAUGE, gauged_diameter
from grind_env.machine.loops.stroke_totals import Tally
from grind_env.machine.script.block_settings import D, E

GAUGED, PICK, SIZE = (History._fields.index(name) for name in ("gauged", "pick", "size_error"))
NONE_GAUGED, OUTCOME_FIELDS = -1.0, len(Outcome._fields)


class Measured(NamedTuple):
    """Readings of a block, and of the part that it finished."""

    #: mean load of the spindle in the last (up to 6) full plunges since a dress, W above idle; 0 if none was read
    mean_power: float = 0.0
    #: mean load of the spindle in the first (up to 6) full plunges, W above idle; 0 if none was read
    first_power: float = 0.0
    peak_power: float = 0.0  #: highest load, W; 0 if none was read
    size_error: float | None = None  #: stock left on the finished part, um
    Ra: float | None = None  #: Ra of the finished part, um; the observation shows it one part later
    Ra_before: float | None = None  #: Ra of the part before, um, if unknown until now
    diameter: float | None = None  #: diameter of the wheel, mm
    new_wheel: bool = False  #: whether the wheel was changed after the block
    new_lot: bool = False  #: whether the coming part begins a new lot


class MeasuredEpisode:
    """One episode, block by block.

    Args:
        simulation: simulation of the program, which defines the observations.
    """

    def __init__(self, simulation: JobSimulation) -> None:
        # without spread, and with wheel changes only where the user enters them
        self.simulation = without_wheel_changes(simulation.with_spread(0.0))
        self._episodes = self.simulation.start([np.random.default_rng(0)])
        self._episodes.tape[..., NEW_LOT] = 0.0
        self._episodes.tape[0, 0, NEW_LOT] = 1.0

    @property
    def block(self) -> int:
        """Return the number of the coming block, from 0."""
        return int(self._episodes.block[0])

    @property
    def over(self) -> bool:
        """Return whether the last block has been ground."""
        return self.block >= len(self.simulation.blocks)

    def observation(self) -> NDArray[np.float32]:
        """Return the observation before the coming block, shape (1, entries)."""
        return self.simulation.observe(self._episodes)

    def taken(self, speed: float, executions: float) -> tuple[float, int]:
        """Return E, mm/min, and D as the words of the coming block state them."""
        choice = np.array([speed]), np.array([executions])
        speeds, dresses = self.simulation.applied_choice(self._episodes, choice)
        return float(speeds[0]), int(dresses[0])

    def take(self, speed: float, executions: int, measured: Measured) -> None:
        """Take the readings of the coming block, which was ground with E (mm/min) and D."""
        simulation, episodes = self.simulation, self._episodes
        number, before = episodes.block.copy(), episodes.memory.copy()
        ends = simulation.blocks[int(number[0])].finished > 0
        settings = simulation.own_settings(episodes)
        speeds, dresses = np.array([speed]), np.array([float(executions)])
        settings[:, E], settings[:, D] = speeds, dresses
        # with the wheel as mounted: the nominal worn wheel may stall where the true wheel has not
        fresh = simulation.branches.first_wheels(1)
        fresh[:, DIAMETER] = episodes.wheels[:, DIAMETER]
        episodes.wheels[:, : fresh.shape[1]] = fresh
        _, tallies = simulation.step(episodes, speeds, dresses)
        tallies[0] = Tally(*tallies[0].tolist())._replace(
            first_power=measured.first_power,
            first_count=1.0,
            power_1=measured.mean_power,
            **dict.fromkeys(("power_2", "power_3", "power_4", "power_5", "power_6"), 0.0),
            last_count=1.0,
            peak_load=measured.peak_power,
        )
        found = Found(
            good=1.0,
            size_error=float(before[0, SIZE]) if measured.size_error is None else measured.size_error,
            change=float(measured.new_wheel),
            handover=0.0,
            pick=float(episodes.memory[0, PICK]),
        )
        episodes.block[:], episodes.memory[:] = number, before
        if ends and measured.Ra_before is not None:
            episodes.memory[0, GAUGED] = self._roughness(measured.Ra_before)
        if measured.diameter is not None:
            episodes.wheels[0, DIAMETER] = measured.diameter
        outcome, found_row = np.zeros((1, OUTCOME_FIELDS)), np.array([found])
        state, shops = EpisodeArrays(*episodes.in_order()), simulation.shops
        _, settle = settle_of(simulation.job.process, GAUGE)
        settle(simulation.kinds, shops, state, settings, np.array([0]), tallies, found_row, outcome)
        if ends:
            episodes.memory[0, GAUGED] = NONE_GAUGED if measured.Ra is None else self._roughness(measured.Ra)
        if measured.diameter is not None:
            episodes.memory[0, BOOKED] = gauged_diameter(measured.diameter, 0.0)
        if ends or measured.new_wheel or measured.diameter is not None:
            episodes.wheels[0, DIAMETER] = episodes.memory[0, BOOKED]
        if measured.new_lot and not self.over:
            episodes.tape[0, self.block, NEW_LOT] = 1.0

    def _roughness(self, Ra: float) -> float:
        limit = self.simulation.job.limits.roughness
        return Ra / limit if limit > 0.0 else 0.0

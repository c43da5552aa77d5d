"""The rule of a shop that samples the roughness of its parts."""

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from grind_env.envs.episodes import Episodes
from grind_env.envs.simulation import Simulation
from grind_env.envs.tasks import Task
from grind_env.policies.choices import Decision, nearest_speed
from grind_env.policies.policy import Sees
from grind_env.policies.scripted.instruments import Instruments


@dataclass
class RoughnessGauge:
    """Dress and slow down while the last gauged roughness is near its limit.

    The operator takes every third part to the roughness tester and hears of it one part later. A loaded wheel
    is dressed, one execution a block as long as the last reading stands above `upper`; the table is turned down in
    proportion to what the reading is above `near`, because a slower table leaves a finer surface.

    Attributes:
        E: m/min, by kind of block.
        upper: gauged Ra over its limit above which a block of each kind is dressed.
        near: gauged Ra over its limit from which E falls.
        slowing: exponent of the fall, E (near / reading)^slowing.
    """

    E: tuple[float, ...]
    upper: tuple[float, ...]
    near: float
    slowing: float
    name: ClassVar[str] = "roughness_gauge"
    sees: ClassVar[Sees] = "measurements"
    task: Task = field(init=False, repr=False)
    instruments: Instruments = field(init=False, repr=False)

    def begin(self, simulation: Simulation, episodes: int) -> None:
        """Nothing has been gauged."""
        self.task, self.instruments = simulation.task, Instruments(simulation, episodes)

    def act(self, observation: NDArray[np.float32], episodes: Episodes | None) -> Decision:
        """Compare."""
        reading = self.instruments.read(observation)["roughness"]
        dress = reading > self.instruments.of_kind(self.upper)
        slower = (self.near / np.maximum(reading, self.near)) ** self.slowing
        speeds = 1000.0 * self.instruments.of_kind(self.E) * slower
        return Decision(nearest_speed(self.task, speeds), dress.astype(np.float64))

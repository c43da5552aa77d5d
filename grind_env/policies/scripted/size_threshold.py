"""The rule of a shop that gauges the size of every part."""

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from grind_env.arrays import Array
from grind_env.envs.episodes import Episodes
from grind_env.envs.simulation import Simulation
from grind_env.envs.tasks import Task
from grind_env.policies.choices import Decision, nearest_speed
from grind_env.policies.policy import Sees
from grind_env.policies.scripted.instruments import Instruments


@dataclass
class SizeThreshold:
    """Dress when the gauge says so: the size error of the last part comes near its tolerance.

    A dull wheel pushes the machine back and leaves stock on the part, so the operator at the gauge sees the error
    grow from part to part and dresses, one execution a block, before it is out of tolerance. E stays what the
    program says. The gauge knows nothing of burn or power.

    Attributes:
        E: m/min, by kind of block.
        share: of the tolerance of the last part, above which a block of each kind is dressed.
    """

    E: tuple[float, ...]
    share: tuple[float, ...]
    name: ClassVar[str] = "size_threshold"
    sees: ClassVar[Sees] = "measurements"
    task: Task = field(init=False, repr=False)
    instruments: Instruments = field(init=False, repr=False)
    tolerance: Array = field(init=False, repr=False)

    def begin(self, simulation: Simulation, episodes: int) -> None:
        """No part has been gauged."""
        self.task, self.instruments = simulation.task, Instruments(simulation, episodes)
        self.tolerance = np.full(episodes, np.inf)

    def act(self, observation: NDArray[np.float32], episodes: Episodes | None) -> Decision:
        """Compare."""
        seen = self.instruments.read(observation)
        dress = np.abs(seen["size_error"]) > self.instruments.of_kind(self.share) * self.tolerance
        # the next reading is of the part that the coming block ends, or of the same one again
        self.tolerance = np.where(seen["tolerance"] > 0.0, seen["tolerance"], self.tolerance)
        return Decision(nearest_speed(self.task, 1000.0 * self.instruments.of_kind(self.E)), dress.astype(np.float64))

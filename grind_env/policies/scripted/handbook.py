"""The handbook policy: usual values, before any tuning or measurement."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from grind_env.array_types import Array
from grind_env.envs.block_rollouts import coming_kinds
from grind_env.envs.episode_state import Episodes
from grind_env.envs.simulation import Simulation
from grind_env.envs.tasks import Task
from grind_env.policies.choices import Decision, nearest_speed
from grind_env.policies.policy import Sees

USUAL_SPEED = 12_000.0  #: usual table speed for hardened steel, mm/min
#: table speed of the tasks with another usual speed, mm/min
USUAL_SPEEDS = {"job_shop": 15_000.0, "rush": 15_000.0, "blades": 10_000.0, "CBN": 20_000.0}
#: usual specific energy, J/mm3, in grinding of steels (Malkin and Guo, Grinding Technology, chapter 5: 20 to 60)
SPECIFIC_ENERGY = 40.0
SPINDLE_SHARE = 0.8  #: planned share of the spindle's power


@dataclass
class Handbook:
    """Usual E, limited by the spindle's power; one dress per part, or per block if part starts are not measured."""

    name: ClassVar[str] = "handbook"
    sees: ClassVar[Sees] = "measurements"

    def begin(self, simulation: Simulation, episodes: int) -> None:
        self.simulation, self.usual = simulation, handbook_speeds(simulation.task)

    def act(self, observation: NDArray[np.float32], episodes: Episodes | None) -> Decision:
        seen = self.simulation.read(observation)
        every = np.ones(len(observation))
        kinds = coming_kinds(self.simulation.branches, seen)
        return Decision(self.usual[kinds], np.round(seen.get("starts_part", every)))


def handbook_speeds(task: Task) -> Array:
    """Return the E that a handbook would give for each kind of block, mm/min; shape (kinds,)."""
    usual = USUAL_SPEEDS.get(task.name, USUAL_SPEED)
    area = np.array([kind.pick * kind.width for kind in task.kinds])
    strongest = 60.0 * SPINDLE_SHARE * task.machine.power_limit / (SPECIFIC_ENERGY * area)
    return nearest_speed(task, np.minimum(usual, strongest))

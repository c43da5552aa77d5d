"""An adviser without a model of the process, which every other one is to be as good as, on whatever machine.

    log peak power = c + f log E + g log (V' + 10),  by kind of block; least squares with forgetting

It takes the E at which the next block is expected to take 88 % of what the spindle has, at most 1.25 times the last
one. It dresses when the next part would take longer than the parts since the last dress have taken in the mean, after
a reading beyond a limit, and when a block takes 1.25 times the power of its first one since the dress at the same E,
for where the table is at its fastest, or burn is the limit, time tells nothing.
"""

from collections import defaultdict
from dataclasses import dataclass, field

import numpy as np

from grind_env.arrays import Array
from grind_env.envs.job.outline import JobChoice
from grind_env.envs.job.simulation import JobSimulation
from grind_env.machine.loops.tally import Tally
from grind_env.shop.advise.readings import MachineReadings

SHARE, RISE, DULL, FORGETTING = 0.88, 1.25, 1.25, 0.95
FIRST, SPREAD = (0.0, 0.7, 0.15), (30.0, 0.2, 0.15)
"""c, f and g before anything was read, and how well they are known."""
SCATTER = 0.05
STROKES = Tally._fields.index("strokes")


class Law:
    """The power of one kind of block."""

    def __init__(self) -> None:
        self.found, self.covariance = np.array(FIRST), np.diag(np.square(SPREAD))

    def learn(self, speed: float, volume: float, power: float) -> None:
        """Take a reading."""
        x, covariance = terms(speed, volume), self.covariance / FORGETTING
        gain = covariance @ x / (SCATTER**2 + x @ covariance @ x)
        self.found = self.found + gain * (np.log(power) - x @ self.found)
        self.covariance = covariance - np.outer(gain, x @ covariance)

    def speed(self, power: float, volume: float) -> float:
        """E, mm/min, at which it is taken."""
        c, f, g = self.found
        return float(np.exp((np.log(power) - c - g * np.log(volume + 10.0)) / max(f, 0.2)))


def terms(speed: float, volume: float) -> Array:
    """Of c, f and g."""
    return np.array([1.0, np.log(speed), np.log(volume + 10.0)])


@dataclass
class ModelFreeAdviser:
    """Decides on one batch, by what was read of it."""

    simulation: JobSimulation
    laws: dict[int, Law] = field(default_factory=lambda: defaultdict(Law))
    last: dict[int, float] = field(default_factory=dict)
    """E by kind of block, mm/min."""
    volume: float = 0.0
    """Ground since the dress, mm3/mm."""
    spent: list[float] = field(default_factory=list)
    """Seconds of the dress and of each part since."""
    fresh: dict[int, float] = field(default_factory=dict)
    """Power of the first block of a kind since the dress, W, at E = 1 mm/min."""
    due: bool = False

    def __post_init__(self) -> None:
        self.kinds = len(self.simulation.blocks) // self.simulation.parts
        self.strokes = strokes_of(self.simulation)

    def __call__(self, number: int, readings: MachineReadings | None) -> JobChoice:
        """E and D of a block."""
        block, kind, limit = self.simulation.blocks[number], number % self.kinds, self.simulation.job.limits.power
        peak = 0.0 if readings is None else readings.peak_power or 0.0
        if readings is not None and peak > 0.0:
            self._learn((number - 1) % self.kinds, peak)
            error = abs(readings.size_error or 0.0)
            self.due |= peak > limit or error > self.simulation.job.part.tolerance
        if block.starts_part:
            coming = sum(self._seconds(number + k, self._speed(number + k)) for k in range(self.kinds))
            self.due |= len(self.spent) > 1 and coming > sum(self.spent) / (len(self.spent) - 1)
        executions = 0
        if block.takes_dresses and self.due:
            executions, self.due, self.volume = 1, False, 0.0
            assert block.dress is not None
            self.spent, self.fresh = [block.dress.seconds], {}
        speed = self._speed(number)
        self.volume += block.depth * self.simulation.job.part.length
        if block.starts_part:
            self.spent.append(0.0)
        if self.spent:
            self.spent[-1] += self._seconds(number, speed)
        self.last[kind] = speed
        return JobChoice(speed, executions)

    def _learn(self, kind: int, peak: float) -> None:
        self.laws[kind].learn(self.last[kind], self.volume, peak)
        power = peak / self.last[kind] ** self.laws[kind].found[1]
        self.due |= power > DULL * self.fresh.setdefault(kind, power)

    def _speed(self, number: int) -> float:
        """E that the power allows; in a block that ends a part, of which size and Ra are asked, that of the program."""
        block, kind = self.simulation.blocks[number], number % self.kinds
        own = last = block.plan.feed
        if kind in self.last:
            last = self.last[kind]
            ground = block.depth * self.simulation.job.part.length
            own = self.laws[kind].speed(SHARE * self.simulation.job.limits.power, self.volume + ground)
        low, high = (1000.0 * end for end in self.simulation.task.action.speed_ends)
        most = block.plan.feed if block.finished else last * RISE
        return min(max(min(own, most), low), high)

    def _seconds(self, number: int, speed: float) -> float:
        plan = self.simulation.blocks[number].plan
        return float(self.strokes[number]) * 60.0 * abs(plan.primary - plan.secondary) / speed


def strokes_of(simulation: JobSimulation) -> Array:
    """Strokes of each block, which E and D do not change."""
    episodes, found = simulation.start([np.random.default_rng(0)]), []
    for block in simulation.blocks:
        _, tallies = simulation.step(episodes, np.array([block.plan.feed]), np.array([float(block.plan.dresses)]))
        found.append(tallies[0, STROKES])
    return np.array(found)

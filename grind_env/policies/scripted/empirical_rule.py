"""The rule of a shop without a model of the process: it believes what it has read on this machine, and nothing else."""

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
from grind_env.policies.scripted.handbook import handbook_speeds
from grind_env.policies.scripted.instruments import Instruments
from grind_env.policies.scripted.power_law import PowerLaw


@dataclass(kw_only=True)
class EmpiricalRule:
    """As fast as the power read on this machine allows; a dress where time or an alarm asks for it.

    It begins at the E of the handbook. E then goes to where a power law of what was read expects `share` of the
    spindle's limit at the peak of the coming block, and rises by at most the factor `step` from block to block of a
    kind. A dress is due where the next block without one would take longer than the blocks since the last dress have
    taken in the mean, that dress included: the interval at which the mean is least.

    A power or a size error beyond its limit is an alarm: the wheel is dressed, twice where it is beyond `far` times the
    limit. E is not lowered for it below that of the handbook, for slow tables burn; only where two executions have not
    brought the power below `far` times the limit, it falls by `slowing` a block, down to `floor` of the handbook's. An Ra
    beyond its limit is no alarm: a fresh wheel is no smoother than a worn one.

    Attributes:
        share: of the power limit that is planned to be used.
        step: most that E rises by.
        far: times a limit.
        slowing: of E, where nothing else helps.
        floor: of the handbook's E.
    """

    share: float = 0.88
    step: float = 1.25
    far: float = 1.2
    slowing: float = 0.9
    floor: float = 0.75
    rise: float = 1.3
    smooth: float = 0.9
    up: float = 1.01
    every: float = 1.0
    name: ClassVar[str] = "empirical_rule"
    sees: ClassVar[Sees] = "measurements"
    task: Task = field(init=False, repr=False)
    instruments: Instruments = field(init=False, repr=False)
    law: PowerLaw = field(init=False, repr=False)
    usual: Array = field(init=False, repr=False)
    """The handbook's E of each kind, mm/min, shape (kinds,)."""
    last: Array = field(init=False, repr=False)
    """That of the last block of each kind, shape (N, kinds)."""
    tolerance: Array = field(init=False, repr=False)
    """Of the part that the last block has ground, um, shape (N,)."""
    volume: Array = field(init=False, repr=False)
    """Most that a wheel had ground since its dress in the last block, if it has not been dressed in it, mm3/mm."""
    taken: Array = field(init=False, repr=False)
    """Time of the last dress and of the blocks since, s, shape (N,)."""
    blocks: Array = field(init=False, repr=False)
    """How many these are."""

    def begin(self, simulation: Simulation, episodes: int) -> None:
        """Nothing has been read, and the wheel is freshly dressed."""
        self.task, self.usual = simulation.task, handbook_speeds(simulation.task)
        self.instruments, self.law = Instruments(simulation, episodes), PowerLaw(episodes)
        self.last = np.tile(self.usual, (episodes, 1))
        self.fresh = np.zeros(episodes)
        self.ceiling = np.full(self.last.shape, np.inf)
        self.tolerance = np.full(episodes, np.inf)
        self.volume, self.blocks = np.zeros(episodes), np.zeros(episodes)
        self.taken = self._dressing(np.ones(episodes))

    def act(self, observation: NDArray[np.float32], episodes: Episodes | None) -> Decision:
        """Learn from the last block, then decide on the coming one."""
        limit, n = self.task.machine.power_limit, np.arange(len(observation))
        seen, kind = self.instruments.read(observation), self.instruments.kind
        executions = seen.get("last_executions", np.zeros(len(n)))
        removal = seen["last_pick"] * seen["last_width"] * 1000.0 * seen["last_speed"] / 60.0
        # executions stand evenly in the depth of a block: the wheel is dullest before the first one or after the last
        dullest = np.maximum(self.volume / (executions + 1.0), seen["volume"])
        self.law.learn(seen["peak_power"], removal, dullest, (seen["peak_power"] > 0.0) & (removal > 0.0))
        beyond = np.maximum(seen["peak_power"] / limit, np.abs(seen["size_error"]) / self.tolerance)
        self.tolerance = np.where(seen["tolerance"] > 0.0, seen["tolerance"], self.tolerance)

        area = np.maximum(seen["pick"] * seen["width"], 1e-9)
        stock = seen["stock"] * seen["length"] * np.array([each.stock for each in self.task.kinds])[kind]
        last, usual = self.last[n, kind], self.usual[kind]
        rough = seen["roughness"] > self.smooth
        self.ceiling[rough] = np.minimum(self.ceiling[rough], self.last[rough]) * self.slowing
        self.ceiling = np.where(rough[:,None], self.ceiling, self.ceiling * self.up)
        helpless = (seen["peak_power"] > self.far * limit) & (executions >= 2.0)
        least = np.where(helpless, np.maximum(self.slowing * last, self.floor * usual), np.minimum(last, usual))
        least = np.minimum(least, np.maximum(self.ceiling[n, kind], self.floor * usual))
        most = np.minimum(np.where(self.law.known, self.step * last, last), self.ceiling[n,kind])
        most = np.maximum(most, least)
        undressed, dressed = (
            np.clip(60.0 * self.law.removal(self.share * limit, volume) / area, least, most)
            for volume in (seen["volume"] + stock, seen["volume"] + 0.5 * stock)
        )
        longer = self._grinding(kind, undressed) * self.blocks > self.taken
        energy = seen["mean_power"] / np.maximum(removal, 1e-9)
        first = (executions > 0.0) | (self.fresh == 0.0)
        self.fresh = np.where(first & (energy > 0.0), energy, self.fresh)
        duller = (energy > self.rise * self.fresh) & (executions == 0.0)
        due = (beyond > 1.0) | duller | (rough & (self.blocks > self.every)) | (longer & (self.blocks > 0.0))
        D = np.minimum(np.where(beyond > self.far, 2.0, due), self.task.action.executions)
        E = nearest_speed(self.task, np.where(D > 0.0, dressed, undressed))

        self.last[n, kind], self.volume = E, seen["volume"] + stock
        self.taken = np.where(D > 0.0, self._dressing(D), self.taken) + self._grinding(kind, E)
        self.blocks = np.where(D > 0.0, 0.0, self.blocks) + 1.0
        return Decision(E, D)

    def _grinding(self, kinds: NDArray[np.int64], speeds: Array) -> Array:
        """Time of a block of nominal stock, s."""
        task = self.task
        return np.array([task.nominal_seconds(task.kinds[k], E / 1000.0) for k, E in zip(kinds, speeds, strict=True)])

    def _dressing(self, executions: Array) -> Array:
        """Time of so many executions, s, with what else they cost in time of the machine."""
        rates = self.task.rates
        return executions * (self.task.dress_seconds + 3600.0 * rates.dress / rates.hourly)

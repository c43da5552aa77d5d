"""Scripted policies: fixed plans of a program, and rules on measured signals.

E is in mm/min in fixed plans, decisions and the parameters of rules.
"""

from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from grind_env.array_types import Array
from grind_env.envs.actions import ActionCodec
from grind_env.envs.episode_state import Episodes
from grind_env.envs.simulation import Simulation
from grind_env.envs.tasks import Task
from grind_env.policies.choices import Decision, check_speeds, nearest_speed
from grind_env.policies.policy import Sees
from grind_env.policies.scripted.sharpness_estimator import Estimate, SharpnessEstimator

REFERENCE_AREA = 0.015  #: wear-flat area to which the parameter E of the rules refers
LOADED_AREA = 0.02  #: wear-flat area that is as dull as full loading
FRESH_VOLUME = 40.0  #: volume over which a fresh dress wears in, mm3/mm
VOLUME_SCALE = 300.0


class Estimating:
    """Base of the policies that estimate the sharpness of the wheel from measurements."""

    name: ClassVar[str]
    E: Any
    sees: ClassVar[Sees] = "measurements"

    def begin(self, simulation: Simulation, episodes: int) -> None:
        check_speeds(self.name, self.E, simulation.task)
        self.task, self.estimator = simulation.task, SharpnessEstimator(simulation, episodes)


@dataclass
class Random:
    """Random draws, uniform in the action space `box`: E geometric over its range, D = 0 in two of three blocks."""

    seed: int = 0
    name: ClassVar[str] = "random"
    sees: ClassVar[Sees] = "measurements"

    def begin(self, simulation: Simulation, episodes: int) -> None:
        self.codec = ActionCodec(simulation.task)
        self.rng = np.random.default_rng(self.seed)

    def act(self, observation: NDArray[np.float32], episodes: Episodes | None) -> Decision:
        return Decision(*self.codec.decode(self.rng.uniform(-1.0, 1.0, (len(observation), 2))))


@dataclass
class Fixed:
    """A fixed plan: E constant, mm/min, D executions in every `every`-th block and none in the others."""

    E: float
    D: int
    every: int = 1
    name: str = "constant"
    sees: ClassVar[Sees] = "measurements"

    def begin(self, simulation: Simulation, episodes: int) -> None:
        check_speeds(self.name, self.E, simulation.task, within=True)
        self.task, self.block = simulation.task, 0

    def act(self, observation: NDArray[np.float32], episodes: Episodes | None) -> Decision:
        self.block += 1
        n = len(observation)
        dresses = self.D if self.block % self.every == 0 else 0
        return Decision(nearest_speed(self.task, np.full(n, self.E)), np.full(n, float(dresses)))


@dataclass
class ConstantPerKind(Estimating):
    """One E and one D for each kind of block."""

    E: tuple[float, ...]
    D: tuple[int, ...]
    name: ClassVar[str] = "constant_per_kind"

    def act(self, observation: NDArray[np.float32], episodes: Episodes | None) -> Decision:
        kind = self.estimator.update(observation).kind.astype(np.int64)
        return Decision(nearest_speed(self.task, np.array(self.E)[kind]), np.array(self.D, np.float64)[kind])


@dataclass
class PowerThreshold:
    """Rule of a power monitor: dress on a threshold, slow down near the limit.

    The mean power of a block over its removal rate is a specific energy, J/mm3. Above `upper` the rule begins to dress,
    one execution a block, until the energy is below `lower` times `upper`. E is lowered in proportion if the power at E
    would exceed `share` of the limit.
    """

    E: float
    upper: float
    lower: float
    share: float
    name: ClassVar[str] = "power_threshold"
    sees: ClassVar[Sees] = "measurements"

    def begin(self, simulation: Simulation, episodes: int) -> None:
        check_speeds(self.name, self.E, simulation.task)
        self.task, self.simulation = simulation.task, simulation
        self.dressing = np.zeros(episodes, bool)

    def act(self, observation: NDArray[np.float32], episodes: Episodes | None) -> Decision:
        seen = self.simulation.read(observation)
        power, last_speed = seen["mean_power"], np.maximum(seen["last_speed"], 1.0)
        removal = np.maximum(seen["last_pick"] * seen["last_width"], 1e-9) * last_speed / 60.0
        energy = power / removal
        self.dressing = energy > np.where(self.dressing, self.lower * self.upper, self.upper)
        expected = power * self.E / last_speed
        slowing = np.minimum(1.0, self.share * self.task.machine.power_limit / np.maximum(expected, 1.0))
        return Decision(nearest_speed(self.task, self.E * slowing), self.dressing.astype(np.float64))


@dataclass(kw_only=True)
class SpeedLaw:
    """E from sharpness; see `AdaptiveRule` for the symbols.

        ln E = ln E[kind] + gA x + gF exp(-V / 40) + gH h + gP p + gB q + ...
        x = ln(A / 0.015)

    gP is useful only in a task with due dates, and gB only in a task whose wheel is changed.
    """

    E: tuple[float, ...]  #: E at the reference sharpness, mm/min, by kind of block
    gA: float
    gF: float
    gH: float
    gP: float = 0.0
    gB: float = 0.0
    task: Task = field(init=False, repr=False)

    def speeds(self, seen: Estimate, faster: Array) -> Array:
        """Return E, mm/min; `faster` is the sum of the further terms of ln E."""
        faster = faster + self.gP * seen.pressed + self.gB * seen.thrift
        x, h, fresh = relative_sharpness(seen), relative_stock(seen), np.exp(-seen.volume / FRESH_VOLUME)
        ln_E = np.log(self.E)[seen.kind.astype(np.int64)] + self.gA * x + self.gF * fresh + self.gH * h + faster
        return nearest_speed(self.task, np.exp(ln_E))


@dataclass(kw_only=True)
class DressLaw:
    """D from sharpness; see `AdaptiveRule` for the symbols.

        D = 1 if x + wV V / 300 + wH h + wP p + wB q + ... > ln(A_dress[kind] / 0.015), else 0

    wP is useful only in a task with due dates, and wB only in a task whose wheel is changed.
    """

    A_dress: tuple[float, ...]  #: wear-flat area above which to dress, by kind of block
    wV: float
    wH: float
    wP: float = 0.0
    wB: float = 0.0

    def executions(self, seen: Estimate, duller: Array) -> Array:
        """Return D; `duller` is the sum of the further terms of the dress criterion."""
        duller = duller + self.wP * seen.pressed + self.wB * seen.thrift
        x, h = relative_sharpness(seen), relative_stock(seen)
        threshold = np.log(np.array(self.A_dress) / REFERENCE_AREA)[seen.kind.astype(np.int64)]
        return np.asarray(x + self.wV * seen.volume / VOLUME_SCALE + self.wH * h + duller > threshold, np.float64)


@dataclass(kw_only=True)
class SharpnessRule(SpeedLaw, DressLaw):
    """Base of the rules on sharpness, with a law for E and a law for D."""

    def decide(self, seen: Estimate, faster: Array, duller: Array) -> Decision:
        """Return E and D; `faster` and `duller` are the further terms of ln E and of the dress criterion."""
        return Decision(self.speeds(seen, faster), self.executions(seen, duller))


def relative_sharpness(seen: Estimate) -> Array:
    """Return the log of the wear-flat area over the reference area."""
    return np.asarray(np.log(seen.wear_flat / REFERENCE_AREA))


def relative_stock(seen: Estimate) -> Array:
    """Return the log of the pre-gauged stock over the nominal stock."""
    # after the last block there is no stock, but that decision is not used
    return np.asarray(np.log(np.maximum(seen.stock, 0.1)))


@dataclass(kw_only=True)
class AdaptiveRule(Estimating, SharpnessRule):
    """Rule for E and D from the estimated sharpness, the volume V since the dress and the lot severity.

    Further symbols: h is the log of the pre-gauged stock over the nominal stock, p the log of the work over the time
    left to the next due date, and q the log of the dress executions over the blocks left.
    """

    gS: float
    wS: float
    name: ClassVar[str] = "adaptive_rule"

    def act(self, observation: NDArray[np.float32], episodes: Episodes | None) -> Decision:
        seen = self.estimator.update(observation)
        return self.decide(seen, self.gS * seen.severity, self.wS * seen.severity)


@dataclass(kw_only=True)
class AdaptiveSpeed(Estimating, SpeedLaw):
    """Rule with E as in `AdaptiveRule` and D executions in every `every`-th block.

    Its saving on the best fixed plan is the value of adapting E; the further saving of `AdaptiveRule` is that of
    adapting D.
    """

    gS: float
    D: int
    every: int
    name: ClassVar[str] = "adaptive_speed"

    def begin(self, simulation: Simulation, episodes: int) -> None:
        super().begin(simulation, episodes)
        self.plan = Fixed(self.task.action.speed_ends[0], self.D, self.every)  # only its D counts
        self.plan.begin(simulation, episodes)

    def act(self, observation: NDArray[np.float32], episodes: Episodes | None) -> Decision:
        seen = self.estimator.update(observation)
        return self.plan.act(observation, episodes)._replace(speeds=self.speeds(seen, self.gS * seen.severity))


@dataclass(kw_only=True)
class AdaptiveDress(Estimating, DressLaw):
    """Rule with D as in `AdaptiveRule` and one E for all blocks, as in a fixed plan.

    Its saving on the best fixed plan is the value of adapting D; the further saving of `AdaptiveRule` is that of
    adapting E.
    """

    E: float  #: E of all blocks, mm/min
    wS: float  #: coefficient of the lot severity in the dress criterion
    name: ClassVar[str] = "adaptive_dress"

    def act(self, observation: NDArray[np.float32], episodes: Episodes | None) -> Decision:
        seen = self.estimator.update(observation)
        speeds = nearest_speed(self.task, np.full(len(observation), self.E))
        return Decision(speeds, self.executions(seen, self.wS * seen.severity))

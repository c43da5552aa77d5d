"""A guard for any policy: while readings are not as they were forecast, a rule decides that believes these alone."""

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from grind_env.arrays import Array, Numbers
from grind_env.envs.episodes import Episodes
from grind_env.envs.simulation import Simulation
from grind_env.policies.choices import Decision, nearest_speed, speed_bounds
from grind_env.policies.policy import Policy, Sees
from grind_env.policies.scripted.empirical_rule import SLOWING, EmpiricalRule
from grind_env.policies.watch import Watch

SHORTEST, LONGER = 4.0, 2.0
"""Blocks that a first alarm lasts at least, and how many times longer each further one: with every block that a policy
was wrong on, it has to be right on more."""
STEP = 1.25
"""Most that E rises from block to block when a policy comes back."""
HOT = 0.82
"""Burn ratio from which a wheel counts as too dull while the model is in doubt: the forecast that it rests on is up to
a fifth too low where the loop gives more, or forces follow other laws."""
COOLS = 0.5
"""Exponent of power over E above which a slower table is cooler: the heat flows off as the root of E (Jaeger)."""
FORGIVEN = 1.005
"""Factor on an E that was too high, with every block of its kind: some twenty later it is tried again."""
SLOWEST = 0.5
"""Of the first E, below which no heat and no limit brings it."""


@dataclass
class Guarded:
    """A policy, and in its place the empirical rule while the machine is not what the model says.

    A reading beyond its limit that was not to be expected, or a run of readings that come nearer to their limits than
    forecast, is an alarm. It lasts until forecasts hold again, and for a time that grows with every alarm. The
    rule has learned from the first block on. When the policy comes back, its E rises step by step.

    Attributes:
        policy: is guarded.
        rule: decides in its place.
        step: most that E rises by when the policy comes back; above what has been tried, if cautious.
        cautious: as at a machine of which nobody knows how far it is the model: E is at most such a step above what
            has been tried, and no higher than the rule has found parts to be good at; any reading beyond its limit, or
            a power that burns, is an alarm, expected or not, and its E is not used again for a while. Once there was
            one, or while readings are off their forecasts either way, the wheel is dressed where policy or rule ask for
            it, and sooner where it has come near burning; one that did so freshly dressed had too high an E.
        residual: as of `Watch`.
    """

    policy: Policy
    rule: EmpiricalRule = field(default_factory=EmpiricalRule)
    step: float = STEP
    cautious: bool = False
    residual: float = 0.0
    simulation: Simulation = field(init=False, repr=False)
    watch: Watch = field(init=False, repr=False)
    alarmed: NDArray[np.bool_] = field(init=False, repr=False)
    """Where the rule decides, shape (N,)."""
    left: Array = field(init=False, repr=False)
    """Blocks that it does so at least."""
    stay: Array = field(init=False, repr=False)
    """Those of a further alarm."""
    returning: NDArray[np.bool_] = field(init=False, repr=False)
    """Where the policy comes back."""
    tried: Array = field(init=False, repr=False)
    """Highest E of each kind of block so far, mm/min, shape (N, kinds)."""
    ceiling: Array = field(init=False, repr=False)
    """Highest E of each that is not known to be too high, likewise."""
    age: Array = field(init=False, repr=False)
    """Parts begun since the wheel was dressed, as the last block met it, shape (N,)."""
    PREFIX: ClassVar[str] = "guarded:"

    @property
    def name(self) -> str:
        """That of the policy, as guarded."""
        return f"{self.PREFIX}{self.policy.name}"

    @property
    def sees(self) -> Sees:
        """What the policy sees."""
        return self.policy.sees

    def begin(self, simulation: Simulation, episodes: int) -> None:
        """Trust the policy."""
        self.simulation, self.watch = simulation, Watch(simulation, episodes, self.residual)
        self.policy.begin(simulation, episodes)
        self.rule.begin(simulation, episodes)
        self.alarmed, self.returning = np.zeros(episodes, bool), np.zeros(episodes, bool)
        self.wary, self.slowest, self.dressed, self.held = np.zeros((4, episodes), bool)
        self.age = np.zeros(episodes)
        self.tried = np.tile(self.rule.first, (episodes, 1))
        self.ceiling = np.full_like(self.tried, np.inf)
        self.left, self.stay = np.zeros(episodes), np.full(episodes, SHORTEST)

    def act(self, observation: NDArray[np.float32], episodes: Episodes | None) -> Decision:
        """Let both decide, and take the one that is trusted."""
        task, n = self.simulation.task, np.arange(len(observation))
        own = self.policy.act(observation, episodes)
        self.rule.learn(observation)
        self.watch.update(observation, self.rule.power)
        alarm = self.watch.alarm | self._judged(observation, n) if self.cautious else self.watch.alarm
        safe, kind = self.rule.decide(observation), self.rule.kind
        raised = alarm & ~self.alarmed
        self.left = np.where(raised, self.stay, np.maximum(self.left - 1.0, 0.0))
        self.stay = np.where(raised, LONGER * self.stay, self.stay)
        over = self.alarmed & (self.left == 0.0) & self.watch.holds
        self.alarmed = (self.alarmed | raised) & ~over
        most = nearest_speed(task, self.step * (self.tried if self.cautious else self.rule.speeds)[n, kind])
        self.returning = (self.returning | over | self.cautious) & ~self.alarmed & (own.speeds > most)
        wary = self.wary = self.cautious & (self.watch.doubt | (self.stay > SHORTEST))
        speeds = np.where(self.returning, most, own.speeds)
        speeds = np.where(self.cautious, np.minimum(speeds, nearest_speed(task, self.rule.good)), speeds)
        dresses = np.where(wary, np.maximum(own.executions, safe.executions), own.executions)
        E, D = np.where(self.alarmed, safe.speeds, speeds), np.where(self.alarmed, safe.executions, dresses)
        self.held = self.ceiling[n, kind] < E
        E = nearest_speed(task, np.where(self.held, self.ceiling[n, kind], E))
        # an execution stands within its block: what the block took was up to a wheel that had not been dressed yet
        self.age = np.where(self.dressed, 0.0, self.age) + self.rule.row.starts_part
        self.dressed = D > 0.0
        self.slowest = self.watch.beyond & (speed_bounds(task)[0] >= E) & (D > 0.0)
        return Decision(E, D)

    def _judged(self, observation: NDArray[np.float32], n: Numbers) -> NDArray[np.bool_]:
        """Take the last block as evidence of E and wheel; where it was beyond a limit, shape (N,)."""
        kind, heat = self.rule.kind, self.watch.heat
        beyond, hot = self.watch.beyond | (heat > 1.0), (heat > HOT) & (self.alarmed | self.wary)
        # a wheel that was dressed in the part before is hot by its dullness or by E: both are taken for the reason
        self.rule.dulled(hot & (self.age >= 1.0), HOT)
        E, ceiling = self.rule.speeds[n, kind], self.ceiling[n, kind]
        slower = (beyond | (hot & (self.age <= 1.0))) & (self.rule.power.found[:, 1] > COOLS)
        lower = np.maximum(SLOWING * np.minimum(E, ceiling), SLOWEST * self.rule.first[kind])
        self.ceiling[n, kind] = np.where(slower, lower, FORGIVEN * ceiling)
        self.tried[n, kind] = np.maximum(self.tried[n, kind], E)
        return np.asarray(beyond)

    def said(self, machine: int) -> list[str]:
        """What it notices of a machine and does for it, in sentences; nothing while the policy is trusted."""
        found = [f"alarm: {each}" for each in self.watch.said(machine)]
        if self.alarmed[machine]:
            stays = f"{self.left[machine]:.0f} blocks at least, and until" if self.left[machine] > 0.0 else "until"
            found.append(
                f"{self.rule.name} decides in place of {self.policy.name}, on what was read here alone, for {stays} "
                "forecasts hold again"
            )
        elif self.wary[machine]:
            error = f"readings are {self.watch.error[machine]:.1f} standard deviations off their forecasts"
            why = error if self.watch.doubt[machine] else "there was an alarm before"
            found.append(f"{why}: no faster and no duller than what has worked here")
        elif self.returning[machine]:
            than = "has been tried here" if self.cautious else "the last block of its kind had"
            found.append(f"{self.policy.name} would be faster, but E is at most {self.step:g} times what {than}")
        kind = self.rule.kind[machine]
        if self.cautious and (self.alarmed | self.wary)[machine] and self.watch.heat[machine] > HOT:
            found.append(
                f"the last block took {self.watch.heat[machine]:.2f} of the power at which the work burns: from "
                f"{HOT:g} on the wheel is dressed before the next part, and E goes down where it had just been"
            )
        if self.held[machine]:
            found.append(
                f"E is at most {self.ceiling[machine, kind]:.0f} mm/min: faster than that, a block came beyond a "
                "limit or near burning"
            )
        if self.slowest[machine]:
            found.append("it stands at the slowest E with dresses: more than that no E and D can do here")
        return found


def guarded(policy: Policy) -> Guarded:
    """The policy with a guard.

    Example:
        >>> from grind_env.policies import guarded
        >>> from grind_env.policies.scripted.handbook import Handbook
        >>> guarded(Handbook()).name
        'guarded:handbook'
    """
    return Guarded(policy)

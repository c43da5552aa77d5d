"""A guard for any policy: while readings are not as they were forecast, a rule decides that believes these alone."""

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from grind_env.arrays import Array
from grind_env.envs.episodes import Episodes
from grind_env.envs.simulation import Simulation
from grind_env.policies.choices import Decision, nearest_speed, speed_bounds
from grind_env.policies.policy import Policy, Sees
from grind_env.policies.scripted.empirical_rule import EmpiricalRule
from grind_env.policies.watch import Watch

SHORTEST, LONGER = 4.0, 2.0
"""Blocks that a first alarm lasts at least, and how many times longer each further one: with every block that a policy
was wrong on, it has to be right on more."""
STEP = 1.25
"""Most that E rises from block to block when a policy comes back."""


@dataclass
class Guarded:
    """A policy, and in its place the empirical rule while the machine is not what the model says.

    A reading beyond its limit that was not to be expected, or a run of readings that come nearer to their limits than
    forecast, is an alarm. It lasts until forecasts hold again, and for a time that grows with every alarm. The
    rule has learned from the first block on. When the policy comes back, its E rises step by step.

    Attributes:
        policy: is guarded.
        rule: decides in its place.
        step: most that E rises by when the policy comes back.
        cautious: as at a machine of which nobody knows how far it is the model: E of the policy rises by such steps
            from the beginning; any reading beyond its limit is an alarm, expected or not; and once there was one, or
            while readings are off their forecasts either way, the wheel is dressed where policy or rule ask for it, and
            E is no higher than the rule has found parts to be good at.
    """

    policy: Policy
    rule: EmpiricalRule = field(default_factory=EmpiricalRule)
    step: float = STEP
    cautious: bool = False
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
        self.simulation, self.watch = simulation, Watch(simulation, episodes)
        self.policy.begin(simulation, episodes)
        self.rule.begin(simulation, episodes)
        self.alarmed, self.returning = np.zeros(episodes, bool), np.zeros(episodes, bool)
        self.wary, self.slowest = np.zeros((2, episodes), bool)
        self.left, self.stay = np.zeros(episodes), np.full(episodes, SHORTEST)

    def act(self, observation: NDArray[np.float32], episodes: Episodes | None) -> Decision:
        """Let both decide, and take the one that is trusted."""
        own, safe = self.policy.act(observation, episodes), self.rule.act(observation, None)
        self.watch.update(observation, self.rule.power)
        alarm = self.watch.alarm | self.watch.beyond if self.cautious else self.watch.alarm
        raised = alarm & ~self.alarmed
        self.left = np.where(raised, self.stay, np.maximum(self.left - 1.0, 0.0))
        self.stay = np.where(raised, LONGER * self.stay, self.stay)
        over = self.alarmed & (self.left == 0.0) & self.watch.holds
        self.alarmed = (self.alarmed | raised) & ~over
        most = nearest_speed(self.simulation.task, self.step * self.rule.speeds[np.arange(len(over)), self.rule.kind])
        self.returning = (self.returning | over | self.cautious) & ~self.alarmed & (own.speeds > most)
        wary = self.wary = self.cautious & (self.watch.doubt | (self.stay > SHORTEST))
        speeds = np.where(self.returning, most, own.speeds)
        good = nearest_speed(self.simulation.task, self.rule.good)
        speeds = np.where(wary, np.minimum(speeds, good), speeds)
        dresses = np.where(wary, np.maximum(own.executions, safe.executions), own.executions)
        E, D = np.where(self.alarmed, safe.speeds, speeds), np.where(self.alarmed, safe.executions, dresses)
        self.slowest = self.watch.beyond & (speed_bounds(self.simulation.task)[0] >= E) & (D > 0.0)
        return Decision(E, D)

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
            found.append(f"{error} or have been beyond a limit: no faster and no duller than what has worked here")
        elif self.returning[machine]:
            found.append(f"{self.policy.name} would be faster, but E rises by {self.step:g} times a block at most")
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

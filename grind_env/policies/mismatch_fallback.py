"""A guard for any policy: while readings differ from the forecasts, a rule on readings alone decides."""

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from grind_env.envs.episode_state import Episodes
from grind_env.envs.simulation import Simulation
from grind_env.policies.choices import Decision, nearest_speed
from grind_env.policies.mismatch_alarms import Watch
from grind_env.policies.policy import Policy, Sees
from grind_env.policies.scripted.empirical_rule import EmpiricalRule

#: least length of the first alarm, blocks, and factor by which each further alarm is longer: a policy that was wrong
#: more often has to be right for longer
SHORTEST, LONGER = 4.0, 2.0
STEP = 1.25  #: largest factor by which E rises from block to block when a policy returns


@dataclass
class Guarded:
    """Policy replaced by the empirical rule while the machine differs from the model.

    An alarm is an unexpected reading beyond its limit, or a run of readings nearer to their limits than forecast. It
    lasts until forecasts hold again, plus a time that grows with every alarm. The rule learns from the first block on.
    When the policy returns, its E rises step by step.
    """

    policy: Policy
    rule: EmpiricalRule = field(default_factory=EmpiricalRule)  #: the rule that replaces it
    PREFIX: ClassVar[str] = "guarded:"

    @property
    def name(self) -> str:
        return f"{self.PREFIX}{self.policy.name}"

    @property
    def sees(self) -> Sees:
        return self.policy.sees

    def begin(self, simulation: Simulation, episodes: int) -> None:
        self.simulation, self.watch = simulation, Watch(simulation, episodes)
        self.policy.begin(simulation, episodes)
        self.rule.begin(simulation, episodes)
        # episodes in which the rule decides, and episodes in which the policy returns
        self.alarmed, self.returning = np.zeros(episodes, bool), np.zeros(episodes, bool)
        # least number of blocks that the rule still decides, and least length of the next alarm, blocks
        self.left, self.stay = np.zeros(episodes), np.full(episodes, SHORTEST)

    def act(self, observation: NDArray[np.float32], episodes: Episodes | None) -> Decision:
        task, n = self.simulation.task, np.arange(len(observation))
        own = self.policy.act(observation, episodes)
        self.rule.update(observation)
        self.watch.update(observation, self.rule.power)
        safe, kind = self.rule.decide(observation), self.rule.kind
        raised = self.watch.alarm & ~self.alarmed
        self.left = np.where(raised, self.stay, np.maximum(self.left - 1.0, 0.0))
        self.stay = np.where(raised, LONGER * self.stay, self.stay)
        over = self.alarmed & (self.left == 0.0) & self.watch.holds
        self.alarmed = (self.alarmed | raised) & ~over
        most = nearest_speed(task, STEP * self.rule.speeds[n, kind])
        self.returning = (self.returning | over) & ~self.alarmed & (own.speeds > most)
        speeds = np.where(self.returning, most, own.speeds)
        E = nearest_speed(task, np.where(self.alarmed, safe.speeds, speeds))
        return Decision(E, np.where(self.alarmed, safe.executions, own.executions))


def guarded(policy: Policy) -> Guarded:
    """Return the policy with a guard.

    Example:
        >>> from grind_env.policies import guarded
        >>> from grind_env.policies.scripted.handbook import Handbook
        >>> guarded(Handbook()).name
        'guarded:handbook'
    """
    return Guarded(policy)

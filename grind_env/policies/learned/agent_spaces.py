"""Observations and actions of a learning agent.

An agent sees the measured observation and a memory of the episode; one observation says little of lot and wheel:

* `belief`: the estimates of the scripted rules, and the belief about the wheel (`grind_env.belief`);
* `stack`: the last observations, unchanged;
* `none`: nothing, for agents with a recurrent network, or to measure the value of a memory.

An agent chooses E and D as two integers, because a Gaussian policy does not suit a whole number of dresses.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from grind_env.envs.actions import ActionCodec
from grind_env.envs.observation_memory import BeliefMemory, StackMemory, belief_entries
from grind_env.envs.observations import bounds
from grind_env.envs.simulation import Simulation
from grind_env.policies.choices import Decision
from grind_env.policies.scripted.rules import REFERENCE_AREA
from grind_env.policies.scripted.sharpness_estimator import MEMORY, Estimate, LotMemory, SharpnessEstimator

MemoryKind = Literal["belief", "stack", "none"]  #: memory of a learner
GRID = "multidiscrete"  #: form of the action in `grind_env.envs.actions`

MEMBERS = 16  #: number of members of the belief's ensemble
STACKED = 8  #: number of observations in a stack
FEATURE_BOUND = 30.0
LEAST_AREA = 1e-4  #: least believed wear-flat area in the features; smaller areas count as this one

BLOCKS_KNOWN = LotMemory._fields.index("blocks")
#: empty action space for the stack, because the observation shows E and D of the last block
NO_ACTION: spaces.Box[np.float32] = spaces.Box(-1.0, 1.0, (0,), np.float32)

Flags = NDArray[np.bool_]
Features = NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class LearnerForm:
    """Observations and actions of an agent with a memory, for any simulation of its task."""

    memory: MemoryKind

    def view(self, simulation: Simulation) -> LearnerView:
        return LearnerView(simulation, self.memory)


class LearnerView:
    """Features and actions of N episodes of a simulation.

    Args:
        simulation: simulation of the environment, which shows the measurements.
        memory: kind of memory.
    """

    def __init__(self, simulation: Simulation, memory: MemoryKind = "belief") -> None:
        entries = simulation.entries
        self.task, self.entries = simulation.task, entries
        self.codec = ActionCodec(simulation.task, GRID)
        assert isinstance(self.codec.space, spaces.MultiDiscrete)
        self.action_space = self.codec.space
        self.estimator = SharpnessEstimator(simulation) if memory == "belief" else None
        self.belief = BeliefMemory(simulation, MEMBERS) if memory == "belief" else None
        measured = spaces.Box(*bounds(entries), dtype=np.float32)
        self.stack = StackMemory(measured, NO_ACTION, STACKED) if memory == "stack" else None
        self.wear_flat_scale = belief_entries()[0].scale
        self.begin(1)
        width = self.features(np.zeros((1, len(entries)), np.float32)).shape[1]
        self.observation_space = spaces.Box(-FEATURE_BOUND, FEATURE_BOUND, (width,), np.float32)

    def begin(self, n: int) -> None:
        for memory in (self.estimator, self.belief, self.stack):
            if memory is not None:
                memory.begin(n)

    def restart(self, mask: Flags) -> None:
        """Restart the episodes in `mask`, shape (N,), with their next observation."""
        for memory in (self.estimator, self.belief, self.stack):
            if memory is not None:
                memory.restart(mask)

    def features(self, observation: NDArray[np.float32], mask: Flags | None = None) -> Features:
        """Return the features after the measured observation before a block.

        Args:
            observation: shape (N, entries).
            mask: episodes with a new observation, shape (N,); all by default. The other episodes stay unchanged, and
                their features have no meaning.

        Returns:
            Features, shape (N, features), in a new array.
        """
        chosen = np.ones(len(observation), bool) if mask is None else mask
        if self.stack is not None:
            stacked: Features = self.stack.take(observation, None, chosen)
            return stacked
        if self.estimator is None or self.belief is None:
            return observation.astype(np.float32)
        estimates = _estimates(self.estimator, observation, chosen)
        # the result is the observation, followed by the belief
        belief = self.belief.take(observation, None, chosen)[:, observation.shape[1] :]
        area = np.maximum(self.wear_flat_scale * belief[:, :1], LEAST_AREA)
        parts = observation, estimates, belief, np.log(area / REFERENCE_AREA)
        return np.concatenate(parts, axis=1, dtype=np.float32)

    def decide(self, actions: NDArray[np.int64]) -> Decision:
        """Return E in mm/min and D of a batch of actions, shape (N, 2)."""
        return Decision(*self.codec.decode(actions))


def _estimates(estimator: SharpnessEstimator, observation: NDArray[np.float32], chosen: Flags) -> Features:
    """Return the estimates of the scripted rules as features; episodes outside `chosen` stay unchanged."""
    memory, kind = estimator.memory.copy(), estimator.kind
    estimate: Estimate = estimator.update(observation)
    if not chosen.all():
        estimator.memory[~chosen] = memory[~chosen]
        estimator.kind[~chosen] = kind[~chosen]
    columns = (
        np.log(estimate.wear_flat / REFERENCE_AREA),
        estimate.severity,
        np.minimum(estimator.memory[:, BLOCKS_KNOWN], MEMORY) / MEMORY,
        np.log1p(estimate.volume / 50.0),
    )
    return np.stack(columns, axis=1).astype(np.float32)

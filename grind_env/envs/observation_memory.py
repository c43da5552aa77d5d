"""Memories of past observations, for any number of episodes side by side.

A memory is a stack of past observations or a belief of the hidden state of the wheel. `wrappers.py` puts memories
around environments; an agent that steps episodes itself can use a memory, too.
"""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from grind_env.array_types import Array
from grind_env.belief.wheel_belief import WheelBelief
from grind_env.envs.filter_members import MemberModel
from grind_env.envs.observations import Reading, bounds
from grind_env.envs.simulation import Simulation
from grind_env.errors import GrindError

Flags = NDArray[np.bool_]


class WrapperError(GrindError):
    """An environment that a wrapper cannot wrap, or a bad argument."""


class EpisodeMemory(Protocol):
    """Memory of N episodes, which gives one flat observation for each."""

    space: spaces.Box[np.float32]  #: space of one episode

    def begin(self, n: int) -> None:
        """Begin N episodes with the next observations."""

    def restart(self, mask: Flags) -> None:
        """Begin the episodes in `mask`, shape (N,), with their next observation."""

    def take(self, observations: Array, actions: Array | None, mask: Flags) -> Array:
        """Add observations of the episodes in `mask`, with the actions that led to them, to the memory.

        Args:
            observations: shape (N, entries).
            actions: batch of N actions; None after a reset.
            mask: shape (N,); the other episodes stay as they are.

        Returns:
            Observations of the wrapped environment, a new array of shape (N, entries of `space`), float32.
        """


class StackMemory:
    """The last n observations, each with the action that led to it, oldest first; zeros before the episode began."""

    def __init__(self, observation_space: spaces.Space[Any], action_space: spaces.Space[Any], n: int) -> None:
        if n < 1:
            raise WrapperError(f"n is {n}, but must be at least 1")
        if not isinstance(observation_space, spaces.Box) or len(observation_space.shape) != 1:
            raise WrapperError(f"the observation space is {observation_space}, but must be a Box with one axis")
        self.n = n
        self.action_space = action_space
        low, high = action_bounds(action_space)
        # zeros fill the stack before the episode begins
        lowest = np.minimum(np.concatenate([observation_space.low, low]), 0.0).astype(np.float32)
        highest = np.maximum(np.concatenate([observation_space.high, high]), 0.0).astype(np.float32)
        self.space = spaces.Box(np.tile(lowest, n), np.tile(highest, n), dtype=np.float32)
        self.entries = observation_space.shape[0]
        self.begin(0)

    def begin(self, n: int) -> None:
        self.stack = np.zeros((n, self.n, self.space.shape[0] // self.n), np.float32)

    def restart(self, mask: Flags) -> None:
        self.stack[mask] = 0.0

    def take(self, observations: Array, actions: Array | None, mask: Flags) -> Array:
        self.stack[mask, :-1] = self.stack[mask, 1:]
        self.stack[mask, -1, : self.entries] = observations[mask]
        self.stack[mask, -1, self.entries :] = 0.0
        if actions is not None:
            self.stack[mask, -1, self.entries :] = action_numbers(self.action_space, actions)[mask]
        return self.stack.reshape(len(mask), -1).copy()


def belief_entries() -> tuple[Reading, ...]:
    """Return the observation entries of a belief."""
    return (
        Reading("belief_wear_flat", "", 0.0, 0.05, 0.0, 5.0, "belief", "mean of the wear-flat area A"),
        Reading("belief_wear_flat_spread", "", 0.0, 0.05, 0.0, 5.0, "belief", "its standard deviation"),
        Reading("belief_growth", "ln", 0.0, 1.0, -5.0, 5.0, "belief", "mean log factor on wear-flat growth"),
        Reading("belief_growth_spread", "ln", 0.0, 1.0, 0.0, 5.0, "belief", "its standard deviation"),
        Reading("belief_pressure", "ln", 0.0, 1.0, -5.0, 5.0, "belief", "mean log factor on wear-flat pressure"),
        Reading("belief_pressure_spread", "ln", 0.0, 1.0, 0.0, 5.0, "belief", "its standard deviation"),
        Reading("belief_burnt", "", 0.0, 1.0, 0.0, 1.0, "belief", "probability that the last block burnt the part"),
    )


class BeliefMemory:
    """The observation, followed by the belief of `WheelBelief`."""

    def __init__(self, simulation: Simulation, members: int) -> None:
        self.belief = WheelBelief(MemberModel(simulation), members)
        entries, added = simulation.entries, belief_entries()
        self.low, self.high = bounds(added)
        self.scale = np.array([entry.scale for entry in added])
        self.space = spaces.Box(*bounds((*entries, *added)), dtype=np.float32)
        self.begin(0)

    def begin(self, n: int) -> None:
        self.belief.begin(n)
        self.shown = np.zeros((n, self.space.shape[0]), np.float32)

    def restart(self, mask: Flags) -> None:
        self.belief.restart(mask)

    def take(self, observations: Array, actions: Array | None, mask: Flags) -> Array:
        belief = np.stack(self.belief.update(observations, mask), axis=1)
        scaled = np.clip(belief / self.scale, self.low, self.high)
        self.shown[mask] = np.concatenate([observations, scaled], axis=1)[mask]
        return self.shown.copy()


def action_bounds(space: spaces.Space[Any]) -> tuple[Array, Array]:
    """Return the lowest and highest numbers in results of `action_numbers`."""
    if isinstance(space, spaces.Box) and len(space.shape) == 1:
        return space.low, space.high
    if isinstance(space, spaces.Discrete):
        return np.array([0.0]), np.array([1.0])
    if isinstance(space, spaces.MultiDiscrete) and len(space.shape) == 1:
        return np.zeros(space.shape), np.ones(space.shape)
    raise WrapperError(f"the action space is {space}, but must be a Discrete, or a Box or MultiDiscrete with one axis")


def action_numbers(space: spaces.Space[Any], actions: Array) -> Array:
    """Return a batch of actions as numbers, shape (N, entries); a discrete choice is divided by the last choice."""
    values = np.asarray(actions, np.float64).reshape(len(actions), -1)
    if isinstance(space, spaces.Box):
        return np.clip(values, space.low, space.high)
    if isinstance(space, spaces.Discrete):
        values = (values - space.start) / max(space.n - 1, 1)
    elif isinstance(space, spaces.MultiDiscrete):
        values = (values - space.start) / np.maximum(space.nvec - 1, 1)
    return values

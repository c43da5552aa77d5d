"""Description of an environment's observation, stored in its observation space.

A library that saves a model also saves the spaces of its training. So the file of a model tells its task and wrappers,
and the model can get the same observations again without the environment.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Protocol, TypeAlias

import numpy as np
from gymnasium import spaces

from grind_env.array_types import Array
from grind_env.envs.observation_memory import BeliefMemory, EpisodeMemory, Flags, StackMemory
from grind_env.envs.observations import Reading, bounds
from grind_env.envs.simulation import Simulation
from grind_env.task_version import TASK_VERSION

Space: TypeAlias = spaces.Space[Any]

CLIP = 10.0  #: standard deviations at which a standardised entry is cut


class MemoryForm(Protocol):
    """Form of the memory that a wrapper adds to the observation."""

    def memory(self, simulation: Simulation | None, observations: Space, actions: Space) -> EpisodeMemory:
        """Return the memory, from the spaces of one observation and of one action."""


@dataclass(frozen=True, slots=True)
class Stack:
    """The last `n` observations and actions."""

    n: int

    def memory(self, simulation: Simulation | None, observations: Space, actions: Space) -> EpisodeMemory:
        return StackMemory(observations, actions, self.n)


@dataclass(frozen=True, slots=True)
class BeliefForm:
    """The observation, followed by the belief of an ensemble of `members` members."""

    members: int

    def memory(self, simulation: Simulation | None, observations: Space, actions: Space) -> EpisodeMemory:
        assert simulation is not None
        return BeliefMemory(simulation, self.members)


@dataclass(frozen=True, slots=True)
class Standard:
    """Standardisation: every entry less its mean, over its standard deviation, cut at `CLIP`; no units."""

    mean: tuple[float, ...]
    deviation: tuple[float, ...]

    def memory(self, simulation: Simulation | None, observations: Space, actions: Space) -> EpisodeMemory:
        assert isinstance(observations, spaces.Box)
        return StandardMemory(observations, np.array(self.mean), np.array(self.deviation))


class StandardMemory:
    """The present observation, standardised; earlier observations are not remembered.

    Args:
        space: space of the observation.
        mean: mean of every entry, shape (entries,).
        deviation: standard deviation of every entry, shape (entries,).
    """

    def __init__(self, space: spaces.Box[Any], mean: Array, deviation: Array) -> None:
        self.mean, self.deviation = mean, deviation
        self.space = spaces.Box(self._scaled(space.low), self._scaled(space.high), dtype=np.float32)

    def begin(self, n: int) -> None:
        """Begin N episodes with the next observations."""

    def restart(self, mask: Flags) -> None:
        """Begin the episodes in `mask`, shape (N,), with their next observation."""

    def take(self, observations: Array, actions: Array | None, mask: Flags) -> Array:
        return self._scaled(observations)

    def _scaled(self, observations: Array) -> Array:
        return np.clip((observations - self.mean) / self.deviation, -CLIP, CLIP).astype(np.float32)


@dataclass(frozen=True, slots=True)
class TaskShown:
    """Description of the observation of a task."""

    task: str  #: name of the task
    version: int  #: version of the tasks
    entries: tuple[Reading, ...]  #: entries of the environment's own observation
    memories: tuple[MemoryForm, ...] = ()  #: memories added by wrappers, the innermost first


if TYPE_CHECKING:
    AnyBox = spaces.Box[Any]
else:
    AnyBox = spaces.Box  # generic at run time from Gymnasium 1.4 on


class ShownBox(AnyBox):
    """Box space that describes its observations.

    Args:
        low: lowest observation, shape (entries,).
        high: highest observation, shape (entries,).
        shown: description of the observations.
    """

    def __init__(self, low: Array, high: Array, shown: TaskShown) -> None:
        super().__init__(low, high, dtype=np.float32)
        self.shown = shown


def shown_space(simulation: Simulation) -> ShownBox:
    """Return the observation space of an environment of a simulation."""
    return ShownBox(
        *bounds(simulation.entries), TaskShown(simulation.task.name, TASK_VERSION, tuple(simulation.entries))
    )


def wrapped_space(space: spaces.Space[Any], form: MemoryForm, memory: EpisodeMemory) -> spaces.Box[Any]:
    """Return the observation space of a wrapper that adds a memory to an environment with `space`."""
    if not isinstance(space, ShownBox):
        return memory.space
    shown = replace(space.shown, memories=(*space.shown.memories, form))
    return ShownBox(memory.space.low, memory.space.high, shown)


def memories_of(
    simulation: Simulation, action_space: spaces.Space[Any], forms: Sequence[MemoryForm]
) -> list[EpisodeMemory]:
    """Return the memories that wrappers around an environment show, the innermost first."""
    space: spaces.Box[Any] = shown_space(simulation)
    memories: list[EpisodeMemory] = []
    for form in forms:
        memories.append(form.memory(simulation, space, action_space))
        space = memories[-1].space
    return memories


def remembered(memories: Sequence[EpisodeMemory], observations: Array, actions: Array | None, mask: Flags) -> Array:
    """Return the observation of the outermost memory; arguments as for `EpisodeMemory.take`."""
    for memory in memories:
        observations = memory.take(observations, actions, mask)
    return observations

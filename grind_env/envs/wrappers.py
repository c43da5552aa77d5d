"""Wrappers that give an observation a memory: a stack of the past, or a belief of the hidden state of the wheel.

Both exist for single and for vector environments, with the same numbers. A memory must hold the episode at hand and
nothing of the one before, in every autoreset mode: `VectorMemory` sees to that.
"""

from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.utils import RecordConstructorArgs
from gymnasium.vector import AutoresetMode, VectorEnv, VectorWrapper
from gymnasium.vector.utils import batch_space

from grind_env.envs.contexts import option_items
from grind_env.envs.memory import Array, BeliefMemory, EpisodeMemory, Flags, StackMemory, WrapperError, belief_entries
from grind_env.envs.observations import Reading
from grind_env.envs.simulation import Simulation

AnyEnv = gym.Env[Any, Any]
AnyVectorEnv = VectorEnv[Any, Any, Any]


class MemoryWrapper(gym.Wrapper[Array, Any, Array, Any]):
    """A single environment that shows a memory of its episode."""

    def __init__(self, env: AnyEnv, memory: EpisodeMemory) -> None:
        gym.Wrapper.__init__(self, env)
        self.memory = memory
        self.observation_space = memory.space

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Array, dict[str, Any]]:
        """Reset, and forget."""
        observation, info = self.env.reset(seed=seed, options=options)
        self.memory.begin(1)
        return self.memory.take(observation[None], None, np.ones(1, bool))[0], info

    def step(self, action: Any) -> tuple[Array, Any, bool, bool, dict[str, Any]]:
        """Step, and remember."""
        observation, reward, terminated, truncated, info = self.env.step(action)
        shown = self.memory.take(observation[None], np.asarray(action)[None], np.ones(1, bool))[0]
        return shown, reward, terminated, truncated, info


class VectorMemory(VectorWrapper[Array, Array, Array, Array, Array]):
    """A vector environment that shows a memory of every episode, in any autoreset mode."""

    def __init__(self, env: AnyVectorEnv, memory: EpisodeMemory) -> None:
        VectorWrapper.__init__(self, env)
        self.memory = memory
        self.single_observation_space = memory.space
        self.observation_space = batch_space(memory.space, env.num_envs)
        self.mode = AutoresetMode(env.metadata["autoreset_mode"])
        self.over = np.zeros(env.num_envs, bool)
        memory.begin(env.num_envs)

    def reset(self, *, seed: Any = None, options: dict[str, Any] | None = None) -> tuple[Array, dict[str, Any]]:
        """Reset and forget all episodes, or those in `options["reset_mask"]`.

        Raises:
            ContextError: if the options are no dict; the environment checks the rest.
        """
        # of a copy, because SyncVectorEnv takes the mask out of the options that it is given
        options = None if options is None else dict(option_items(options))
        mask = (options or {}).get("reset_mask", np.ones(self.num_envs, bool))
        observations, info = self.env.reset(seed=seed, options=options)
        self.over &= ~mask
        self.memory.restart(mask)
        return self.memory.take(observations, None, mask), info

    def step(self, actions: Array) -> tuple[Array, Array, Array, Array, dict[str, Any]]:
        """Step and remember; forget what ended."""
        observations, rewards, terminations, truncations, info = self.env.step(actions)
        begun = self.over if self.mode is AutoresetMode.NEXT_STEP else np.zeros(self.num_envs, bool)
        ended = terminations | truncations
        last = observations.copy()
        if self.mode is AutoresetMode.SAME_STEP and ended.any():
            last[ended] = np.stack(info["final_obs"][ended].tolist())
        shown = self.memory.take(last, actions, ~begun)
        if self.mode is AutoresetMode.SAME_STEP and ended.any():
            info = {**info, "final_obs": replaced(info["final_obs"], shown, ended)}
            begun = ended
        if begun.any():
            self.memory.restart(begun)
            shown = self.memory.take(observations, None, begun)
        self.over = ended
        return shown, rewards, terminations, truncations, info


def replaced(values: Array, rows: Array, mask: Flags) -> Array:
    """Object array of shape (N,) with the rows in `mask`, shape (N, entries), in place of its values there."""
    changed = values.copy()
    for i in np.flatnonzero(mask):
        changed[i] = rows[i]
    return changed


class HistoryStack(MemoryWrapper, RecordConstructorArgs):
    """Shows the last n observations and actions.

    The observation is a flat `Box`: n times (observation, action that led to it), the latest last, and zeros where
    the episode had not begun. Actions of a `Box` stand as they are, choices of a `Discrete` or `MultiDiscrete`
    divided by the last of them.

    Args:
        env: the environment; its observation is a Box with one axis.
        n: length of the stack.

    Raises:
        WrapperError: if the spaces of the environment or n do not fit.
    """

    def __init__(self, env: AnyEnv, n: int = 4) -> None:
        RecordConstructorArgs.__init__(self, n=n)
        check_whole("n", n)
        super().__init__(env, StackMemory(env.observation_space, env.action_space, n))


class VectorHistoryStack(VectorMemory):
    """`HistoryStack` of every sub-environment.

    Args:
        env: the vector environment; the observation of one is a Box with one axis.
        n: length of the stack.

    Raises:
        WrapperError: if the spaces of the environment or n do not fit.
    """

    def __init__(self, env: AnyVectorEnv, n: int = 4) -> None:
        check_whole("n", n)
        super().__init__(env, StackMemory(env.single_observation_space, env.single_action_space, n))


class BeliefFilter(MemoryWrapper, RecordConstructorArgs):
    """Appends to the observation what can be believed of wear-flat area and lot severity; see `grind_env.belief`.

    Args:
        env: an environment whose steps are cycle blocks, wrapped or not, as long as its observation is not.
        members: members of the ensemble.

    Raises:
        WrapperError: if it is no grinding environment with its own observation, or members is no whole number.
        BeliefError: if its steps are no blocks or not compiled, or there are fewer than two members.
    """

    def __init__(self, env: AnyEnv, members: int = 16) -> None:
        RecordConstructorArgs.__init__(self, members=members)
        simulation = followed(env, env.observation_space, env.unwrapped.observation_space)
        check_whole("members", members)
        self.entries = (*simulation.entries, *belief_entries())
        super().__init__(env, BeliefMemory(simulation, members))

    def observation_info(self) -> tuple[Reading, ...]:
        """Every entry of the observation, the belief last."""
        return self.entries


class VectorBeliefFilter(VectorMemory):
    """`BeliefFilter` of every sub-environment.

    Args:
        env: a native vector environment whose steps are cycle blocks, wrapped or not, as long as its observation is
            not.
        members: members of the ensemble.

    Raises:
        WrapperError: as for `BeliefFilter`.
        BeliefError: likewise.
    """

    def __init__(self, env: AnyVectorEnv, members: int = 16) -> None:
        simulation = followed(env, env.observation_space, env.unwrapped.observation_space)
        check_whole("members", members)
        self.entries = (*simulation.entries, *belief_entries())
        super().__init__(env, BeliefMemory(simulation, members))

    def observation_info(self) -> tuple[Reading, ...]:
        """Every entry of the observation, the belief last."""
        return self.entries


def followed(env: AnyEnv | AnyVectorEnv, shown: Any, own: Any) -> Simulation:
    """The simulation of an environment that shows its own observation.

    Raises:
        WrapperError: if it has none, or shows something else.
    """
    simulation = getattr(env.unwrapped, "simulation", None)
    if not isinstance(simulation, Simulation) or shown != own:
        raise WrapperError(
            f"{env} is no grinding environment with its own observation: wrap the belief around that first"
        )
    return simulation


def check_whole(name: str, value: object) -> None:
    """Check a number that counts something.

    Raises:
        WrapperError: if it is no whole number.
    """
    if isinstance(value, bool) or not isinstance(value, int | np.integer):
        raise WrapperError(f"{name} is {value!r}, but must be a whole number")

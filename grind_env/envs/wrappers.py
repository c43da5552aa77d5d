"""Wrappers that change the observation: a stack of the past, a belief of the hidden wheel, scaling for learning.

All wrappers exist for single and vector environments, with the same numbers. A memory holds the current episode only,
in every autoreset mode; `VectorMemory` takes care of this.
"""

from typing import TYPE_CHECKING, Any

import gymnasium as gym
import numpy as np
from gymnasium.utils import RecordConstructorArgs
from gymnasium.vector import AutoresetMode, VectorEnv, VectorWrapper
from gymnasium.vector.utils import batch_space

from grind_env.array_types import Array
from grind_env.envs.env import GrindEnv
from grind_env.envs.learning_scales import ease_rewards, fit_standard
from grind_env.envs.observation_memory import WrapperError, belief_entries
from grind_env.envs.observations import Reading
from grind_env.envs.reset_options import option_items
from grind_env.envs.simulation import Simulation
from grind_env.envs.space_metadata import BeliefForm, MemoryForm, ShownBox, Stack, Standard, wrapped_space
from grind_env.envs.vector_env import GrindVectorEnv

AnyEnv = gym.Env[Any, Any]
AnyVectorEnv = VectorEnv[Any, Any, Any]
if TYPE_CHECKING:
    ArrayWrapper = VectorWrapper[Array, Array, Array, Array, Array]
else:
    ArrayWrapper = VectorWrapper  # generic at run time from Gymnasium 1.4 on


class MemoryWrapper(gym.Wrapper[Array, Any, Array, Any]):
    """A single environment that shows a memory of its episode."""

    def __init__(self, env: AnyEnv, form: MemoryForm) -> None:
        _check_kind(env, gym.Env)
        gym.Wrapper.__init__(self, env)
        self.memory = form.memory(simulation_of(env), env.observation_space, env.action_space)
        self.observation_space = wrapped_space(env.observation_space, form, self.memory)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Array, dict[str, Any]]:
        """Reset the environment and the memory."""
        observation, info = self.env.reset(seed=seed, options=options)
        self.memory.begin(1)
        return self.memory.take(observation[None], None, np.ones(1, bool))[0], info

    def step(self, action: Any) -> tuple[Array, Any, bool, bool, dict[str, Any]]:
        """Step; the observation shows the memory."""
        observation, reward, terminated, truncated, info = self.env.step(action)
        shown = self.memory.take(observation[None], np.asarray(action)[None], np.ones(1, bool))[0]
        return shown, reward, terminated, truncated, info


class VectorMemory(ArrayWrapper):
    """A vector environment that shows a memory of every episode, in any autoreset mode."""

    def __init__(self, env: AnyVectorEnv, form: MemoryForm) -> None:
        _check_kind(env, VectorEnv)
        VectorWrapper.__init__(self, env)
        self.memory = form.memory(simulation_of(env), env.single_observation_space, env.single_action_space)
        self.single_observation_space = wrapped_space(env.single_observation_space, form, self.memory)
        self.observation_space = batch_space(self.single_observation_space, env.num_envs)
        self.mode = AutoresetMode(env.metadata["autoreset_mode"])
        self.over = np.zeros(env.num_envs, bool)
        self.memory.begin(env.num_envs)

    def reset(self, *, seed: Any = None, options: dict[str, Any] | None = None) -> tuple[Array, dict[str, Any]]:
        """Reset and forget all episodes, or those in `options["reset_mask"]`.

        Raises:
            ContextError: if the options are no dict; the environment checks the rest.
        """
        # a copy, because SyncVectorEnv removes the mask from its options
        options = None if options is None else dict(option_items(options))
        mask = (options or {}).get("reset_mask", np.ones(self.num_envs, bool))
        observations, info = self.env.reset(seed=seed, options=options)
        self.over &= ~mask
        self.memory.restart(mask)
        return self.memory.take(observations, None, mask), info

    def step(self, actions: Array) -> tuple[Array, Array, Array, Array, dict[str, Any]]:
        observations, rewards, terminations, truncations, info = self.env.step(actions)
        begun = self.over if self.mode is AutoresetMode.NEXT_STEP else np.zeros(self.num_envs, bool)
        ended = terminations | truncations
        last = observations.copy()
        if self.mode is AutoresetMode.SAME_STEP and ended.any():
            last[ended] = np.stack(info["final_obs"][ended].tolist())
        shown = self.memory.take(last, actions, ~begun)
        if self.mode is AutoresetMode.SAME_STEP and ended.any():
            final = info["final_obs"].copy()
            for i in np.flatnonzero(ended):
                final[i] = shown[i]
            info, begun = {**info, "final_obs": final}, ended
        if begun.any():
            self.memory.restart(begun)
            shown = self.memory.take(observations, None, begun)
        self.over = ended
        return shown, rewards, terminations, truncations, info


class HistoryStack(MemoryWrapper, RecordConstructorArgs):
    """Wrapper that shows the last n observations and actions.

    The observation is a flat `Box`: n times (observation, action that led to it), the latest last, and zeros where
    the episode had not begun. Actions of a `Box` are unchanged; choices of a `Discrete` or `MultiDiscrete` are divided
    by the last choice.

    Args:
        env: the environment; its observation is a Box with one axis.
        n: length of the stack.

    Raises:
        WrapperError: if the spaces of the environment or n do not fit.
    """

    def __init__(self, env: AnyEnv, n: int = 4) -> None:
        RecordConstructorArgs.__init__(self, n=n)
        _check_whole("n", n)
        super().__init__(env, Stack(n))


class VectorHistoryStack(VectorMemory):
    """`HistoryStack` of every sub-environment of a vector environment, with the same arguments."""

    def __init__(self, env: AnyVectorEnv, n: int = 4) -> None:
        _check_whole("n", n)
        super().__init__(env, Stack(n))


class BeliefFilter(MemoryWrapper, RecordConstructorArgs):
    """Append the belief of wear-flat area and dulling rate to the observation; see `grind_env.belief`.

    Args:
        env: an environment whose steps are cycle blocks; wrappers around it must not change the observation.
        members: number of ensemble members.

    Raises:
        WrapperError: if `env` is no grinding environment with its own observation, or `members` no whole number.
        BeliefError: if the steps of `env` are not compiled, or there are fewer than two members.
    """

    def __init__(self, env: AnyEnv, members: int = 16) -> None:
        RecordConstructorArgs.__init__(self, members=members)
        self.entries = _entries_with_belief(env, members)
        super().__init__(env, BeliefForm(members))

    def observation_info(self) -> tuple[Reading, ...]:
        """Return every entry of the observation, the belief last."""
        return self.entries


class VectorBeliefFilter(VectorMemory):
    """`BeliefFilter` of every sub-environment of a native vector environment, with the same arguments."""

    def __init__(self, env: AnyVectorEnv, members: int = 16) -> None:
        self.entries = _entries_with_belief(env, members)
        super().__init__(env, BeliefForm(members))

    def observation_info(self) -> tuple[Reading, ...]:
        """Return every entry of the observation, the belief last."""
        return self.entries


class ForLearning(MemoryWrapper, RecordConstructorArgs):
    """Standardise the observation, and shift the reward to 0 for the best fixed plan.

    Every entry of the observation is standardised by its mean and standard deviation in random play, which are equal
    for every environment of a task. The reward is raised by one and cut at -10, because the large cost of a scrapped
    part teaches little more. Evaluation is not affected: `grind_env.evaluate` uses the true cost.

    Args:
        env: an environment of this package with E and D, with no wrappers of the observation but those above.

    Raises:
        WrapperError: if `env` is another environment or has another wrapper of the observation.
    """

    def __init__(self, env: AnyEnv) -> None:
        RecordConstructorArgs.__init__(self)
        _check_kind(env, gym.Env)
        super().__init__(env, _standard(env, env.observation_space))

    def step(self, action: Any) -> tuple[Array, Any, bool, bool, dict[str, Any]]:
        """Step; the reward is raised by one and cut."""
        observation, reward, terminated, truncated, info = super().step(action)
        return observation, float(ease_rewards(np.array(reward))), terminated, truncated, info


class VectorForLearning(VectorMemory):
    """`ForLearning` of every sub-environment of a vector environment."""

    def __init__(self, env: AnyVectorEnv) -> None:
        _check_kind(env, VectorEnv)
        super().__init__(env, _standard(env, env.single_observation_space))

    def step(self, actions: Array) -> tuple[Array, Array, Array, Array, dict[str, Any]]:
        ground = ~self.over if self.mode is AutoresetMode.NEXT_STEP else np.ones(self.num_envs, bool)
        observations, rewards, terminations, truncations, info = super().step(actions)
        return observations, np.where(ground, ease_rewards(rewards), rewards), terminations, truncations, info


def _standard(env: AnyEnv | AnyVectorEnv, space: Any) -> Standard:
    """Return the standardisation of an environment's observations in this space."""
    simulation = simulation_of(env)
    if simulation is None or not isinstance(space, ShownBox):
        raise WrapperError(
            f"{env} is no environment of grind_env in which E and D are chosen, or something around it shows something "
            "else: wrap the environment itself, or its belief or stack"
        )
    unwrapped: Any = env.unwrapped
    return fit_standard(simulation, unwrapped.codec, space.shown.memories)


def simulation_of(env: AnyEnv | AnyVectorEnv) -> Simulation | None:
    """Return the simulation of an environment of this package; None if it has none."""
    unwrapped = env.unwrapped
    return unwrapped.simulation if isinstance(unwrapped, GrindEnv | GrindVectorEnv) else None


def _entries_with_belief(env: Any, members: object) -> tuple[Reading, ...]:
    """Return the entries of an environment that shows its own observation, followed by the entries of a belief."""
    simulation = simulation_of(env)
    if simulation is None or env.observation_space != env.unwrapped.observation_space:
        raise WrapperError(
            f"{env} is no grinding environment with its own observation: wrap the belief around that first"
        )
    _check_whole("members", members)
    return (*simulation.entries, *belief_entries())


def _check_kind(env: Any, kind: type) -> None:
    """Check that an environment is single or vector, as the wrapper needs."""
    if not isinstance(env, kind):
        wanted, others = ("vector", "without") if kind is VectorEnv else ("single", "with")
        raise WrapperError(f"{env} is no {wanted} environment: take the wrapper {others} 'Vector' in its name")


def _check_whole(name: str, value: object) -> None:
    if isinstance(value, bool) or not isinstance(value, int | np.integer):
        raise WrapperError(f"{name} is {value!r}, but must be a whole number")

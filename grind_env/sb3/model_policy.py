"""A model of Stable-Baselines3 as a policy, to be judged and played beside all others."""

from copy import deepcopy
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.vec_env import VecNormalize

from grind_env.envs.actions import ActionCodec
from grind_env.envs.memory import EpisodeMemory
from grind_env.envs.observations import HIDDEN
from grind_env.envs.simulation import Episodes, Simulation
from grind_env.errors import GrindError
from grind_env.policies.choices import Decision
from grind_env.policies.policy import Sees


class ModelPolicy:
    """The most likely actions of a model that was trained in an `SB3VecEnv`.

    It sees what the model saw in training: measurements, with the belief or the stack of a wrapper of this package
    around the environment, and as `VecNormalize` scales them.

    Args:
        model: with its environment; it may go on training afterwards.
        name: in tables.

    Raises:
        GrindError: the model has no environment, one of another package, or one in which it sees or chooses what no
            policy does.
    """

    sees: ClassVar[Sees] = "measurements"

    def __init__(self, model: BaseAlgorithm, name: str | None = None) -> None:
        env = model.get_env()
        if env is None:
            raise GrindError("the model has no environment: give it the one it was trained in, by model.set_env(env)")
        self.model, self.name = model, name or type(model).__name__
        try:
            self.codec: ActionCodec = env.get_attr("codec")[0]
            trained: Simulation = env.get_attr("simulation")[0]
        except AttributeError:
            raise GrindError(
                "the model was trained in no environment of grind_env: there is nothing to judge it in"
            ) from None
        self.task = trained.task
        if any(entry.name in HIDDEN for entry in trained.entries):
            raise GrindError("the model sees the hidden state: train it with observation='measured' to have it judged")
        if len(self.codec.names) > len(Decision._fields):
            raise GrindError("the model chooses the pre-dress as well, which policies do not: train it without")
        try:
            self._memory: EpisodeMemory | None = env.get_attr("memory")[0]
        except AttributeError:
            self._memory = None

    def begin(self, simulation: Simulation, episodes: int) -> None:
        """That many episodes begin.

        Raises:
            GrindError: the model was trained on another task, or its training has diverged.
        """
        if simulation.task != self.task:
            raise GrindError(f"{self.name} was trained for {self.task.name}, not for {simulation.task.name}")
        # what such weights make is NaN, of which a distribution of torch says nothing in a sentence and argmax nothing
        if not all(np.isfinite(each.numpy(force=True)).all() for each in self.model.policy.state_dict().values()):
            raise GrindError(
                f"{self.name} has weights that are no finite numbers: its training has diverged; train it anew, with a"
                " lower learning rate"
            )
        # of its own, because a training that goes on has episodes in it
        self.memory = deepcopy(self._memory)
        if self.memory is not None:
            self.memory.begin(episodes)
        self.actions: NDArray[Any] | None = None
        self.state: tuple[NDArray[Any], ...] | None = None

    def act(self, observation: NDArray[np.float32], episodes: Episodes | None) -> Decision:
        """Decide the coming step.

        Args:
            observation: measured, shape (N, entries).
            episodes: nothing of it is read.

        Returns:
            E in mm/min and D, each shape (N,).
        """
        first = self.actions is None
        seen: Any = observation
        if self.memory is not None:
            seen = self.memory.take(observation, self.actions, np.ones(len(observation), bool))
        scaler: VecNormalize | None = self.model.get_vec_normalize_env()
        if scaler is not None:
            seen = scaler.normalize_obs(seen)
        begins = np.full(len(observation), first)
        self.actions, self.state = self.model.predict(seen, self.state, begins, deterministic=True)
        return Decision(*self.codec.decode(self.actions))

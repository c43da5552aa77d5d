"""A Stable-Baselines3 model as a policy, for evaluation and play."""

import hashlib
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.vec_env import VecNormalize

from grind_env.envs.episode_state import Episodes
from grind_env.envs.simulation import Simulation
from grind_env.errors import GrindError
from grind_env.policies.choices import Decision
from grind_env.policies.policy import Sees
from grind_env.sb3.model_observations import check_scale, shown_form


class ModelPolicy:
    """A policy that takes the most likely actions of a model trained in environments of this package.

    The model sees the observations of its training: measurements, with the wrappers of this package and the scaling of
    `VecNormalize`. The spaces of the model describe these wrappers and are in its file. A `VecNormalize` is not in the
    file; load such a model with one: `PPO.load(path, env=VecNormalize.load(...))`.

    Args:
        model: model, just trained or loaded; you can continue its training afterwards.
        name: name of the policy in tables.

    Raises:
        GrindError: the model was trained with an environment or a wrapper of another package, uses readings or actions
            that policies do not have, or lacks the `VecNormalize` of its training.
    """

    sees: ClassVar[Sees] = "measurements"

    def __init__(self, model: BaseAlgorithm, name: str | None = None) -> None:
        self.model, self.name = model, name or type(model).__name__
        self.form = shown_form(model.observation_space, model.action_space, self.name)
        check_scale(self.name, model.observation_space, None if model.env else model._last_obs)

    def __repr__(self) -> str:
        """Return a text with a hash of the weights, the same in every run."""
        digest = hashlib.sha256(repr(self.form).encode())
        for values in self.model.policy.state_dict().values():
            digest.update(values.numpy(force=True).tobytes())
        return f"ModelPolicy({self.name!r}, {digest.hexdigest()[:16]})"

    def begin(self, simulation: Simulation, episodes: int) -> None:
        """Begin `episodes` episodes of a simulation.

        Raises:
            GrindError: the model was trained on another task, or its training has diverged.
        """
        # such weights give NaN: a distribution of torch reports NaN without a plain sentence, argmax not at all
        if not all(np.isfinite(each.numpy(force=True)).all() for each in self.model.policy.state_dict().values()):
            raise GrindError(
                f"{self.name} has weights that are no finite numbers: its training has diverged; train it anew, with a"
                " lower learning rate"
            )
        self.view = self.form.view(simulation)
        self.view.begin(episodes)
        self.first = np.ones(episodes, bool)
        self.state: tuple[NDArray[Any], ...] | None = None

    def act(self, observation: NDArray[np.float32], episodes: Episodes | None) -> Decision:
        """Choose E and D of the coming step.

        Args:
            observation: measured observations, shape (N, entries).
            episodes: not used.

        Returns:
            E in mm/min and D, each shape (N,).
        """
        seen: Any = self.view.features(observation)
        scaler: VecNormalize | None = self.model.get_vec_normalize_env()
        if scaler is not None:
            seen = scaler.normalize_obs(seen)
        actions, self.state = self.model.predict(seen, self.state, self.first, deterministic=True)
        self.first = np.zeros(len(observation), bool)
        return self.view.decide(actions)

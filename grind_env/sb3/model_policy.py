"""A Stable-Baselines3 model as a policy, for evaluation and play."""

import hashlib
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.vec_env import VecNormalize

from grind_env.envs.episodes import Episodes
from grind_env.envs.simulation import Simulation
from grind_env.errors import GrindError
from grind_env.policies.choices import Decision
from grind_env.policies.policy import Sees
from grind_env.sb3.shown_view import check_scale, shown_form


class ModelPolicy:
    """The most likely actions of a model that was trained in environments of this package, or loaded from its file.

    It sees what the model saw in training: measurements, with what wrappers of this package around the environment
    show, and as `VecNormalize` scales them. Its spaces say what that is, and are saved with it; a `VecNormalize` is
    not, and such a model is loaded with one: `PPO.load(path, env=VecNormalize.load(...))`.

    Args:
        model: it may go on training afterwards.
        name: in tables.

    Raises:
        GrindError: the model was trained in an environment of another package or behind a wrapper of one, sees or
            chooses what no policy does, or has lost the `VecNormalize` that it was trained with.
    """

    sees: ClassVar[Sees] = "measurements"

    def __init__(self, model: BaseAlgorithm, name: str | None = None) -> None:
        self.model, self.name = model, name or type(model).__name__
        self.form = shown_form(model.observation_space, model.action_space, self.name)
        check_scale(self.name, model.observation_space, None if model.env else model._last_obs)

    def __repr__(self) -> str:
        """Return the same for the same weights, in every run."""
        digest = hashlib.sha256(repr(self.form).encode())
        for values in self.model.policy.state_dict().values():
            digest.update(values.numpy(force=True).tobytes())
        return f"ModelPolicy({self.name!r}, {digest.hexdigest()[:16]})"

    def begin(self, simulation: Simulation, episodes: int) -> None:
        """That many episodes begin.

        Raises:
            GrindError: the model was trained on another task, or its training has diverged.
        """
        # what such weights make is NaN, of which a distribution of torch says nothing in a sentence and argmax nothing
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
        """Decide the coming step.

        Args:
            observation: measured, shape (N, entries).
            episodes: nothing of it is read.

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

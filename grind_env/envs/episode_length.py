"""The length of an episode in the spec of an environment, where wrappers such as `TimeAwareObservation` look for it."""

from dataclasses import replace

from gymnasium.envs.registration import EnvSpec

from grind_env.envs.simulation import Simulation


class EpisodeLength:
    """Tells in `spec.max_episode_steps` how long an episode is; a mixin, to be listed before a class of Gymnasium.

    It is the limit that the caller has set, else one more than the steps of an episode. `gym.make(env.spec)` puts a
    `TimeLimit` of that many steps around the environment, and a limit of the very steps would truncate the last one,
    which terminates.
    """

    simulation: Simulation
    _spec: EnvSpec | None = None

    @property
    def spec(self) -> EnvSpec | None:
        """The spec that `gym.make` or `gym.make_vec` used; None for an environment that was made directly."""
        return self._spec

    @spec.setter
    def spec(self, made: EnvSpec | None) -> None:
        if made is not None:
            limit = (
                made.kwargs.get("max_episode_steps") or made.max_episode_steps
            )  # `gym.make_vec` gives the argument precedence
            made = replace(made, max_episode_steps=limit or self.simulation.most_steps + 1)
        self._spec = made

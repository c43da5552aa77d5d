"""The view of a task that a model was trained with, rebuilt without its environment."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from grind_env.envs.actions import ACTIONS, ActionCodec
from grind_env.envs.observations import HIDDEN
from grind_env.envs.simulation import Simulation
from grind_env.envs.space_metadata import ShownBox, TaskShown, memories_of, remembered, shown_space
from grind_env.errors import GrindError
from grind_env.policies.choices import Decision
from grind_env.task_version import TASK_VERSION, of_version

#: observation entry that exists only if actions can ask for a dress before the first plunge
PRE_DRESS = "last_pre_dress"


@dataclass(frozen=True, slots=True)
class ShownForm:
    """Observations and actions of a model."""

    shown: TaskShown  #: description in its observation space
    action_space: spaces.Space[Any]  #: its action space
    name: str  #: name of the model, for messages

    def view(self, simulation: Simulation) -> "ShownView":
        shown, task = self.shown, simulation.task
        if shown.task != task.name:
            raise GrindError(f"{self.name} was trained for {shown.task}, not for {task.name}")
        if shown.version != TASK_VERSION:
            raise GrindError(f"{self.name} is {of_version(shown.version)}: train it anew")
        codecs = [codec for codec in (ActionCodec(task, form) for form in ACTIONS) if codec.space == self.action_space]
        if shown_space(simulation).shown.entries != shown.entries or not codecs:
            raise GrindError(
                f"{self.name} was trained for another version of {task.name}, with other observations or actions:"
                " train one anew"
            )
        return ShownView(simulation, codecs[0], shown)


class ShownView:
    """Observations and actions of a model, as the wrappers around its environment convert them.

    Args:
        simulation: simulation of the environment.
        codec: converter of the actions.
        shown: description of the observation.
    """

    def __init__(self, simulation: Simulation, codec: ActionCodec, shown: TaskShown) -> None:
        self.codec, self.action_space = codec, codec.space
        self.memories = memories_of(simulation, codec.space, shown.memories)
        self.observation_space = self.memories[-1].space if self.memories else shown_space(simulation)

    def begin(self, n: int) -> None:
        for memory in self.memories:
            memory.begin(n)
        self.actions: NDArray[Any] | None = None

    def features(self, observation: NDArray[np.float32]) -> NDArray[np.float32]:
        return np.asarray(remembered(self.memories, observation, self.actions, np.ones(len(observation), bool)))

    def decide(self, actions: NDArray[Any]) -> Decision:
        self.actions = actions  # a stack remembers them
        return Decision(*self.codec.decode(actions))


def shown_form(observation_space: spaces.Space[Any], action_space: spaces.Space[Any], name: str) -> ShownForm:
    """Return the observations and actions of a model, from its spaces.

    Raises:
        GrindError: the space does not describe the observations, or policies do not have such readings or actions.
    """
    if not isinstance(observation_space, ShownBox):
        raise GrindError(
            f"{name} does not say what it saw: train it in an environment of grind_env, with no wrappers around the"
            " observation but those of grind_env"
        )
    shown = observation_space.shown
    names = [entry.name for entry in shown.entries]
    if any(entry in HIDDEN for entry in names):
        raise GrindError(f"{name} sees the hidden state: train it with observation='measured' to have it judged")
    if PRE_DRESS in names:
        raise GrindError(f"{name} chooses the pre-dress as well, which policies do not: train it without")
    return ShownForm(shown, action_space, name)


def check_scale(name: str, observation_space: spaces.Space[Any], last: Any) -> None:
    """Check that a model without its normalisation saw unscaled observations.

    Args:
        name: name of the model.
        observation_space: its observation space.
        last: its last observations in training, shape (N, entries); None if unknown.

    Raises:
        GrindError: the observations had been scaled, but the normalisation is missing.
    """
    if last is None or not isinstance(observation_space, spaces.Box):
        return
    if not ((observation_space.low <= last) & (last <= observation_space.high)).all():
        raise GrindError(
            f"{name} saw what a VecNormalize had scaled, which its file does not hold: load it with that,"
            " PPO.load(path, env=VecNormalize.load(...)), and judge ModelPolicy(model)"
        )

"""Learned agents as policies: the acting part of a network, in NumPy, so that playing one needs no torch.

Every kind that is trained acts through the same few layers: perhaps an LSTM, then linear layers with an activation
between them. What its last layer says is read as logits of E and of D, as a value of every choice, or as a point of a
Box.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from agents.learning.view import Actions, LearnerView, Memory
from agents.policy import Decision, Sees
from grind_env.envs.simulation import Episodes
from grind_env.envs.tasks import Task
from grind_env.errors import GrindError

Tensor = NDArray[np.float32]
Shape = tuple[int, ...]

BATCH = 64
"""Episodes of one pass through the network. A pass always has as many, so that what an episode gets does not depend on
how many run beside it: a matrix product may add up in another order for another number of rows."""

LSTM = "lstm_actor"
"""Name of the LSTM in the state of a recurrent policy of sb3-contrib."""

SIGMOID_SCALE = np.float32(0.5)


class Layers(NamedTuple):
    """Where the acting layers of a family of policies stand in its state."""

    body: str
    head: str
    squashed: bool = False
    """Whether the output goes through tanh, as SAC and TQC squash it."""
    recurrent: bool = False


FAMILIES: Mapping[str, Layers] = {
    "actor_critic": Layers("mlp_extractor.policy_net.{}", "action_net"),
    "recurrent_actor_critic": Layers("mlp_extractor.policy_net.{}", "action_net", recurrent=True),
    "q_network": Layers("q_net.q_net.{}", "q_net.q_net.{}"),
    "squashed_actor": Layers("actor.latent_pi.{}", "actor.mu", squashed=True),
}
"""The families that a file may name; none of them is looked up anywhere else."""

ACTIVATIONS: Mapping[str, Callable[[Tensor], Tensor]] = {
    "tanh": np.tanh,
    "relu": lambda values: np.maximum(values, np.float32(0.0)),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Network:
    """Shape of the acting part of a network.

    Args:
        family: one of `FAMILIES`.
        entries: length of the feature vector.
        lstm: units of the LSTM; 0 for none.
        hidden: units of the layers between.
        outputs: length of what comes out.
        activation: one of `ACTIVATIONS`.
    """

    family: str
    entries: int
    lstm: int
    hidden: tuple[int, ...]
    outputs: int
    activation: str

    def linear(self) -> list[str]:
        """Names of the linear layers, in order."""
        layers = FAMILIES[self.family]
        # an activation follows each layer of the body
        names = [layers.body.format(2 * i) for i in range(len(self.hidden))]
        return [*names, layers.head.format(2 * len(self.hidden))]

    def shapes(self) -> dict[str, Shape]:
        """Shape of every tensor by its name in the state of Stable-Baselines3's policy."""
        shapes: dict[str, Shape] = {}
        width = self.entries
        if self.lstm:
            gates = 4 * self.lstm
            for name, columns in (("ih", width), ("hh", self.lstm)):
                shapes[f"{LSTM}.weight_{name}_l0"] = (gates, columns)
                shapes[f"{LSTM}.bias_{name}_l0"] = (gates,)
            width = self.lstm
        for name, units in zip(self.linear(), (*self.hidden, self.outputs), strict=True):
            shapes[f"{name}.weight"], shapes[f"{name}.bias"] = (units, width), (units,)
            width = units
        return shapes


class LstmState(NamedTuple):
    """Output and cell of the LSTM, each shape (N, units)."""

    output: Tensor
    cell: Tensor


class Actor:
    """A network with its weights.

    Args:
        network: its shape.
        tensors: float32, as `network.shapes()` says.
    """

    def __init__(self, network: Network, tensors: Mapping[str, Tensor]) -> None:
        self.network = network
        self.tensors = {name: np.ascontiguousarray(tensors[name], np.float32) for name in network.shapes()}

    def begin(self, n: int) -> LstmState:
        """The state of N episodes before their first block; without units where there is no LSTM."""
        zeros = np.zeros((n, self.network.lstm), np.float32)
        return LstmState(zeros, zeros)

    def outputs(self, features: Tensor, state: LstmState) -> tuple[Tensor, LstmState]:
        """What the network says, shape (N, outputs), and the next state; rows do not depend on each other.

        Args:
            features: shape (N, entries).
            state: of `begin` or of the last call.
        """
        n = len(features)
        spare = -n % BATCH
        padded = [np.pad(values, ((0, spare), (0, 0))) for values in (features, *state)]
        passes = [self._pass(*(values[k : k + BATCH] for values in padded)) for k in range(0, n + spare, BATCH)]
        values, output, cell = (np.concatenate(part)[:n] for part in zip(*passes, strict=True))
        return values, LstmState(output, cell)

    def _pass(self, values: Tensor, output: Tensor, cell: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        """One pass of `BATCH` rows."""
        if self.network.lstm:
            output, cell = self._remember(values, output, cell)
            values = output
        activation = ACTIVATIONS[self.network.activation]
        *body, head = self.network.linear()
        for name in body:
            values = activation(self._linear(values, f"{name}.weight", f"{name}.bias"))
        values = self._linear(values, f"{head}.weight", f"{head}.bias")
        return (np.tanh(values) if FAMILIES[self.network.family].squashed else values), output, cell

    def _remember(self, values: Tensor, output: Tensor, cell: Tensor) -> tuple[Tensor, Tensor]:
        """One step of an LSTM (Hochreiter, Schmidhuber, Neural Computation 9, 1997, 1735); gates in torch's order."""
        gates = self._linear(values, f"{LSTM}.weight_ih_l0", f"{LSTM}.bias_ih_l0")
        gates = gates + self._linear(output, f"{LSTM}.weight_hh_l0", f"{LSTM}.bias_hh_l0")
        enter, keep, candidate, show = np.split(gates, 4, axis=1)
        cell = _sigmoid(keep) * cell + _sigmoid(enter) * np.tanh(candidate)
        return _sigmoid(show) * np.tanh(cell), cell

    def _linear(self, values: Tensor, weight: str, bias: str) -> Tensor:
        return np.asarray(values @ self.tensors[weight].T + self.tensors[bias])


def _sigmoid(values: Tensor) -> Tensor:
    # through tanh, which cannot overflow
    return np.asarray(SIGMOID_SCALE * np.tanh(SIGMOID_SCALE * values) + SIGMOID_SCALE)


@dataclass
class LearnedPolicy:
    """A trained agent; it sees measurements only and takes the action that it holds best.

    Args:
        actor: the network.
        task_name: task that it was trained for.
        memory: what it remembers.
        actions: form of its actions.
        name: name in tables.
    """

    actor: Actor
    task_name: str
    memory: Memory
    actions: Actions
    name: str
    sees: Sees = field(default="measurements", init=False)

    def begin(self, task: Task, episodes: int) -> None:
        """That many episodes of the task begin.

        Raises:
            GrindError: if the agent was trained for another task.
        """
        if task.name != self.task_name:
            raise GrindError(f"the agent {self.name} was trained for {self.task_name}, not for {task.name}")
        self.view = LearnerView(task, self.memory, self.actions)
        self.view.begin(episodes)
        self.state = self.actor.begin(episodes)

    def act(self, observation: NDArray[np.float32], episodes: Episodes | None) -> Decision:
        """Decide the coming block."""
        values, self.state = self.actor.outputs(self.view.features(observation), self.state)
        return self.view.decide(best_actions(self.view.action_space, values))


def outputs_of(space: spaces.Space[Any]) -> int:
    """How many numbers a network says of an action space: one of every choice, or the coordinates of a point."""
    if isinstance(space, spaces.MultiDiscrete):
        return int(space.nvec.sum())
    return int(space.n) if isinstance(space, spaces.Discrete) else int(np.prod(space.shape or ()))


def best_actions(space: spaces.Space[Any], values: Tensor) -> NDArray[Any]:
    """The actions that outputs of shape (N, outputs) stand for: the choices with the largest ones, or a point."""
    if isinstance(space, spaces.MultiDiscrete):
        parts = np.split(values, np.cumsum(space.nvec)[:-1], axis=1)
        return np.stack([part.argmax(axis=1) for part in parts], axis=1)
    return np.clip(values, space.low, space.high) if isinstance(space, spaces.Box) else values.argmax(axis=1)

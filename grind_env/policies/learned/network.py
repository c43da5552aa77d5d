"""Learned agents as policies: the acting part of a network without torch, with the same bits on every machine.

Every kind that is trained acts through the same few layers: perhaps an LSTM or a GRU, then linear layers with an
activation between them. What its last layer says is read as logits of E and of D, as a value of every choice, or as a
point of a Box.
"""

import hashlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from grind_env.envs.episodes import Episodes
from grind_env.envs.simulation import Simulation
from grind_env.errors import GrindError
from grind_env.kernel.layers import linear, logistic_layer, tanh_layer
from grind_env.policies.choices import Decision
from grind_env.policies.learned.view import ViewForm
from grind_env.policies.policy import Sees

Tensor = NDArray[np.float32]
Numbers = NDArray[np.float64]
Shape = tuple[int, ...]

LSTM = "lstm_actor"
"""Name of the LSTM in the state of a recurrent policy of sb3-contrib."""
GRU = "gru"
"""Name of the GRU in that of `grind_env.training.gru_ppo`."""
GATES = {LSTM: 4, GRU: 3}
"""Of each unit; the candidate counts as one."""


class NetworkError(GrindError):
    """A network of no known family."""


class Layers(NamedTuple):
    """Where the acting layers of a family of policies stand in its state."""

    body: str
    head: str
    squashed: bool = False
    """Whether the output goes through tanh, as SAC and TQC squash it."""
    recurrent: str = ""
    """Name of the layer that remembers, one of `GATES`; none if empty."""


FAMILIES: Mapping[str, Layers] = {
    "actor_critic": Layers("mlp_extractor.policy_net.{}", "action_net"),
    "recurrent_actor_critic": Layers("mlp_extractor.policy_net.{}", "action_net", recurrent=LSTM),
    "q_network": Layers("q_net.q_net.{}", "q_net.q_net.{}"),
    "squashed_actor": Layers("actor.latent_pi.{}", "actor.mu", squashed=True),
    "gru": Layers("actor.{}", "actor.{}", recurrent=GRU),
}
"""The families that a file may name; none of them is looked up anywhere else."""

ACTIVATIONS: Mapping[str, Callable[[Numbers], Numbers]] = {
    "tanh": tanh_layer,
    "relu": lambda values: np.maximum(values, 0.0),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Network:
    """Shape of the acting part of a network.

    Args:
        family: one of `FAMILIES`.
        entries: length of the feature vector.
        lstm: units of the layer that remembers; 0 for none.
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
            layer = FAMILIES[self.family].recurrent
            gates = GATES[layer] * self.lstm
            for name, columns in (("ih", width), ("hh", self.lstm)):
                shapes[f"{layer}.weight_{name}_l0"] = (gates, columns)
                shapes[f"{layer}.bias_{name}_l0"] = (gates,)
            width = self.lstm + (self.entries if layer == GRU else 0)
        for name, units in zip(self.linear(), (*self.hidden, self.outputs), strict=True):
            shapes[f"{name}.weight"], shapes[f"{name}.bias"] = (units, width), (units,)
            width = units
        return shapes


class LstmState(NamedTuple):
    """Output and cell of the layer that remembers, each shape (N, units); a GRU has no cell, and leaves it as it is."""

    output: Numbers
    cell: Numbers


class Actor:
    """A network with its weights.

    Args:
        network: its shape.
        tensors: float32, as `network.shapes()` says.
    """

    def __init__(self, network: Network, tensors: Mapping[str, Tensor]) -> None:
        self.network = network
        self.tensors = {name: tensors[name] for name in network.shapes()}
        # a layer multiplies weights of shape (inputs, outputs) in double precision
        self._factors = {name: np.ascontiguousarray(values.T, np.float64) for name, values in self.tensors.items()}

    def __repr__(self) -> str:
        """The same for the same weights, in every run: what was found with a policy is kept by its repr."""
        digest = hashlib.sha256(repr(self.network).encode())
        for values in self.tensors.values():
            digest.update(np.ascontiguousarray(values).tobytes())
        return f"Actor({digest.hexdigest()[:16]})"

    def begin(self, n: int) -> LstmState:
        """The state of N episodes before their first block; without units where nothing is remembered."""
        zeros = np.zeros((n, self.network.lstm))
        return LstmState(zeros, zeros)

    def outputs(self, features: Tensor, state: LstmState) -> tuple[Tensor, LstmState]:
        """What the network says, shape (N, outputs), and the next state; rows do not depend on each other.

        Args:
            features: shape (N, entries).
            state: of `begin` or of the last call.
        """
        values: Numbers = np.ascontiguousarray(features, np.float64)
        if self.network.lstm:
            gru = FAMILIES[self.network.family].recurrent == GRU
            state = (self._gru if gru else self._lstm)(values, state)
            # what is seen goes past a GRU, too
            values = np.concatenate([state.output, values], axis=1) if gru else state.output
        activation = ACTIVATIONS[self.network.activation]
        *body, head = self.network.linear()
        for name in body:
            values = activation(self._linear(values, f"{name}.weight", f"{name}.bias"))
        values = self._linear(values, f"{head}.weight", f"{head}.bias")
        squashed = tanh_layer(values) if FAMILIES[self.network.family].squashed else values
        return squashed.astype(np.float32), state

    def _lstm(self, values: Numbers, state: LstmState) -> LstmState:
        """One step of an LSTM (Hochreiter, Schmidhuber, Neural Computation 9, 1997, 1735); gates in torch's order."""
        gates = self._linear(values, f"{LSTM}.weight_ih_l0", f"{LSTM}.bias_ih_l0")
        gates += self._linear(state.output, f"{LSTM}.weight_hh_l0", f"{LSTM}.bias_hh_l0")
        enter, keep, _, show = np.split(logistic_layer(gates), 4, axis=1)
        candidate = np.split(tanh_layer(gates), 4, axis=1)[2]
        cell = keep * state.cell + enter * candidate
        return LstmState(show * tanh_layer(cell), cell)

    def _gru(self, values: Numbers, state: LstmState) -> LstmState:
        """One step of a GRU (Cho et al., arXiv:1406.1078); gates and where the reset acts are torch's."""
        new = np.split(self._linear(values, f"{GRU}.weight_ih_l0", f"{GRU}.bias_ih_l0"), 3, axis=1)
        old = np.split(self._linear(state.output, f"{GRU}.weight_hh_l0", f"{GRU}.bias_hh_l0"), 3, axis=1)
        reset, keep = (logistic_layer(new[k] + old[k]) for k in range(2))
        candidate = tanh_layer(new[2] + reset * old[2])
        return state._replace(output=candidate + keep * (state.output - candidate))

    def _linear(self, values: Numbers, weight: str, bias: str) -> Numbers:
        return linear(values, self._factors[weight], self._factors[bias])


@dataclass
class LearnedPolicy:
    """A trained agent; it sees measurements only and takes the action that it holds best.

    Args:
        actor: the network.
        task_name: task that it was trained for.
        form: how it sees the task and acts.
        name: name in tables.
        machines: on which it was trained; empty if that is not known.
        remark: what to say where it is used; empty for nothing.
    """

    actor: Actor
    task_name: str
    form: ViewForm
    name: str
    machines: str = field(default="", repr=False)  # results are kept by the repr
    remark: str = field(default="", repr=False)
    sees: Sees = field(default="measurements", init=False)

    def begin(self, simulation: Simulation, episodes: int) -> None:
        if simulation.task.name != self.task_name:
            raise GrindError(f"the agent {self.name} was trained for {self.task_name}, not for {simulation.task.name}")
        self.view = self.form.view(simulation)
        self.view.begin(episodes)
        self.state = self.actor.begin(episodes)

    def act(self, observation: NDArray[np.float32], episodes: Episodes | None) -> Decision:
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


POLICIES: Mapping[str, str] = {
    "ActorCriticPolicy": "actor_critic",
    "RecurrentActorCriticPolicy": "recurrent_actor_critic",
    "DQNPolicy": "q_network",
    "SACPolicy": "squashed_actor",
    "TQCPolicy": "squashed_actor",
}
"""Family of each policy class of Stable-Baselines3 and sb3-contrib that is trained here."""


def acting_part(policy_class: str, state: Mapping[str, Tensor], activation: str) -> Actor:
    """What acting needs of the state of a policy of Stable-Baselines3: the actor without critics."""
    if policy_class not in POLICIES or activation not in ACTIVATIONS:
        raise NetworkError(f"a {policy_class} with {activation} cannot be saved: only {', '.join(POLICIES)} can")
    family = POLICIES[policy_class]
    layers = FAMILIES[family]
    lstm = state[f"{layers.recurrent}.weight_hh_l0"].shape[1] if layers.recurrent else 0
    hidden: list[int] = []
    while f"{layers.body.format(2 * len(hidden))}.weight" in state:
        hidden.append(len(state[f"{layers.body.format(2 * len(hidden))}.weight"]))
    if layers.head == layers.body:
        hidden.pop()
    names = Network(family=family, entries=1, lstm=lstm, hidden=tuple(hidden), outputs=1, activation=activation)
    head = f"{names.linear()[-1]}.weight"
    first = f"{layers.recurrent}.weight_ih_l0" if lstm else f"{names.linear()[0]}.weight"
    network = Network(
        family=family,
        entries=state[first].shape[1],
        lstm=lstm,
        hidden=tuple(hidden),
        outputs=len(state[head]),
        activation=activation,
    )
    actor_shapes = network.shapes()
    if any(key not in state or state[key].shape != shape for key, shape in actor_shapes.items()):
        raise NetworkError(f"the network of this {policy_class} has layers that cannot be saved")
    return Actor(network, {key: state[key] for key in actor_shapes})

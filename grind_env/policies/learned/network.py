"""Acting network of trained agents without torch, with the same bits on every computer.

The network has an optional GRU, then linear layers with tanh between them. The last layer gives logits of E and of D.
"""

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from grind_env.envs.episode_state import Episodes
from grind_env.envs.simulation import Simulation
from grind_env.errors import GrindError
from grind_env.kernel.network_layers import linear, logistic_layer, tanh_layer
from grind_env.policies.choices import Decision
from grind_env.policies.learned.agent_spaces import LearnerForm
from grind_env.policies.policy import Sees

Tensor = NDArray[np.float32]
Numbers = NDArray[np.float64]
Shape = tuple[int, ...]

GRU = "gru"  #: name of the GRU in the state of an agent of `grind_env.training.gru_ppo`
FAMILY = "gru"  #: family of networks that a file names; the GRU may be left out
GATES = 3  #: number of gates of a GRU unit; the candidate counts as a gate
ACTIVATION = "tanh"


@dataclass(frozen=True, slots=True, kw_only=True)
class Network:
    """Shape of the acting part of a network.

    Args:
        family: `FAMILY`.
        entries: length of the feature vector.
        lstm: number of units of the GRU; 0 without a GRU.
        hidden: number of units of each hidden layer.
        outputs: number of outputs.
        activation: `ACTIVATION`.
    """

    family: str
    entries: int
    lstm: int
    hidden: tuple[int, ...]
    outputs: int
    activation: str

    def linear(self) -> list[str]:
        """Return the names of the linear layers, in order."""
        # an activation follows each layer but the last
        return [f"actor.{2 * i}" for i in range(len(self.hidden) + 1)]

    def shapes(self) -> dict[str, Shape]:
        """Return the shape of every tensor by its name in the state of the trained policy."""
        shapes: dict[str, Shape] = {}
        width = self.entries
        if self.lstm:
            gates = GATES * self.lstm
            for name, columns in (("ih", width), ("hh", self.lstm)):
                shapes[f"{GRU}.weight_{name}_l0"] = (gates, columns)
                shapes[f"{GRU}.bias_{name}_l0"] = (gates,)
            width += self.lstm
        for name, units in zip(self.linear(), (*self.hidden, self.outputs), strict=True):
            shapes[f"{name}.weight"], shapes[f"{name}.bias"] = (units, width), (units,)
            width = units
        return shapes


class Actor:
    """Network with its weights.

    Args:
        network: shape of the network.
        tensors: weights in float32, with the names and shapes of `network.shapes()`.
    """

    def __init__(self, network: Network, tensors: Mapping[str, Tensor]) -> None:
        self.network = network
        self.tensors = {name: tensors[name] for name in network.shapes()}
        # a layer multiplies weights of shape (inputs, outputs) in double precision
        self._factors = {name: np.ascontiguousarray(values.T, np.float64) for name, values in self.tensors.items()}

    def __repr__(self) -> str:
        """Return a hash of shape and weights, equal in every run: results of a policy are cached by its repr."""
        digest = hashlib.sha256(repr(self.network).encode())
        for values in self.tensors.values():
            digest.update(np.ascontiguousarray(values).tobytes())
        return f"Actor({digest.hexdigest()[:16]})"

    def begin(self, n: int) -> Numbers:
        """Return the output of the GRU of N episodes before their first block, shape (N, units)."""
        return np.zeros((n, self.network.lstm))

    def outputs(self, features: Tensor, state: Numbers) -> tuple[Tensor, Numbers]:
        """Return the outputs of the network, shape (N, outputs), and the next state; rows are independent.

        Args:
            features: shape (N, entries).
            state: state from `begin` or from the last call.
        """
        values: Numbers = np.ascontiguousarray(features, np.float64)
        if self.network.lstm:
            state = self._gru(values, state)
            # the features also bypass the GRU
            values = np.concatenate([state, values], axis=1)
        *body, head = self.network.linear()
        for name in body:
            values = tanh_layer(self._linear(values, f"{name}.weight", f"{name}.bias"))
        return self._linear(values, f"{head}.weight", f"{head}.bias").astype(np.float32), state

    def _gru(self, values: Numbers, state: Numbers) -> Numbers:
        """Return the state after a GRU step (Cho et al., arXiv:1406.1078), with gates and reset as in torch."""
        new = np.split(self._linear(values, f"{GRU}.weight_ih_l0", f"{GRU}.bias_ih_l0"), 3, axis=1)
        old = np.split(self._linear(state, f"{GRU}.weight_hh_l0", f"{GRU}.bias_hh_l0"), 3, axis=1)
        reset, keep = (logistic_layer(new[k] + old[k]) for k in range(2))
        candidate = tanh_layer(new[2] + reset * old[2])
        return candidate + keep * (state - candidate)

    def _linear(self, values: Numbers, weight: str, bias: str) -> Numbers:
        return linear(values, self._factors[weight], self._factors[bias])


@dataclass
class LearnedPolicy:
    """Trained agent that sees measurements only and takes the action with the largest logits.

    Args:
        actor: the network.
        task_name: name of the task on which it was trained.
        form: form of its observations and actions.
        name: name in tables.
        machines: machines on which it was trained; empty if they are unknown.
        remark: sentence to print when the agent is used; empty for none.
    """

    actor: Actor
    task_name: str
    form: LearnerForm
    name: str
    machines: str = field(default="", repr=False)  #: results are cached by the repr
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


def best_actions(space: spaces.MultiDiscrete, values: Tensor) -> NDArray[np.int64]:
    """Return the actions with the largest logits, shape (N, actions), from logits of shape (N, outputs)."""
    parts = np.split(values, np.cumsum(space.nvec)[:-1], axis=1)
    return np.stack([part.argmax(axis=1) for part in parts], axis=1)

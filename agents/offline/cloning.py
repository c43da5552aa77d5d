"""Behaviour cloning of a dataset: a small network that is fitted to what its policy chose, and no more.

E is fitted by squares on the scale of the Box, D as one of its numbers, so that the mean of a dress and none is no half
of one. The student sees one observation, as the dataset has it.
"""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import nn

from agents.offline.dataset import Steps
from grind_env.envs.actions import ActionCodec
from grind_env.envs.episodes import Episodes
from grind_env.envs.simulation import Simulation
from grind_env.policies.choices import Decision
from grind_env.policies.policy import Sees

WIDTH, BATCH, LEARNING_RATE = 128, 256, 1e-3


@dataclass
class Clone:
    """A policy that does what a dataset does where it has seen the like.

    Attributes:
        network: of an observation: E on the scale of the Box, then a logit for each D.
        mean: of the observations of the dataset.
        spread: their standard deviation.
        name: in tables.
    """

    network: nn.Module
    mean: NDArray[np.float32]
    spread: NDArray[np.float32]
    name: str
    sees: Sees = "measurements"
    codec: ActionCodec = field(init=False, repr=False)

    def begin(self, simulation: Simulation, episodes: int) -> None:
        """Learn what can be chosen."""
        self.codec = ActionCodec(simulation.task)

    def act(self, observation: NDArray[np.float32], episodes: Episodes | None) -> Decision:
        """E as fitted, and the likeliest D."""
        with torch.no_grad():
            out = self.network(torch.as_tensor((observation - self.mean) / self.spread)).numpy()
        box = np.zeros((len(out), 2), np.float32)
        box[:, 0] = np.clip(out[:, 0], -1.0, 1.0)
        return Decision(self.codec.decode(box)[0], out[:, 1:].argmax(axis=1).astype(np.float64))


def clone(episodes: list[Steps], simulation: Simulation, name: str, *, epochs: int, seed: int) -> Clone:
    """Fit a network to the episodes of a dataset of this simulation."""
    task = simulation.task
    seen = np.concatenate([observations[:-1] for observations, *_ in episodes])
    box = np.concatenate([actions for _, actions, *_ in episodes])
    mean, spread = seen.mean(axis=0), seen.std(axis=0) + 1e-6
    inputs = torch.as_tensor((seen - mean) / spread)
    speeds, dresses = torch.as_tensor(box[:, 0]), torch.as_tensor(ActionCodec(task).decode(box)[1].astype(np.int64))
    torch.set_num_threads(1)  # so small a network is no faster with more
    torch.manual_seed(seed)
    layers: list[nn.Module] = [nn.Linear(inputs.shape[1], WIDTH), nn.Tanh(), nn.Linear(WIDTH, WIDTH), nn.Tanh()]
    network = nn.Sequential(*layers, nn.Linear(WIDTH, 2 + task.action.executions))
    optimiser: Any = torch.optim.Adam(network.parameters(), lr=LEARNING_RATE)
    for _ in range(epochs):
        for batch in torch.split(torch.randperm(len(inputs)), BATCH):
            out = network(inputs[batch])
            loss: Any = nn.functional.mse_loss(out[:, 0], speeds[batch])
            loss = loss + nn.functional.cross_entropy(out[:, 1:], dresses[batch])
            optimiser.zero_grad()
            loss.backward()
            optimiser.step()
    return Clone(network, mean, spread, name)

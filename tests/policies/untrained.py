"""Agents of Stable-Baselines3 that have not been trained, of each family of networks, and how they are saved."""

from pathlib import Path
from typing import Any

import gymnasium as gym
from gymnasium import spaces
from sb3_contrib import TQC, RecurrentPPO
from stable_baselines3 import DQN, PPO, SAC
from stable_baselines3.common.base_class import BaseAlgorithm

from grind_env.envs.simulation import Simulation
from grind_env.policies.learned.network import acting_part
from grind_env.policies.learned.saved import write_policy
from grind_env.policies.learned.view import LearnerForm
from grind_env.policies.problem import Problem

KINDS: dict[str, tuple[type[BaseAlgorithm], LearnerForm, tuple[int, ...], dict[str, Any]]] = {
    "ppo": (PPO, LearnerForm("belief", "grid"), (128, 128), {}),
    "ppo_stack": (PPO, LearnerForm("stack", "grid"), (128, 128), {}),
    "recurrent_ppo": (RecurrentPPO, LearnerForm("estimates", "grid"), (64,), {"lstm_hidden_size": 64}),
    "dqn": (DQN, LearnerForm("belief", "index"), (128, 128), {}),
    "sac": (SAC, LearnerForm("belief", "box"), (128, 128), {}),
    "tqc": (TQC, LearnerForm("belief", "box"), (128, 128), {}),
}
"""Algorithm, what it sees and how it acts, hidden layers, and arguments of the network."""


class Spaces(gym.Env[Any, Any]):
    """All that Stable-Baselines3 asks of an environment before it trains."""

    def __init__(self, seen: spaces.Space[Any], acting: spaces.Space[Any]) -> None:
        self.observation_space, self.action_space = seen, acting


def untrained(problem: Problem, kind: str = "ppo", seed: int = 3) -> Any:
    """An agent of a kind for a problem."""
    algorithm, form, hidden, more = KINDS[kind]
    view = form.view(problem.simulation())
    policy = "MlpLstmPolicy" if algorithm is RecurrentPPO else "MlpPolicy"
    kwargs = {"net_arch": list(hidden), **more}
    env = Spaces(view.observation_space, view.action_space)
    return algorithm(policy, env, policy_kwargs=kwargs, seed=seed, device="cpu")  # type: ignore[call-arg]


def save(path: Path, model: Any, simulation: Simulation, kind: str = "ppo") -> None:
    """Write what acting needs of it."""
    state = {name: values.detach().cpu().numpy() for name, values in model.policy.state_dict().items()}
    actor = acting_part(type(model.policy).__name__, state, model.policy.activation_fn.__name__.lower())
    write_policy(path, actor, simulation, kind, KINDS[kind][1], {"settings": {"split": "inner"}})

"""Untrained agents with and without a GRU, and a function that saves them."""

from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium import spaces
from stable_baselines3 import PPO

from grind_env.envs.simulation import Simulation
from grind_env.policies.learned.agent_spaces import LearnerForm
from grind_env.policies.learned.network import Actor, LearnedPolicy
from grind_env.policies.learned.saved import write_policy
from grind_env.policies.problem_lookup import Problem
from tests.policies.harness import network_of

#: observations of agents of Stable-Baselines3
KINDS = {"ppo": LearnerForm("belief"), "ppo_stack": LearnerForm("stack")}
#: layers of an agent file by the layers of Stable-Baselines3
ACTOR = {"mlp_extractor.policy_net.0": "actor.0", "mlp_extractor.policy_net.2": "actor.2", "action_net": "actor.4"}


class Spaces(gym.Env[Any, Any]):
    """Environment with spaces alone: Stable-Baselines3 needs no more to create an agent."""

    def __init__(self, seen: spaces.Space[Any], acting: spaces.Space[Any]) -> None:
        self.observation_space, self.action_space = seen, acting


def untrained(problem: Problem, kind: str = "ppo", seed: int = 3) -> Any:
    """Return an untrained agent of a kind for a problem."""
    view = KINDS[kind].view(problem.simulation())
    env = Spaces(view.observation_space, view.action_space)
    return PPO("MlpPolicy", env, policy_kwargs={"net_arch": [128, 128]}, seed=seed, device="cpu")


def recurrent(simulation: Simulation, lstm: int = 24) -> LearnedPolicy:
    """Return an agent with a GRU."""
    form, rng = LearnerForm("none"), np.random.default_rng(5)
    network = network_of(simulation, form, lstm=lstm)
    tensors = {name: rng.normal(0.0, 0.3, shape).astype(np.float32) for name, shape in network.shapes().items()}
    return LearnedPolicy(Actor(network, tensors), simulation.task.name, form, "gru")


def save(path: Path, model: Any, simulation: Simulation, kind: str = "ppo") -> None:
    """Write the parts of an agent of Stable-Baselines3 that it needs to act."""
    state = model.policy.state_dict()
    tensors = {
        f"{own}.{part}": state[f"{name}.{part}"].numpy() for name, own in ACTOR.items() for part in ("weight", "bias")
    }
    actor = Actor(network_of(simulation, KINDS[kind]), tensors)
    write_policy(path, actor, simulation, kind, KINDS[kind], {"settings": {"split": "inner"}})

"""Writes what acting needs of a trained model of Stable-Baselines3; `grind_env.policies.learned.saved` reads it."""

from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any

from agents.learning.settings import Settings
from agents.provenance import commit, installed
from grind_env.envs.simulation import Simulation
from grind_env.policies.held import machines_name
from grind_env.policies.learned.network import acting_part
from grind_env.policies.learned.saved import write_policy
from grind_env.policies.learned.view import LearnerForm

PACKAGES = ("grind_env", "numpy", "stable_baselines3", "sb3_contrib", "torch")


def save_policy(path: Path, model: Any, simulation: Simulation, kind: str, settings: Settings) -> None:
    """Write what acting needs of a trained model, whole or not at all; its folder is made.

    Args:
        path: a .safetensors file.
        model: an algorithm of Stable-Baselines3 or sb3-contrib.
        simulation: what it was trained on.
        kind: name of the kind of agent.
        settings: that it was trained with.

    Raises:
        PolicyFileError: if its policy is of no known family, or its weights are not finite or too large.
    """
    policy = model.policy
    state = {name: values.detach().cpu().numpy() for name, values in policy.state_dict().items()}
    actor = acting_part(type(policy).__name__, state, policy.activation_fn.__name__.lower())
    beside = {
        "settings": {each.name: _plain(getattr(settings, each.name)) for each in fields(settings)},
        "machines": machines_name(simulation),
        "versions": {package: installed(package) for package in PACKAGES},
        "commit": commit(),
    }
    write_policy(path, actor, simulation, kind, LearnerForm(settings.memory, settings.actions), beside)


def _plain(value: Any) -> Any:
    """A setting as JSON has it."""
    return dict(value) if isinstance(value, Mapping) else value

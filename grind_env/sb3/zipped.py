"""Reads the .zip of a model that Stable-Baselines3 has saved, which can run code of its author."""

from pathlib import Path
from typing import Any, get_args

from stable_baselines3.common.save_util import load_from_zip_file

from grind_env.envs.simulation import Simulation
from grind_env.errors import reason
from grind_env.policies.learned.network import LearnedPolicy, acting_part
from grind_env.policies.learned.saved import PolicyFileError, check_sums, fits
from grind_env.policies.learned.view import Actions, LearnerView, MemoryKind


def load_zip(path: Path, simulation: Simulation) -> LearnedPolicy:
    """The agent in a trusted .zip of Stable-Baselines3; memory and actions are those that fit its network.

    Raises:
        PolicyFileError: it holds no such agent, or one of other observations or actions.
    """
    try:
        loaded: Any = load_from_zip_file(path, device="cpu")
        data, parameters, _ = loaded
        policy_class = data["policy_class"].__name__
        default = "tanh" if "ActorCritic" in policy_class else "relu"
        chosen = data["policy_kwargs"].get("activation_fn")
        activation = default if chosen is None else chosen.__name__.lower()
        actor = acting_part(policy_class, {key: each.numpy() for key, each in parameters["policy"].items()}, activation)
    except Exception as error:
        # a pickle runs whatever its author wrote, which may raise anything; PyTorch goes on to advise more trust
        said = reason(error).partition(". ")[0]
        raise PolicyFileError(f"{path} holds no model of Stable-Baselines3 ({said})") from None
    for memory in get_args(MemoryKind):
        for actions in get_args(Actions):
            if fits(actor.network, LearnerView(simulation, memory, actions)):
                check_sums(path, actor.network, actor.tensors)
                return LearnedPolicy(actor, simulation.task.name, memory, actions, path.stem)
    raise PolicyFileError(f"{path} was not trained for {simulation.task.name}: its observations or actions differ")

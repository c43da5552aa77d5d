"""Reads the .zip of a model that Stable-Baselines3 has saved, which can run code of its author."""

from pathlib import Path
from typing import Any, get_args

from stable_baselines3.common.save_util import load_from_zip_file

from grind_env.envs.shown import ShownBox
from grind_env.envs.simulation import Simulation
from grind_env.errors import reason
from grind_env.policies.learned.network import LearnedPolicy, acting_part
from grind_env.policies.learned.saved import PolicyFileError, check_sums, fits
from grind_env.policies.learned.view import Actions, LearnerForm, MemoryKind, ViewForm
from grind_env.sb3.shown_view import check_scale, shown_form


def load_zip(path: Path, simulation: Simulation) -> LearnedPolicy:
    """The agent in a trusted .zip of Stable-Baselines3.

    What it saw and how it acts its spaces say, if it was trained in an environment of this package; else it is taken
    for one of `python -m agents`, with the memory and the actions that fit its network.

    Raises:
        GrindError: it holds no such agent, or one of other observations or actions.
    """
    try:
        loaded: Any = load_from_zip_file(path, device="cpu")
        data, parameters, _ = loaded
        policy_class = data["policy_class"].__name__
        default = "tanh" if "ActorCritic" in policy_class else "relu"
        chosen = data["policy_kwargs"].get("activation_fn")
        activation = default if chosen is None else chosen.__name__.lower()
        actor = acting_part(policy_class, {key: each.numpy() for key, each in parameters["policy"].items()}, activation)
        seen, acting, last = (data.get(key) for key in ("observation_space", "action_space", "_last_obs"))
    except Exception as error:
        # a pickle runs whatever its author wrote, which may raise anything; PyTorch goes on to advise more trust
        said = reason(error).partition(". ")[0]
        raise PolicyFileError(f"{path} holds no model of Stable-Baselines3 ({said})") from None
    forms: list[ViewForm]
    if isinstance(seen, ShownBox):
        check_scale(str(path), seen, last)
        forms = [shown_form(seen, acting, str(path))]
    else:
        forms = [LearnerForm(memory, actions) for memory in get_args(MemoryKind) for actions in get_args(Actions)]
    for form in forms:
        if fits(actor.network, form.view(simulation)):
            check_sums(path, actor.network, actor.tensors)
            return LearnedPolicy(actor, simulation.task.name, form, path.stem)
    raise PolicyFileError(
        f"{path} was not trained for {simulation.task.name}: its observations or actions differ; one trained in"
        " an environment of an older grind_env does not say what it saw, and has to be trained anew"
    )

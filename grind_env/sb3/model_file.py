"""Read the .zip of a Stable-Baselines3 model, which can run code of its author."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

from stable_baselines3.common.save_util import load_from_zip_file

from grind_env.envs.simulation import Simulation
from grind_env.errors import GrindError
from grind_env.message_text import reason
from grind_env.policies.learned.saved import PolicyFileError
from grind_env.sb3.model_policy import ModelPolicy


def load_zip(path: Path, simulation: Simulation) -> ModelPolicy:
    """Return the agent in a trusted .zip of Stable-Baselines3 that was trained in an environment of this package.

    Raises:
        GrindError: the file holds no such agent, or an agent for another task or with other observations or actions.
    """
    try:
        loaded: Any = load_from_zip_file(path, device="cpu")
        data, parameters, _ = loaded
        seen, acting, last = (data.get(key) for key in ("observation_space", "action_space", "_last_obs"))
        policy = data["policy_class"](seen, acting, lambda left: 0.0, **data["policy_kwargs"])
        policy.load_state_dict(parameters["policy"])
    except Exception as error:
        # code in a pickle may raise any error; later sentences of PyTorch's messages advise to trust the file
        said = reason(error).partition(". ")[0]
        raise PolicyFileError(f"{path} holds no model of Stable-Baselines3 ({said})") from None
    model: Any = SimpleNamespace(
        policy=policy,
        predict=policy.predict,
        observation_space=seen,
        action_space=acting,
        env=None,
        _last_obs=last,
        get_vec_normalize_env=lambda: None,
    )
    try:
        found = ModelPolicy(model, path.stem)
        found.form.view(simulation)
    except GrindError as error:
        raise PolicyFileError(f"{path}: {error}") from None
    return found

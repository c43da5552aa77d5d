"""The algorithms of Stable-Baselines3 and sb3-contrib, and our own, built from settings."""

from pathlib import Path
from typing import Any

from sb3_contrib import TQC, RecurrentPPO
from stable_baselines3 import DQN, PPO, SAC
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.logger import Logger, configure
from stable_baselines3.common.utils import LinearSchedule
from stable_baselines3.common.vec_env import VecEnv

from agents.learning.imitation import ClonedPPO
from agents.learning.settings import Settings
from grind_env.policies.tuned import ConfigError

ALGORITHMS: dict[str, type[BaseAlgorithm]] = {
    "ppo": PPO,
    "recurrent_ppo": RecurrentPPO,
    "dqn": DQN,
    "sac": SAC,
    "tqc": TQC,
    "cloned_ppo": ClonedPPO,
}

OF_THE_NETWORK = ("lstm_hidden_size", "n_quantiles", "n_critics")
"""Arguments of the network, not of the algorithm."""


def build(settings: Settings, env: VecEnv, seed: int, log: Path | None = None) -> BaseAlgorithm:
    """A new agent.

    Args:
        settings: of it.
        env: to train in; it is seeded with `seed`, too.
        seed: of the network and of what it draws.
        log: folder of the TensorBoard files; none by default.

    Raises:
        ConfigError: if the settings are not of the algorithm.
    """
    if settings.algorithm not in ALGORITHMS:
        raise ConfigError(f"there is no algorithm {settings.algorithm!r}: choose from {', '.join(ALGORITHMS)}")
    arguments: dict[str, Any] = {name: value for name, value in settings.hyper.items() if name not in OF_THE_NETWORK}
    if "learning_rate" in arguments:
        arguments["learning_rate"] = LinearSchedule(arguments["learning_rate"], 0.0, 1.0)
    network = {name: settings.hyper[name] for name in OF_THE_NETWORK if name in settings.hyper}
    try:
        model = ALGORITHMS[settings.algorithm](
            "MlpLstmPolicy" if settings.algorithm == "recurrent_ppo" else "MlpPolicy",
            env,
            policy_kwargs={"net_arch": list(settings.hidden), **network},
            seed=seed,
            device="cpu",
            **arguments,
        )
    except (TypeError, ValueError, AssertionError) as error:
        raise ConfigError(f"the settings of {settings.algorithm} do not fit it: {error}") from error
    attach_log(model, log)
    return model


def attach_log(model: BaseAlgorithm, log: Path | None) -> None:
    """Let the agent write its metrics for TensorBoard into a folder, or nowhere."""
    model.set_logger(Logger(None, []) if log is None else configure(str(log), ["tensorboard"]))

"""The kinds of learned agents and their settings: defaults here, what was tuned for a task in `configs/learning/`."""

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any, get_args

from grind_env.envs.contexts import find_split
from grind_env.envs.learning import WORST_REWARD
from grind_env.envs.tasks import Task
from grind_env.errors import did_you_mean, quoted, reason
from grind_env.policies.learned.view import Actions, MemoryKind
from grind_env.policies.problem import Problem
from grind_env.policies.tuned import ConfigError, tuned_folder
from grind_env.toml import read_toml

CONFIGS = Path(__file__).parents[1] / "configs" / "learning"

TRAINING_SEEDS, SEED_STRIDE = 100_000, 1_000
"""First env seed (one of the training seeds) and the distance between those of two training seeds."""

LAST_SEED = 398
"""Training seeds of agents; beyond it env seeds would reach into those of validation."""

Number = float | int


@dataclass(frozen=True, slots=True, kw_only=True)
class Settings:
    """How an agent is trained.

    Raises:
        ConfigError: if there is no such memory or form of actions, or a number is out of its range.
        ContextError: if there is no such split.
    """

    algorithm: str
    """One of `agents.learning.algorithms.ALGORITHMS`."""
    steps: int
    """Environment steps of a whole training."""
    envs: int
    memory: MemoryKind
    actions: Actions
    hidden: tuple[int, ...] = (128, 128)
    """Widths of the hidden layers of actor and critic."""
    split: str = "inner"
    """Contexts of the training episodes; of `inner`, so that those of `interpolation` are new to the agent."""
    worst_reward: float = WORST_REWARD
    """Rewards below are cut, so that one scrapped part does not drown an update."""
    hyper: Mapping[str, Number]
    """Arguments of the algorithm, by the names of Stable-Baselines3; `learning_rate` falls linearly to 0."""

    def __post_init__(self) -> None:
        # in one order, so that equal settings read the same
        object.__setattr__(self, "hyper", dict(sorted(self.hyper.items())))
        find_split(self.split)
        for name, legal in (("memory", get_args(MemoryKind)), ("actions", get_args(Actions))):
            if getattr(self, name) not in legal:
                raise ConfigError(f"{name} is {quoted(getattr(self, name))}, but must be one of {', '.join(legal)}")
        for name in ("steps", "envs", *(["hidden"] if self.hidden else [])):
            values = getattr(self, name)
            if min(values if isinstance(values, tuple) else (values,)) < 1:
                raise ConfigError(f"{name} is {values}, but must be at least 1")


PPO = Settings(
    algorithm="ppo",
    steps=1_000_000,
    envs=128,
    memory="belief",
    actions="grid",
    hyper={
        "n_steps": 60,
        "batch_size": 960,
        "n_epochs": 4,
        "learning_rate": 2e-3,
        "gamma": 0.97,
        "gae_lambda": 0.90,
        "ent_coef": 0.003,
    },
)
"""Those of the training recipe: many environments and few epochs, because the environment is fast."""

GENTLE: Mapping[str, Number] = {**PPO.hyper, "batch_size": 3840, "learning_rate": 1e-3}
"""Of a network that knows something already, or remembers: larger batches, smaller steps."""

REPLAY: Mapping[str, Number] = {
    "buffer_size": 200_000,
    "learning_starts": 10_000,
    "batch_size": 512,
    "train_freq": 1,
    "gradient_steps": 8,
    "learning_rate": 1e-3,
    "gamma": 0.97,
}
"""Of the algorithms that learn from a replay buffer: a few gradient steps after every step of all environments."""

DEFAULTS: dict[str, Settings] = {
    "ppo": PPO,
    "ppo_stack": replace(PPO, memory="stack"),
    "recurrent_ppo": replace(
        PPO,
        algorithm="recurrent_ppo",
        memory="estimates",
        steps=1_000_000,
        envs=256,
        hidden=(64,),
        hyper={**GENTLE, "lstm_hidden_size": 64},
    ),
    "dqn": Settings(
        algorithm="dqn",
        steps=200_000,
        envs=64,
        memory="belief",
        actions="index",
        hyper={
            **REPLAY,
            "target_update_interval": 6400,
            "exploration_fraction": 0.3,
            "exploration_final_eps": 0.02,
        },
    ),
    "sac": Settings(algorithm="sac", steps=120_000, envs=64, memory="belief", actions="box", hyper=REPLAY),
    "tqc": Settings(algorithm="tqc", steps=120_000, envs=64, memory="belief", actions="box", hyper=REPLAY),
    "bc": replace(
        PPO,
        algorithm="cloned_ppo",
        steps=40_000,
        envs=64,
        hyper={**GENTLE, "n_epochs": 6, "n_steps": 240, "labels": 40_000},
    ),
    "bc_ppo": replace(PPO, algorithm="cloned_ppo", envs=256, hyper={**GENTLE, "n_epochs": 6, "labels": 40_000}),
}
"""The kinds by name."""


def settings_folder(task: Task) -> Path:
    """Where the settings that were tuned for a task lie; those for a user's file with its other parameters."""
    return tuned_folder(task) / "learning" if task.file else CONFIGS


def settings_of(problem: Problem, kind: str, steps: int | None = None, split: str | None = None) -> Settings:
    """The settings of a kind for a problem, with other steps or another split where these are given.

    Raises:
        GrindError: if there is no such kind or split, or the file of its settings is damaged.
    """
    settings = settings_for(kind, problem.name, settings_folder(problem.simulation().task))
    return replace(
        settings,
        steps=settings.steps if steps is None else steps,
        split=settings.split if split is None else split,
    )


def settings_for(kind: str, name: str, folder: Path = CONFIGS) -> Settings:
    """The settings of a kind for a problem of that name: the defaults, and over them `[<kind>]` of `<name>.toml`.

    The file may set any field, and in `[<kind>.hyper]` single arguments of the algorithm.

    Raises:
        ConfigError: if there is no such kind, or the file is damaged or sets something else.
    """
    if kind not in DEFAULTS:
        raise ConfigError(
            f"there is no kind of agent {quoted(kind)}{did_you_mean(kind, DEFAULTS)}: choose from {', '.join(DEFAULTS)}"
        )
    default = DEFAULTS[kind]
    path = folder / f"{name}.toml"
    if not path.exists():
        return default
    try:
        changes: dict[str, Any] = dict(read_toml(path).get(kind, {}))
        if unknown := set(changes) - {field.name for field in fields(Settings)}:
            raise ConfigError(f"{path}: [{kind}] sets {quoted(min(unknown))}, which is no setting")
        changes["hyper"] = {**default.hyper, **changes.get("hyper", {})}
        if "hidden" in changes:
            changes["hidden"] = tuple(changes["hidden"])
        return replace(default, **changes)
    except (TypeError, ValueError) as error:
        raise ConfigError(f"{path} is damaged ({reason(error)}): mend its table [{kind}] or delete it") from error

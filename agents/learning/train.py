"""Training with Stable-Baselines3."""

import hashlib
import tempfile
import zipfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.utils import LinearSchedule

from agents.learning.features import LearnerVecEnv, LearnerView
from agents.policy import Decision, Sees
from agents.provenance import code_hash
from grind_env.envs.simulation import Episodes
from grind_env.envs.tasks import Task
from grind_env.envs.vector_env import GrindVectorEnv
from grind_env.errors import GrindError

TRAINING_SEEDS, SEED_STRIDE = 100_000, 1_000
"""First env seed (of the training split) and the distance between those of two training seeds."""

LAST_SEED = 398
"""Training seeds beyond it would reach into the validation split."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Training:
    """Settings of PPO: many environments, large batches and few epochs, because the environment is fast."""

    steps: int = 4_000_000
    envs: int = 256
    rollout: int = 60
    batch: int = 3840
    epochs: int = 6
    learning_rate: float = 1e-3
    discount: float = 0.97
    gae_lambda: float = 0.90
    entropy: float = 0.003
    hidden: tuple[int, ...] = (128, 128)
    worst_reward: float = -10.0


def train_ppo(task: Task, seed: int, path: Path, training: Training | None = None) -> None:
    """Train PPO and save it to `path` (.zip), atomically. The same seed gives the same agent.

    Args:
        task: task to train on.
        seed: of the network, the actions and the training episodes.
        path: file to write; its folder is made.
        training: settings.
    """
    training = Training() if training is None else training
    # more threads are slower at this size, and on a busy machine by an order of magnitude
    torch.set_num_threads(1)
    env = LearnerVecEnv(
        GrindVectorEnv(training.envs, task=task.name, observation="measured", autoreset_mode="SameStep"),
        training.worst_reward,
    )
    model = PPO(
        "MlpPolicy",
        env,
        n_steps=training.rollout,
        batch_size=training.batch,
        n_epochs=training.epochs,
        learning_rate=LinearSchedule(training.learning_rate, 0.0, 1.0),
        gamma=training.discount,
        gae_lambda=training.gae_lambda,
        ent_coef=training.entropy,
        policy_kwargs={"net_arch": list(training.hidden)},
        seed=seed,
        device="cpu",
    )
    # after PPO has seeded it, the env gets seeds of its own, far from those of evaluation
    env.seed(TRAINING_SEEDS + SEED_STRIDE * seed)
    with Progress(
        TextColumn("training PPO"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeRemainingColumn(),
        TextColumn("{task.fields[reward]}"),
    ) as progress:
        model.learn(training.steps, callback=_ProgressBar(progress, training.steps))
    path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=path.parent) as folder:
        unfinished = Path(folder) / "model.zip"
        model.save(unfinished)
        unfinished.replace(path)


def trained_agent(task: Task, seed: int, steps: int, folder: Path, fresh: bool = False) -> Path:
    """The file of an agent, in the task's sub-folder of `folder`.

    It is trained unless an agent of the same code, settings and seed is there, or `fresh` is asked for.
    """
    training = Training(steps=steps)
    made_by = hashlib.sha256(f"{code_hash()} {task.name} {training} {seed}".encode()).hexdigest()[:12]
    path = folder / task.name / f"ppo-{seed}-{made_by}.zip"
    if fresh or not path.exists():
        train_ppo(task, seed, path, training)
    return path


class _ProgressBar(BaseCallback):
    """Steps done and the mean reward of the last rollout."""

    def __init__(self, progress: Progress, total: int) -> None:
        super().__init__()
        self.progress = progress
        self.bar = progress.add_task("", total=total, reward="")

    def _on_step(self) -> bool:
        return True

    def _on_rollout_end(self) -> None:
        text = f"training reward {float(np.mean(self.locals['rollout_buffer'].rewards)):+.3f} a step"
        self.progress.update(self.bar, completed=self.num_timesteps, reward=text)


class LearnedPolicy:
    """A trained PPO agent as a policy; it sees measurements only and takes its most likely action.

    Args:
        path: file written by `train_ppo`.
        name: name in tables.

    Raises:
        GrindError: if the file is not there or holds no such agent.
    """

    sees: Sees = "measurements"

    def __init__(self, path: Path, name: str = "PPO") -> None:
        if not path.is_file():
            raise GrindError(f"there is no trained agent at {path}: run `python -m agents train` first")
        self.name, self.path = name, path
        try:
            self.model = PPO.load(path, device="cpu")
        except (ValueError, KeyError, RuntimeError, OSError, zipfile.BadZipFile) as error:
            raise GrindError(f"{path} holds no agent that `python -m agents train` saved: train one anew") from error
        self.view: LearnerView | None = None

    def begin(self, task: Task, episodes: int) -> None:
        """That many episodes of the task begin; a `GrindError` if the agent was trained on a task of other spaces."""
        self.view = LearnerView(task)
        spaces = (self.view.observation_space, self.view.action_space)
        if (self.model.observation_space, self.model.action_space) != spaces:
            raise GrindError(f"{self.path} was not trained for {task.name}: its observations or actions differ")
        self.view.begin(episodes)

    def act(self, observation: NDArray[np.float32], episodes: Episodes | None) -> Decision:
        """Decide the coming block."""
        assert self.view is not None
        actions, _ = self.model.predict(self.view.features(observation), deterministic=True)
        return self.view.decide(np.asarray(actions))

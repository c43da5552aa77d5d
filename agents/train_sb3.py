"""Train an agent of Stable-Baselines3: the recipe of `docs/howto/train.md` as a script with checkpoints.

    python -m agents.train_sb3 --task power_limited --algorithm ppo --seed 0 --output agent.zip
    grind evaluate --task power_limited --policy agent.zip --trust

PPO has the settings of the recipe; the settings of A2C, SAC and DQN are not tuned. Repeat the command to resume a
killed training from its checkpoint; the agent is the same. A checkpoint is a pickle: resume only your own.
"""

import json
import pickle
import random
import time
import zipfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from operator import mul
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import torch
import typer
from stable_baselines3 import A2C, DQN, PPO, SAC
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.callbacks import BaseCallback

from agents.provenance import installed
from grind_env.command_exit import command
from grind_env.envs.wrappers import VectorBeliefFilter, VectorForLearning
from grind_env.errors import GrindError
from grind_env.file_arguments import Application, Writes
from grind_env.files import write_atomically
from grind_env.message_text import did_you_mean, printable, quoted, reason
from grind_env.policies.nominal_model import training_machines
from grind_env.policies.problem_lookup import Problem, find_problem
from grind_env.policy_commands import NamedProblem
from grind_env.sb3 import SB3VecEnv
from grind_env.training.gru_ppo import LAST_SEED

CHECKPOINTS = 24  #: number of checkpoints in a training
VERSIONS = [installed(each) for each in ("grind_env", "numpy", "stable_baselines3", "torch")]


@dataclass(frozen=True)
class Recipe:
    """Algorithm with its settings; the learning rate falls linearly to 0."""

    algorithm: type[BaseAlgorithm]
    action: str
    envs: int
    learning_rate: float
    hyper: Mapping[str, Any]


REPLAY = {"buffer_size": 200_000, "learning_starts": 10_000, "batch_size": 512, "train_freq": 1, "gradient_steps": 8}
RECIPES = {
    "ppo": Recipe(
        PPO,
        "multidiscrete",
        128,
        2e-3,
        {"n_steps": 60, "batch_size": 960, "n_epochs": 4, "gamma": 0.97, "gae_lambda": 0.9, "ent_coef": 0.003},
    ),
    "a2c": Recipe(A2C, "multidiscrete", 128, 1e-3, {"n_steps": 10, "gamma": 0.97, "gae_lambda": 0.9}),
    "sac": Recipe(SAC, "box", 64, 1e-3, {**REPLAY, "gamma": 0.97}),
    "dqn": Recipe(DQN, "discrete", 64, 1e-3, {**REPLAY, "gamma": 0.97, "exploration_fraction": 0.3}),
}


class Checkpoints(BaseCallback):
    """Callback that writes the training to a file after every `every` steps, between two updates."""

    def __init__(self, path: Path, every: int) -> None:
        super().__init__()
        self.path, self.every = path, every

    def _on_training_start(self) -> None:
        self.last, self.begin = self.num_timesteps, time.process_time()

    def _on_rollout_start(self) -> None:
        if self.num_timesteps // self.every > self.last // self.every:
            self.last = self.num_timesteps
            self._count()
            generators = random.getstate(), np.random.get_state(), torch.get_rng_state()
            training = (VERSIONS, generators, self.model)
            write_atomically(self.path, partial(torch.save, training))

    def _on_step(self) -> bool:
        return True

    def _on_training_end(self) -> None:
        self._count()

    def _count(self) -> None:
        model: Any = self.model
        now = time.process_time()
        model.cpu_seconds += now - self.begin
        self.begin = now


def train(problem: Problem, algorithm: str, seed: int, steps: int, path: Path, *, belief: bool = True) -> BaseAlgorithm:
    """Train an agent, or resume its training, and save it as a .zip file; the checkpoint beside it is then deleted.

    Raises:
        GrindError: there is no such algorithm, or the checkpoint is damaged or of another training.
    """
    if algorithm not in RECIPES:
        raise GrindError(
            f"there is no algorithm {quoted(algorithm)}{did_you_mean(algorithm, RECIPES)}:"
            f" choose from {', '.join(RECIPES)}"
        )
    torch.set_num_threads(1)  # a second thread slows down networks of this size
    checkpoint = path.with_suffix(".checkpoint")
    path.parent.mkdir(parents=True, exist_ok=True)
    asked = f"{problem.name} {algorithm} seed {seed} belief {belief} steps {steps}"
    model: Any = resumed(checkpoint, asked) if checkpoint.exists() else begun(problem, algorithm, seed, belief)
    model.training = asked
    model.learn(
        steps - model.num_timesteps,
        Checkpoints(checkpoint, max(steps // CHECKPOINTS, 1)),
        reset_num_timesteps=model.num_timesteps == 0,
    )
    write_atomically(path, model.save)
    checkpoint.unlink(missing_ok=True)
    found: BaseAlgorithm = model
    return found


def begun(problem: Problem, algorithm: str, seed: int, belief: bool) -> Any:
    """Return an untrained agent with its environments."""
    recipe = RECIPES[algorithm]
    envs: Any = problem.make_vec(recipe.envs, action=recipe.action, autoreset_mode="SameStep")
    if belief:
        envs = VectorBeliefFilter(envs)
    rate: Callable[[float], float] = partial(mul, recipe.learning_rate)
    model: Any = recipe.algorithm(
        "MlpPolicy", SB3VecEnv(VectorForLearning(envs)), learning_rate=rate, seed=seed, **recipe.hyper
    )
    model.cpu_seconds = 0.0
    return model


def resumed(path: Path, asked: str) -> Any:
    """Return the training in a checkpoint, and restore the random generators.

    Raises:
        GrindError: the checkpoint is damaged, of another training or of other versions.
    """
    try:
        versions, generators, model = torch.load(path, weights_only=False)
    except (OSError, EOFError, pickle.UnpicklingError, RuntimeError, ValueError, ImportError, AttributeError) as error:
        raise GrindError(f"{path} is damaged ({reason(error)}): delete it to train anew") from error
    if (versions, model.training) != (VERSIONS, asked):
        raise GrindError(f"{path} is of another training ({model.training}): delete it, or name another --output")
    random.setstate(generators[0])
    np.random.set_state(generators[1])
    torch.set_rng_state(generators[2])
    return model


def trained(path: Path) -> tuple[int, float]:
    """Return the environment steps and the CPU time, s, of the training of an agent that `train` saved."""
    with zipfile.ZipFile(path) as file:
        data = json.loads(file.read("data"))
    return data["num_timesteps"], data["cpu_seconds"]


app = Application()


@app.command(epilog="python -m agents.train_sb3 --task rush --algorithm sac --steps 200000 -o rush.zip")
def main(
    output: Annotated[Path, typer.Option("--output", "-o", help="The .zip file of the agent."), Writes()],
    task: NamedProblem = "power_limited",
    algorithm: Annotated[str, typer.Option(help=f"{', '.join(RECIPES)}.")] = "ppo",
    seed: Annotated[int, typer.Option(min=0, max=LAST_SEED, help="Seed of the agent and its episodes.")] = 0,
    steps: Annotated[int, typer.Option(min=1, help="Environment steps.")] = 1_000_000,
    belief: Annotated[bool, typer.Option(help="Show the belief in the hidden wheel.")] = True,
) -> None:
    """Train an agent of Stable-Baselines3; repeat the command to resume a killed training."""
    problem = training_machines(find_problem(task), None)
    train(problem, algorithm, seed, steps, output, belief=belief)
    print(printable(f"agent: {output}; judge it by: grind evaluate --task {task} --policy {output} --trust"))


if __name__ == "__main__":
    with command("agents.train_sb3"):
        app()

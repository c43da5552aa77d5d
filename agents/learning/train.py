"""Training that survives: killed at any moment, the same command goes on where it was and ends in the same agent."""

import hashlib
import inspect
import shutil
from contextlib import suppress
from pathlib import Path

import torch
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.off_policy_algorithm import OffPolicyAlgorithm

from agents.cells import RUNS, Advance, bare, behaviour, sources
from agents.learning import algorithms, imitation, training_env
from agents.learning.algorithms import attach_log, build
from agents.learning.checkpoint import Training, checkpoint_path, read_checkpoint, remove_checkpoints, write_checkpoint
from agents.learning.curve import curve_path, write_curve
from agents.learning.saving import save_policy
from agents.learning.settings import (
    DEFAULTS,
    LAST_SEED,
    SEED_STRIDE,
    TRAINING_SEEDS,
    Settings,
    settings_of,
)
from agents.learning.training_env import LearnerVecEnv
from agents.learning.validation import LiveAgent, Validation
from agents.learning.watch import Watch
from agents.provenance import installed
from grind_env.belief.wheel import BeliefError
from grind_env.envs.tasks import Task
from grind_env.errors import GrindError
from grind_env.policies.learned.saved import SUFFIX
from grind_env.policies.problem import Problem
from grind_env.policies.tuned import tuned_arguments

POINTS = 24
"""Points of the learning curve, and checkpoints, of a training."""

LIBRARIES = ("torch", "stable_baselines3", "sb3_contrib", "numpy")


def trained_agent(
    problem: Problem,
    kind: str,
    seed: int,
    steps: int | None = None,
    folder: Path = RUNS,
    fresh: bool = False,
    *,
    split: str | None = None,
    quiet: bool = False,
    advance: Advance = lambda steps: None,
) -> Path:
    """The file of an agent, `<kind>-<seed>-<hash>.safetensors` in the problem's sub-folder of `folder`.

    It is trained unless an agent of the same code, settings and seed is there. A training that was interrupted goes
    on from its checkpoint. The learning curve lies beside the agent, the metrics for TensorBoard in
    `<folder>/<problem>/tensorboard/`.

    Args:
        problem: to train on.
        kind: of the agent; see `agents.learning.settings`.
        seed: of the network, of what it draws, and of the training episodes.
        steps: environment steps; by default those of the settings.
        folder: of the results.
        fresh: train even if the agent or a checkpoint is there.
        split: contexts of the training episodes; by default those of the settings.
        quiet: show no progress.
        advance: called with the number of steps that have been done, or were kept.

    Raises:
        GrindError: if there is no such kind or split, its settings do not fit, or its checkpoint is damaged.
    """
    settings = settings_of(problem, kind, steps, split)
    return train(problem, kind, seed, settings, folder, fresh=fresh, quiet=quiet, advance=advance)


def train(
    problem: Problem,
    kind: str,
    seed: int,
    settings: Settings,
    folder: Path,
    *,
    fresh: bool = False,
    quiet: bool = False,
    advance: Advance = lambda steps: None,
) -> Path:
    """As `trained_agent`, with settings of one's own."""
    if not 0 <= seed <= LAST_SEED or settings.envs > SEED_STRIDE:
        raise GrindError(
            f"the seed is {seed} and there are {settings.envs} environments, but training has seeds from 0 to"
            f" {LAST_SEED} and at most {SEED_STRIDE} environments"
        )
    stem = folder / problem.name / f"{kind}-{seed}-{fingerprint(problem, kind, settings, seed)}"
    path, checkpoint = stem.with_suffix(SUFFIX), checkpoint_path(stem)
    log = stem.parent / "tensorboard" / stem.name
    if fresh:
        path.unlink(missing_ok=True)
        remove_checkpoints(stem)
    if not path.exists():
        path.parent.mkdir(parents=True, exist_ok=True)
        # more threads are slower at this size, and on a busy machine by an order of magnitude
        torch.set_num_threads(1)
        if checkpoint.exists():
            training = read_checkpoint(checkpoint)
            attach_log(training.model, log)
        else:
            # what is left there is of a training that had no checkpoint yet
            with suppress(FileNotFoundError):
                shutil.rmtree(log)
            training = Training(_first_model(problem, kind, seed, settings, log), [], {})
        with Console(quiet=quiet) as console:
            _finish(training, problem, f"{problem.name} {kind} {seed}", settings, checkpoint, console, advance)
        write_curve(curve_path(path), training.points)
        save_policy(path, training.model, problem.simulation(), kind, settings)
    remove_checkpoints(stem)
    return path


def new_model(problem: Problem, kind: str, seed: int, settings: Settings, log: Path | None = None) -> BaseAlgorithm:
    """An agent that has not been trained, in its environment."""
    env = LearnerVecEnv(
        problem, settings.envs, settings.memory, settings.actions, settings.split, settings.worst_reward
    )
    model = build(settings, env, seed, log)
    # after the algorithm has seeded it, the env gets seeds of its own, far from those of evaluation
    env.seed(TRAINING_SEEDS + SEED_STRIDE * seed)
    return model


def _first_model(problem: Problem, kind: str, seed: int, settings: Settings, log: Path) -> BaseAlgorithm:
    """As `new_model`; where no belief can follow the episodes, the error says what can be trained instead."""
    try:
        return new_model(problem, kind, seed, settings, log)
    except BeliefError:
        others = " or ".join(name for name, each in DEFAULTS.items() if each.memory in ("stack", "estimates"))
        raise GrindError(
            f"{kind} remembers a belief, which grinds compiled blocks, and {problem.name} has none: train {others}"
        ) from None


def _finish(
    training: Training,
    problem: Problem,
    title: str,
    settings: Settings,
    checkpoint: Path,
    console: Console,
    advance: Advance,
) -> None:
    """Train up to the last step."""
    model = training.model
    agent, validation = LiveAgent(model, settings.memory, settings.actions), Validation(problem)
    columns = (BarColumn(), MofNCompleteColumn(), TimeRemainingColumn(), TextColumn("{task.fields[news]}"))
    with Progress(TextColumn(title), *columns, console=console) as progress:
        bar = progress.add_task("", total=settings.steps, completed=model.num_timesteps, news="")
        advance(model.num_timesteps)

        def show(steps: int, news: str) -> None:
            done = min(steps, settings.steps)
            advance(done - int(progress.tasks[0].completed))
            progress.update(bar, completed=done, news=news)

        watch = Watch(
            training,
            every=max(settings.steps // POINTS, 1),
            validate=lambda: validation.score(agent),
            keep=lambda: write_checkpoint(checkpoint, training),
            show=show,
        )
        model.learn(
            settings.steps - model.num_timesteps,
            watch,
            # episodes, which end together, or rollouts
            log_interval=settings.envs if isinstance(model, OffPolicyAlgorithm) else 1,
            reset_num_timesteps=model.num_timesteps == 0,
        )


def fingerprint(problem: Problem, kind: str, settings: Settings, seed: int) -> str:
    """Stands for all that decides what a training ends in."""
    parts = [
        sources(training_env.__name__),
        bare(inspect.getsource(algorithms)),
        bare(inspect.getsource(new_model)),
        TRAINING_SEEDS,
        SEED_STRIDE,
        *(
            []
            if settings.algorithm != "cloned_ppo"
            else [sources(imitation.__name__), the_expert(problem.simulation().task)]
        ),
        behaviour(problem.simulation()),
        problem.simulation().task.reference_cost,
        kind,
        settings,
        seed,
        *(installed(library) for library in LIBRARIES),
    ]
    return hashlib.sha256("\0".join(map(str, parts)).encode()).hexdigest()[:12]


def the_expert(task: Task) -> str:
    """Stands for the parameters of the planner that is cloned."""
    return repr(tuned_arguments("full_state_rule", task))

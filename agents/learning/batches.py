"""Do large batches learn as well as small ones? The learning curve of PPO with either, on the same environment."""

import re
from collections.abc import Sequence
from dataclasses import replace
from io import BytesIO
from pathlib import Path

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from agents.cells import RUNS
from agents.learning.curve import Point, curve_path, read_curve
from agents.learning.settings import Number, Settings, settings_of
from agents.learning.train import train
from grind_env.policies.problem import Problem
from grind_env.render.plots import BLUE, ORANGE
from grind_env.targets import Own

NAME = "Batches of PPO"
"""By which the picture is known again."""
PICTURE = Own("picture of `python -m agents train --compare-batches`", re.compile(b"(?s).*" + NAME.encode()).match)
SMALL_ENVS = 8
SMALL: dict[str, Number] = {"n_steps": 2048, "batch_size": 64, "n_epochs": 10, "learning_rate": 3e-4}
"""Rollout, batch, epochs and learning rate that Stable-Baselines3 takes by default."""


def small_batches(settings: Settings) -> Settings:
    """The settings with the batches of Stable-Baselines3."""
    return replace(settings, envs=SMALL_ENVS, hyper={**settings.hyper, **SMALL})


def compare_batches(
    problem: Problem,
    seed: int,
    steps: int | None = None,
    folder: Path = RUNS,
    fresh: bool = False,
    split: str | None = None,
) -> bytes:
    """Train PPO with its own batches and with those of Stable-Baselines3, and draw both curves as PNG.

    Args:
        problem: to train on.
        seed: of both.
        steps: environment steps of each; by default those of the settings.
        folder: of the results; interrupted, the same call goes on.
        fresh: train anew.
        split: contexts of the training episodes; by default those of the settings.
    """
    large = settings_of(problem, "ppo", steps, split)
    curves = [
        read_curve(curve_path(train(problem, "ppo", seed, settings, folder, fresh=fresh)))
        for settings in (large, small_batches(large))
    ]
    names = [f"{each.envs} environments, batch {each.hyper['batch_size']}" for each in (large, small_batches(large))]
    return draw(dict(zip(names, curves, strict=True)), problem.simulation().task.title)


def draw(curves: dict[str, Sequence[Point]], title: str) -> bytes:
    """Validation score over environment steps and over wall time, as PNG."""
    figure = Figure(figsize=(9.0, 3.4), layout="constrained")
    FigureCanvasAgg(figure)
    figure.suptitle(title)
    left, right = figure.subplots(1, 2, sharey=True)
    for (name, points), colour, dashes in zip(curves.items(), (BLUE, ORANGE), ("-", "--"), strict=True):
        scores = [point.score for point in points]
        left.plot([point.steps / 1000.0 for point in points], scores, color=colour, ls=dashes, label=name)
        right.plot([point.seconds for point in points], scores, color=colour, ls=dashes)
    # what lies far below the best fixed plan is not told apart
    left.set(xlabel="thousand environment steps", ylabel="validation score", ylim=(-100.0, 100.0))
    right.set(xlabel="wall time, s")
    left.legend(fontsize=8, loc="lower right")
    for axis in (left, right):
        axis.grid(alpha=0.3)
    image = BytesIO()
    figure.savefig(image, format="png", dpi=90, metadata={"Title": NAME})
    return image.getvalue()

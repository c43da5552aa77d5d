"""Watches a training: where its time goes, what it logs, and when it is scored and kept."""

import time
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from stable_baselines3.common.callbacks import BaseCallback

from agents.learning.checkpoint import Training
from agents.learning.curve import SPENT, Point
from agents.learning.training_env import LearnerVecEnv


class Mark(NamedTuple):
    """A moment: s of the clock, and s spent in the environment and on the features before it."""

    clock: float
    environment: float
    features: float


class Watch(BaseCallback):
    """Callback of one training.

    Args:
        training: what is watched; it is brought up to date before `keep` is called.
        every: steps from one point of the learning curve to the next.
        validate: gives the cost and the score of the agent as it is.
        keep: writes a checkpoint.
        show: is told steps and news.
    """

    def __init__(
        self,
        training: Training,
        *,
        every: int,
        validate: Callable[[], tuple[float, float]],
        keep: Callable[[], object],
        show: Callable[[int, str], object],
    ) -> None:
        super().__init__()
        self.watched, self.every = training, every
        self.validate, self.keep, self.show = validate, keep, show
        self.news = ""

    def _on_training_start(self) -> None:
        assert isinstance(self.training_env, LearnerVecEnv)
        self.env = self.training_env
        self.seconds = self.watched.seconds
        for name in (*SPENT, "all"):
            self.seconds.setdefault(name, 0.0)
        self.began = time.perf_counter() - self.seconds["all"]
        self.rolled: float | None = None
        self._after_point()

    def _after_point(self) -> None:
        self.last = self.num_timesteps
        self.rewards, self.batches = 0.0, 0

    def _mark(self) -> Mark:
        return Mark(time.perf_counter(), self.env.seconds["environment"], self.env.seconds["features"])

    def _on_rollout_start(self) -> None:
        # between two updates: all that the training goes on from is in the model and in the global generators
        self._optimised()
        if self.num_timesteps // self.every > self.last // self.every:
            begin = time.perf_counter()
            self._point()
            self.keep()
            self.seconds["aside"] += time.perf_counter() - begin
        self.begun = self._mark()

    def _on_step(self) -> bool:
        self.rewards += float(np.mean(self.locals["rewards"]))
        self.batches += 1
        return True

    def _on_rollout_end(self) -> None:
        now = self._mark()
        elapsed, environment, features = (float(b - a) for a, b in zip(self.begun, now, strict=True))
        for name, spent in zip(SPENT, (environment, features, elapsed - environment - features), strict=False):
            self.seconds[name] += spent
        self.rolled = now.clock
        if self.env.notes.blocks >= self.env.num_envs * self.env.view.task.blocks:
            self._log()
            self.show(self.num_timesteps, f"reward {self.rewards / self.batches:+.3f} a step{self.news}")

    def _optimised(self) -> None:
        if self.rolled is not None:
            self.seconds["optimisation"] += time.perf_counter() - self.rolled

    def _log(self) -> None:
        for name, value in self.env.take_notes().metrics(self.env.view.task).items():
            self.logger.record(name, value)
        seconds = time.perf_counter() - self.began
        self.logger.record("time/steps_per_second", self.num_timesteps / seconds)
        for name in SPENT:
            self.logger.record(f"time/{name}_share", self.seconds[name] / seconds)

    def _point(self) -> None:
        cost, score = self.validate()
        self.seconds["all"] = time.perf_counter() - self.began
        self.watched.points.append(
            Point(
                steps=self.num_timesteps,
                seconds=self.seconds["all"],
                reward=self.rewards / max(self.batches, 1),
                cost=cost,
                score=score,
                **{name: self.seconds[name] for name in SPENT},
            )
        )
        self.logger.record("validation/cost", cost)
        self.logger.record("validation/score", score)
        self.news = f", validation score {score:.1f}" if np.isfinite(score) else f", validation cost {cost:.2f} $"
        self._after_point()

    def _on_training_end(self) -> None:
        self._optimised()
        if self.num_timesteps > self.last:
            self._point()
            self.show(self.num_timesteps, self.news.lstrip(", "))
            self.logger.dump(self.num_timesteps)

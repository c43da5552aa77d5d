"""Reference scores of the one-step problem of Wen: uniform actions score 0, the optimum 100 (scenarios, 4.3)."""

from collections.abc import Sequence

import numpy as np

from agents.tuning.search import Found, evolve
from grind_env.arrays import Array
from grind_env.envs.wen.actions import decode
from grind_env.envs.wen.judging import OBJECTIVE, VIOLATION, judged
from grind_env.envs.wen.model import CASES, Setting
from grind_env.scores import Mean, Reference

DRAWS = 50_000
EVALUATIONS = 4000
STARTS = 3
NUMBERS = len(Setting._fields)
"""Numbers of an action."""


def losses(actions: Array, case: int) -> Array:
    """Objective and violation, shape (N,), of actions of shape (N, 4) from -1 to 1, for a case given by its number."""
    verdicts = judged(decode(actions), np.full(len(actions), case))
    return np.asarray(verdicts[:, OBJECTIVE] + verdicts[:, VIOLATION])


def optimum(case: int) -> Found:
    """The best action that CMA-ES finds."""

    def loss(points: Sequence[Array]) -> list[float]:
        # outside the bounds the loss grows with the distance
        inside = np.clip(points, -1.0, 1.0)
        return [float(each) for each in losses(inside, case) + np.abs(points - inside).sum(axis=1)]

    runs = [
        evolve(loss, np.random.default_rng(seed).uniform(-1.0, 1.0, NUMBERS), EVALUATIONS, seed, 0.5)
        for seed in range(STARTS)
    ]
    best = min(runs, key=lambda run: run.cost)
    return best._replace(point=np.clip(best.point, -1.0, 1.0))


def wen_reference() -> Reference:
    """Means over the cases, which are equally likely."""
    actions = np.random.default_rng(0).uniform(-1.0, 1.0, (DRAWS, NUMBERS))
    drawn = np.array([losses(actions, case) for case in range(len(CASES))])
    random = -float(drawn.mean())
    best = -float(np.mean([optimum(case).cost for case in range(len(CASES))]))
    centre = -float(np.mean([losses(np.zeros((1, NUMBERS)), case)[0] for case in range(len(CASES))]))
    error = float(drawn.mean(axis=0).std(ddof=1)) / DRAWS**0.5
    returns = {"random": Mean(random, error), "centre": Mean(centre, 0.0), "optimum": Mean(best, 0.0)}
    returns = {name: Mean(round(mean.value, 5), round(mean.error, 5)) for name, mean in returns.items()}
    return Reference(
        zero=returns["random"].value,
        hundred=returns["optimum"].value,
        ratio=False,
        fixed_plan="random",
        best_scripted="centre",
        J_fix=-returns["random"].value,
        J_plan=-returns["optimum"].value,
        returns=returns,
    )

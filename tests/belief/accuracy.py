"""How well the wear-flat area can be told from measurements: `python -m tests.belief.accuracy [TASK ...]`.

Prints R2 of predictions of the true A before every block but the first, on episodes that nothing was fitted to:
the sharpness formula of scenarios.md section 3 as it stands and with a fitted line, a linear regression on four
stacked observations and actions, and the belief of several sizes; the same for the log factor on wear-flat growth.
The plans are those of a cautious experimenter: E at random within a factor of 2.7, a dress in a third of the blocks.
"""

import sys
import time
from typing import NamedTuple

import numpy as np
from gymnasium import spaces

from grind_env.belief.wheel import WheelBelief
from grind_env.envs.actions import ActionCodec
from grind_env.envs.blocks.simulation import BlockSimulation
from grind_env.envs.memory import StackMemory
from grind_env.envs.model import MemberModel
from grind_env.envs.names import task_names
from grind_env.envs.observations import bounds, physical
from grind_env.envs.tasks import Task, load_task
from grind_env.policies.choices import nearest_speed
from grind_env.policies.scripted.estimator import SharpnessEstimator
from tests.envs.harness import Array, start

EPISODES = 256
STACKED = 4
SIZES = (8, 16, 32, 64)


class Experiment(NamedTuple):
    """Episodes of a task; arrays of shape (blocks, N) or (blocks, N, entries)."""

    measured: Array
    actions: Array
    """Those that led to the observation of the same block."""
    area: Array
    growth: Array


def experiment(task: Task, seed: int) -> Experiment:
    """Run episodes under random plans."""
    measuring, full, codec = BlockSimulation(task), BlockSimulation(task, full=True), ActionCodec(task)
    rng = np.random.default_rng(seed)
    episodes = start(measuring, EPISODES, seed)
    measured, actions, area, growth = [], [np.zeros((EPISODES, 2), np.float32)], [], []
    for _ in range(task.blocks):
        truth = physical(full.observe(episodes), full.entries)
        measured.append(measuring.observe(episodes))
        area.append(truth["wear_flat"])
        growth.append(np.log(truth["growth"]))
        speeds = nearest_speed(task, np.exp(rng.uniform(np.log(6000.0), np.log(16000.0), EPISODES)))
        executions = (rng.random(EPISODES) < 1.0 / 3.0).astype(float)
        actions.append(codec.encode(speeds, executions))
        measuring.step(episodes, speeds, executions)
    return Experiment(np.array(measured), np.array(actions[:-1]), np.array(area), np.array(growth))


def stacked(data: Experiment, task: Task) -> Array:
    """What HistoryStack shows, with a constant, shape (blocks, N, entries)."""
    space = spaces.Box(*bounds(BlockSimulation(task).entries), dtype=np.float32)
    memory = StackMemory(space, spaces.Box(-1.0, 1.0, (2,), np.float32), STACKED)
    memory.begin(EPISODES)
    everyone = np.ones(EPISODES, bool)
    shown = [memory.take(o, a, everyone) for o, a in zip(data.measured, data.actions, strict=True)]
    return np.concatenate([shown, np.ones((task.blocks, EPISODES, 1))], axis=2)


def formula(data: Experiment, task: Task) -> Array:
    """Apparent wear-flat area from mean power and nominal constants."""
    estimator = SharpnessEstimator(BlockSimulation(task), EPISODES)
    return np.array([estimator.update(observation).wear_flat for observation in data.measured])


def fitted(features: Array, target: Array, test: Array) -> Array:
    """Predictions of the least-squares line through the training data, the first block left out."""
    X, y = features[1:].reshape(-1, features.shape[2]), target[1:].ravel()
    ridge = 1e-6 * len(X) * np.eye(X.shape[1])
    return np.asarray(test @ np.linalg.solve(X.T @ X + ridge, X.T @ y))


def r2(truth: Array, prediction: Array) -> float:
    """Share of the variance explained, the first block left out."""
    return float(1.0 - np.mean((truth - prediction)[1:] ** 2) / np.var(truth[1:]))


def measure(name: str) -> None:
    """Print the figures of a task."""
    task = load_task(name)
    train, test = experiment(task, 700_000), experiment(task, 800_000)
    formulas = [np.stack([formula(data, task), np.ones_like(data.area)], axis=2) for data in (train, test)]
    stacks = stacked(train, task), stacked(test, task)
    print(f"{name}: A is {test.area[1:].mean():.4f} +- {test.area[1:].std():.4f}, {EPISODES} episodes")
    print(f"  {'formula':34s} A {r2(test.area, formulas[1][..., 0]):6.3f}")
    print(f"  {'formula, fitted line':34s} A {r2(test.area, fitted(formulas[0], train.area, formulas[1])):6.3f}")
    row = f"{r2(test.area, fitted(stacks[0], train.area, stacks[1])):6.3f}"
    growth = f"{r2(test.growth, fitted(stacks[0], train.growth, stacks[1])):6.3f}"
    print(f"  {f'linear on {STACKED} observations':34s} A {row}  growth {growth}")
    # the first call compiles
    model = MemberModel(BlockSimulation(task))
    warm = WheelBelief(model)
    warm.begin(EPISODES)
    warm.update(test.measured[0])
    for members in SIZES:
        belief = WheelBelief(model, members)
        belief.begin(EPISODES)
        began = time.process_time()
        beliefs = [belief.update(observation) for observation in test.measured]
        micros = 1e6 * (time.process_time() - began) / (task.blocks * EPISODES)
        area, spread, log_growth = (np.array([getattr(b, key) for b in beliefs]) for key in KEYS)
        within = float(np.mean(np.abs(area - test.area)[1:] < 2.0 * spread[1:]))
        row = f"{r2(test.area, area):6.3f}  growth {r2(test.growth, log_growth):6.3f}"
        print(
            f"  {f'belief, {members} members':34s} A {row}  within 2 spreads {within:.3f}  {micros:.1f} us CPU a step"
        )


KEYS = ("wear_flat", "wear_flat_spread", "growth")


if __name__ == "__main__":
    for each in sys.argv[1:] or task_names():
        if load_task(each).spread.measurement > 0.0:
            measure(each)

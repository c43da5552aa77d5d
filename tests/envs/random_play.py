"""A million random steps of every environment: `python -m tests.envs.random_play [--steps 1000000] [ID ...]`.

No observation may be NaN or outside its space, and every reward must lie in the range that the page of the id states.
"""

import argparse
import sys
import time

import gymnasium as gym
import numpy as np
from rich.console import Console
from rich.progress import Progress
from rich.table import Table

import grind_env
from grind_env.pages import summary

N = 4096
"""Sub-environments side by side."""


def play(env_id: str, steps: int, progress: Progress) -> tuple[int, float, float]:
    """Steps taken, lowest and highest reward.

    Raises:
        AssertionError: an observation or a reward is not what was promised.
    """
    env = gym.make_vec(env_id, N, autoreset_mode="SameStep")
    rng = np.random.default_rng(0)
    observations, _ = env.reset(seed=0)
    space = env.single_observation_space
    low, high, taken = np.inf, -np.inf, 0
    task = progress.add_task(env_id, total=steps)
    while taken < steps:
        actions = rng.uniform(-1.0, 1.0, env.action_space.shape).astype(np.float32)
        extreme = rng.random(N) < 0.2
        actions[extreme] = np.sign(actions[extreme])
        observations, rewards, *_ = env.step(actions)
        assert np.isfinite(observations).all() and np.isfinite(rewards).all(), f"{env_id}: not finite"
        assert ((observations >= space.low) & (observations <= space.high)).all(), f"{env_id}: outside the space"
        low, high, taken = min(low, rewards.min()), max(high, rewards.max()), taken + N
        progress.update(task, completed=taken)
    env.close()
    least, most = summary(env_id).reward
    stated = f"{env_id}: {low} to {high} is not within {least} to {most}"
    assert (least is None or least <= low) and high <= most, stated
    return taken, float(low), float(high)


def main() -> None:
    """Play, and print a row for every id."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("ids", nargs="*", default=[name for name in gym.registry if name.startswith("grind/")])
    parser.add_argument("--steps", type=int, default=1_000_000)
    arguments = parser.parse_args()
    table = Table("id", "steps", "lowest reward", "highest", "stated", "s", title=f"grind_env {grind_env.__version__}")
    failed = False
    with Progress() as progress:
        for env_id in arguments.ids:
            begin = time.perf_counter()
            try:
                taken, low, high = play(env_id, arguments.steps, progress)
            except AssertionError as error:
                failed = True
                table.add_row(env_id, "", str(error), "", "", "")
                continue
            seconds = f"{time.perf_counter() - begin:.0f}"
            table.add_row(env_id, f"{taken:,}", f"{low:.3f}", f"{high:.3f}", str(summary(env_id).reward), seconds)
    Console(width=140).print(table)
    sys.exit(int(failed))


if __name__ == "__main__":
    main()

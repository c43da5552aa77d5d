"""One process that goes on for half an hour: it does not grow, does not slow down, and has no number that is none.

`python -m tests.soak.lasting stepping` steps every environment in turn; `learning` trains an agent and judges it again
and again, which has to come to the same. Rows of what it measures are added to build/soak/lasting-<commit>.csv.
"""

import argparse
import csv
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path

import gymnasium as gym
import numpy as np
from rich.console import Console

from grind_env.policies.judging import evaluate
from grind_env.policies.problem import find_problem
from grind_env.training.gru_ppo import Settings, policy_of, shown, train
from tests.envs.harness import every_id
from tests.soak.counts import commit
from tests.soak.part import memory

SIZE = 1024
"""Environments side by side."""
TURN = 50
"""Steps of an environment until it is the next one's turn."""
STEPS = 100_000
"""Of a training."""
EPISODES = 64
GROWTH = 24.0
"""MB of resident memory from the first third to the last one; what is new in the first rounds is not counted."""
SLOWED = 0.8
"""Share of the speed of the first third below which the last one is slower; of the fastest rounds, for other processes
disturb some."""


@dataclass(frozen=True, slots=True)
class Round:
    """What was done once.

    Attributes:
        steps: of environments.
        seconds: of the processor.
        megabytes: resident afterwards.
        result: of the learning, which is always the same; 0 of stepping.
    """

    steps: int
    seconds: float
    megabytes: float
    result: float = 0.0


def stepping() -> Callable[[], tuple[int, float]]:
    """Turns of all environments, with random actions and the resets that they bring."""
    envs = [gym.make_vec(env_id, SIZE, autoreset_mode="SameStep") for env_id in every_id()]
    for seed, env in enumerate(envs):
        env.reset(seed=seed)
        env.action_space.seed(seed)

    def turn() -> tuple[int, float]:
        for env in envs:
            for _ in range(TURN):
                observations, rewards, *_ = env.step(env.action_space.sample())
                if not (np.isfinite(observations).all() and np.isfinite(rewards).all()):
                    raise SystemExit(f"{env.spec}: a number that is not finite")
        return len(envs) * TURN * SIZE, 0.0

    return turn


def learning() -> Callable[[], tuple[int, float]]:
    """The same training and evaluation, over and over."""
    problem, settings = find_problem("power_limited"), Settings(steps=STEPS)

    def turn() -> tuple[int, float]:
        agent, scale = train(shown(problem, settings.memory), settings, 0)
        policy = policy_of(agent, scale, problem, settings.memory)
        return STEPS, float(evaluate(policy, problem, seeds="validation", episodes=EPISODES).evaluation.cost.mean())

    return turn


KINDS = {"stepping": stepping, "learning": learning}


def faults(rounds: Sequence[Round]) -> list[str]:
    """What has not lasted."""
    third = max(len(rounds) // 3, 1)
    parts = rounds[1 : 1 + third], rounds[-third:]
    before, after = (float(np.mean([each.megabytes for each in part])) for part in parts)
    first, last = (max(each.steps / each.seconds for each in part) for part in parts)
    results = {each.result for each in rounds}
    found = []
    if after - before > GROWTH:
        found.append(f"memory has grown by {after - before:.0f} MB")
    if last < SLOWED * first:
        found.append(f"{first:,.0f} steps/s have become {last:,.0f}")
    if len(results) > 1 or not np.isfinite(list(results)).all():
        found.append(f"the same work has come to {sorted(results)}")
    return found


def main(words: list[str] | None = None) -> int:
    """Go on for the time that is asked; status 1 tells that something has not lasted."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("kind", choices=list(KINDS))
    parser.add_argument("--minutes", type=float, default=30.0)
    parser.add_argument("--out", type=Path, default=Path("build/soak"), help="folder of the rows")
    options = parser.parse_args(words)
    console, turn = Console(markup=False, highlight=False), KINDS[options.kind]()
    options.out.mkdir(parents=True, exist_ok=True)
    rounds: list[Round] = []
    with (options.out / f"lasting-{commit()}.csv").open("a", newline="", encoding="utf-8") as file:
        writer, until = csv.writer(file), time.monotonic() + 60.0 * options.minutes
        if file.tell() == 0:
            writer.writerow(["kind", *(each.name for each in fields(Round))])
        while time.monotonic() < until or len(rounds) < 4:
            began = time.process_time()
            steps, result = turn()
            rounds.append(Round(steps, time.process_time() - began, memory(), result))
            writer.writerow([options.kind, *asdict(rounds[-1]).values()])
            file.flush()
    first, last, found = rounds[1], rounds[-1], faults(rounds)
    for each in (first, last):
        console.print(f"{each.steps / each.seconds:,.0f} steps/s, {each.megabytes:.0f} MB, result {each.result:g}")
    console.print(
        f"{options.kind}, {len(rounds)} rounds, {sum(each.steps for each in rounds):,} steps: {found or 'it lasts'}"
    )
    return int(bool(found))


if __name__ == "__main__":
    sys.exit(main())

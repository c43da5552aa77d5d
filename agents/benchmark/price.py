"""Facts about a policy: what made it, which model of the simulator it uses, and the cost of a decision."""

import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple
from unittest.mock import patch

import numpy as np

from agents.benchmark.plan import ON_BELIEF, PLAIN, BenchmarkCell
from grind_env.envs.actions import ActionCodec
from grind_env.envs.episodes import Episodes
from grind_env.envs.simulation import Simulation
from grind_env.policies.evaluation import done, episode_seeds, start_episodes
from grind_env.policies.policy import Policy, reveal
from grind_env.policies.registry import REFERENCE
from grind_env.policies.tuned import read_tuned, tuned_folder

EPISODES = 16
"""Validation episodes on which a decision is timed."""
NOMINAL = ("adaptive_rule", "belief_rule", "look_ahead", ON_BELIEF)
"""They hold the equations with nominal constants, by which they read or follow the wheel."""
EXACT = ("mpc", REFERENCE)
"""They hold the simulator, with the true lot and wheel of the episode."""
WITHOUT = ("none", "stack", "gru", "state")
"""Memories and views without an equation; a belief holds the nominal ones."""
RULE = {"mpc": "full_state_rule"}
"""What is tuned of a policy, if it is another one."""


class Price(NamedTuple):
    """Blocks that are simulated before the first decision and for each, and CPU ms of a decision."""

    begun: int
    calls: float
    ms: float


def model_of(cell: BenchmarkCell) -> str:
    """Return a policy's knowledge of the simulator's equations: `none`, `nominal` or `exact`."""
    if cell.trains:
        return "none" if PLAIN.get(cell.policy) in WITHOUT else "nominal"
    return "nominal" if cell.base in NOMINAL else "exact" if cell.base in EXACT else "none"


def tuned_on(policy: str, simulation: Simulation, configs: Path | None = None) -> int:
    """Blocks that were ground to tune a policy, without those of validation; 0 if nothing of it is tuned."""
    tuned = read_tuned(simulation.task.name, tuned_folder(simulation.task, configs)).get(RULE.get(policy, policy))
    return 0 if tuned is None else tuned.evaluations * tuned.training_seeds[1] * simulation.task.blocks


def price_of(policy: Policy, simulation: Simulation) -> Price:
    """Measure the CPU time that a policy takes for its decisions."""
    episodes = start_episodes(simulation, episode_seeds("validation", EPISODES))
    codec, decisions, seconds = ActionCodec(simulation.task), 0, 0.0
    with counted(type(simulation)) as count:
        policy.begin(simulation, EPISODES)
        begun, count[0] = count[0], 0
        while not (over := simulation.over(episodes)).all():
            shown = simulation.observe(episodes), reveal(policy.sees, simulation, episodes)
            begin = time.process_time()
            decision = policy.act(*shown)
            seconds += time.process_time() - begin
            going = np.flatnonzero(~over)
            decisions += len(going)
            simulation.step(episodes, *done(decision, simulation, codec, episodes), active=going)
    # the episodes themselves are ground, too
    return Price(begun, count[0] / decisions - 1.0, 1e3 * seconds / decisions)


@contextmanager
def counted(kind: type[Any]) -> Iterator[list[int]]:
    """Counts the blocks that simulations of a kind grind, of however many episodes at once."""
    step, count = kind.step, [0]

    def counting(self: Any, episodes: Episodes, *choice: Any, active: Any = None, **others: Any) -> Any:
        count[0] += len(episodes.block) if active is None else len(active)
        return step(self, episodes, *choice, active=active, **others)

    with patch.object(kind, "step", counting):
        yield count

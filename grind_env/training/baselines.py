"""Untrained policies with which `grind train` compares its agent."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import product

import numpy as np
from numpy.typing import NDArray

from grind_env.array_types import Array
from grind_env.envs.episode_state import Episodes
from grind_env.envs.job.job_simulation import JobSimulation
from grind_env.envs.job.program_outline import BlockOutline
from grind_env.envs.simulation import Simulation
from grind_env.policies.choices import Decision, speed_grid
from grind_env.policies.evaluation import run_seeds
from grind_env.policies.policy import Policy, Sees
from grind_env.policies.problem_lookup import Problem
from grind_env.policies.registry import make_policy
from grind_env.policies.scripted.rules import Fixed
from grind_env.shop.advise.adviser import policy_for
from grind_env.shop.dress_interval import DressInterval

RULE = "empirical_rule"  #: policy that stands for the adviser in tasks, which have no part program
RATIOS = (0.6, 0.8, 1.0, 1.25, 1.6)  #: ratios of E in a fixed plan to E in the program, for all blocks
EVERY = (1, 2, 4)  #: dress intervals of the fixed plans, in parts of a program or blocks of a task
TRIALS = 32  #: number of machines on which the fixed plan is chosen


@dataclass
class Programmed:
    """A plan that a shop can write into its part program; by default the program as it is."""

    ratio: float = 1.0  #: ratio of E to the E of the program
    #: interval of dressed parts, dressed in the first block that takes a dress; None for the dresses of the program
    every: int | None = None
    sees: Sees = "measurements"
    speeds: Array = field(init=False, repr=False)
    executions: Array = field(init=False, repr=False)
    block: int = field(init=False, repr=False)

    @property
    def name(self) -> str:
        if self.every is None:
            return "the program as it is"
        return f"fixed plan: {self.ratio:g} times E, a dress {DressInterval(self.every)}"

    def begin(self, simulation: Simulation, episodes: int) -> None:
        assert isinstance(simulation, JobSimulation)
        blocks = simulation.blocks
        own = np.array([float(block.plan.dresses) for block in blocks])
        feeds = self.ratio * np.array([block.plan.feed for block in blocks])
        self.speeds = np.clip(feeds, *simulation.task.action.speed_ends)
        self.executions = own if self.every is None else np.where(_due(blocks, self.every), np.maximum(own, 1.0), 0.0)
        self.block = -1

    def act(self, observation: NDArray[np.float32], episodes: Episodes | None) -> Decision:
        self.block += 1
        n = len(observation)
        return Decision(np.full(n, self.speeds[self.block]), np.full(n, self.executions[self.block]))


def _due(blocks: tuple[BlockOutline, ...], every: int) -> list[bool]:
    """Return whether each block is dressed: the first block that takes a dress in one of `every` parts."""
    first = {block.part: k for k, block in reversed([*enumerate(blocks)]) if block.takes_dresses}
    return [block.part % every == 0 and first.get(block.part) == k for k, block in enumerate(blocks)]


def fixed_plans(simulation: Simulation) -> list[Policy]:
    """Return 15 fixed plans; none for a program that only the control can execute, because that is slow."""
    if isinstance(simulation, JobSimulation):
        return [Programmed(*plan) for plan in product(RATIOS, EVERY)] if simulation.compiled else []
    speeds = speed_grid(simulation.task, len(RATIOS)).tolist()
    return [
        Fixed(E=speed, D=1, every=every, name=f"fixed plan: E{speed:.0f}, D1 {DressInterval(every, 'block')}")
        for speed, every in product(speeds, EVERY)
    ]


def rivals(problem: Problem, judges: Problem) -> Iterator[Policy]:
    """Yield the adviser, the best fixed plan and, for a part program, the unchanged program.

    The fixed plan is chosen on other machines of the evaluation set.
    """
    simulation, ground = problem.simulation(), judges.simulation()
    yield policy_for(None, simulation) if isinstance(simulation, JobSimulation) else make_policy(RULE, simulation)

    def cost(plan: Policy) -> float:
        return run_seeds(plan, ground, range(TRIALS)).cost_per_good_part.value

    if len(plans := fixed_plans(simulation)) > 1:
        yield min(plans, key=cost)
    if isinstance(simulation, JobSimulation):
        yield Programmed()

"""Runs a policy through the episodes of a list of seeds, side by side."""

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

from grind_env.envs.actions import ActionCodec
from grind_env.envs.blocks.tables import Outcome
from grind_env.envs.contexts import SPLITS as CONTEXT_SPLITS
from grind_env.envs.contexts import Given
from grind_env.envs.simulation import Episodes, Simulation
from grind_env.errors import GrindError, quoted
from grind_env.policies.choices import Array
from grind_env.policies.policy import Policy, reveal
from grind_env.policies.statistics import Interval, bootstrap, cost_per_good_part, normalised_score
from grind_env.presenter import html

SPLITS = {"training": 0, "validation": 500_000, "evaluation": 2_000_000, "test": 3_000_000}
"""First seed of each split. A seed makes one episode, `env.reset(seed=...)` the same one; in `test` it is drawn from
the test contexts, as by `env.reset(seed=..., options={"split": "test"})`."""

CONTEXTS = {"test": Given(ranges=CONTEXT_SPLITS["test"])}
"""What is given of the episodes of a split."""

SPLIT_SIZE = 500_000

COST, GOOD, FINISHED = (Outcome._fields.index(name) for name in ("cost", "good", "finished"))


def episode_seeds(split: str, count: int) -> range:
    """The first `count` seeds of one of `SPLITS`; no seed is in two of them.

    Raises:
        GrindError: if there is no such split, or if it has fewer seeds.

    Example:
        >>> from grind_env.policies.evaluation import episode_seeds
        >>> episode_seeds("evaluation", 64)
        range(2000000, 2000064)
    """
    if split not in tuple(SPLITS):
        raise GrindError(f"there is no split {quoted(split)}: the splits are {', '.join(SPLITS)}")
    if not 1 <= count <= SPLIT_SIZE:
        raise GrindError(f"{count} episodes are asked for, but the {split} split has 1 to {SPLIT_SIZE}")
    return range(SPLITS[split], SPLITS[split] + count)


@dataclass(frozen=True, slots=True)
class Evaluation:
    """What a policy did and what it cost, episode by episode."""

    cost: Array
    """$, shape (N,)."""
    good: Array
    """Expected number of good parts, shape (N,)."""
    finished: Array
    """Number of parts finished, shape (N,)."""
    speeds: Array
    """E, mm/min, shape (N, steps); NaN after the end of a shorter episode."""
    executions: Array
    """D, the number of dress executions, likewise."""

    @property
    def cost_per_good_part(self) -> Interval:
        """$ per good part."""
        return bootstrap(cost_per_good_part, self.cost, self.good)

    @property
    def speed(self) -> float:
        """Mean E, m/min."""
        return float(np.nanmean(self.speeds)) / 1000.0

    @property
    def dresses(self) -> float:
        """Mean D."""
        return float(np.nanmean(self.executions))

    @property
    def scrap(self) -> float:
        """Share of the parts that are scrap."""
        return float(1.0 - self.good.sum() / self.finished.sum())

    @staticmethod
    def joined(parts: Sequence["Evaluation"]) -> "Evaluation":
        """Evaluations of different episodes as one."""
        steps = max(part.speeds.shape[1] for part in parts)

        def column(name: str) -> Array:
            values = [getattr(part, name) for part in parts]
            if values[0].ndim > 1:
                values = [np.pad(each, ((0, 0), (0, steps - each.shape[1])), constant_values=np.nan) for each in values]
            return np.concatenate(values)

        return Evaluation(*(column(each.name) for each in fields(Evaluation)))

    def first(self, count: int) -> "Evaluation":
        """The same of the first `count` episodes."""
        return Evaluation(*(getattr(self, each.name)[:count] for each in fields(self)))

    def score(self, fixed: "Evaluation", planner: "Evaluation") -> Interval:
        """Normalised score of the same episodes; see `statistics.normalised_score`."""
        return bootstrap(normalised_score, self.cost, fixed.cost, planner.cost)

    def _repr_html_(self) -> str:
        return html("evaluations", self)


def start_episodes(simulation: Simulation, seeds: Sequence[int]) -> Episodes:
    """The episodes of the seeds, at their first block."""
    given = [CONTEXTS.get(split_of(seed), Given()) for seed in seeds]
    return simulation.start([np.random.default_rng(seed) for seed in seeds], given)


def split_of(seed: int) -> str:
    """The split that a seed belongs to, or the last one before it."""
    return max((first, split) for split, first in SPLITS.items() if first <= max(seed, 0))[1]


def evaluate(policy: Policy, simulation: Simulation, seeds: Sequence[int]) -> Evaluation:
    """Run the policy once through the episode of each seed."""
    return roll_out(policy, simulation, start_episodes(simulation, seeds))


def roll_out(policy: Policy, simulation: Simulation, episodes: Episodes) -> Evaluation:
    """Run the policy from the first step of the episodes to the last; the episodes are left as they are.

    Every decision goes through the action space, and the policy sees no more than it declares.

    Raises:
        ActionError: if the policy decides an E or a D that the environment does not have.
    """
    n = len(episodes.block)
    episodes = episodes.pick(np.arange(n))
    codec = ActionCodec(simulation.task)
    totals = np.zeros((n, 3))
    plan: list[tuple[Array, ...]] = []
    policy.begin(simulation, n)
    while (running := np.flatnonzero(~simulation.over(episodes))).size > 0:
        decision = policy.act(simulation.observe(episodes), reveal(policy.sees, simulation, episodes))
        choice = simulation.taken(episodes, codec.decode(codec.encode(*decision)))
        outcomes, _ = simulation.step(episodes, *choice, active=running)
        totals += outcomes[:, [COST, GOOD, FINISHED]]
        over = np.ones(n, bool)
        over[running] = False
        plan.append(tuple(np.where(over, np.nan, values) for values in choice))
    speeds, executions = np.array(plan).transpose(1, 2, 0)
    cost, good, finished = totals.T
    return Evaluation(cost, good, finished, speeds, executions)

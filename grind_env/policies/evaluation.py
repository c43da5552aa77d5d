"""Runs of a policy on the episodes of a list of seeds, side by side."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, fields
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grind_env.array_types import Array
from grind_env.envs.actions import ActionCodec
from grind_env.envs.cost import Outcome
from grind_env.envs.distribution_splits import EVERY, SPLITS
from grind_env.envs.episode_state import Episodes
from grind_env.envs.reset_options import Given, find_split
from grind_env.envs.simulation import Simulation
from grind_env.errors import GrindError
from grind_env.message_text import quoted
from grind_env.notebook_loader import html
from grind_env.policies.choices import Decision
from grind_env.policies.nominal_model import parted
from grind_env.policies.policy import Policy
from grind_env.policies.privileged_information import reveal
from grind_env.policies.score_statistics import Interval, bootstrap, cost_per_good_part, normalised_score

#: first seed of each range, frozen. A seed gives one episode, the same as `env.reset(seed=...)`. The split, not the
#: seed, limits the contexts (`grind_env.envs.reset_options`)
SEEDS = {"training": 0, "validation": 500_000, "evaluation": 2_000_000}

SEEDS_EACH = 500_000  #: number of seeds in each range

COST, GOOD, FINISHED = (Outcome._fields.index(name) for name in ("cost", "good", "finished"))


def episode_seeds(seeds: str, count: int) -> range:
    """Return the first `count` seeds of a range of `SEEDS`; the ranges do not overlap.

    Raises:
        GrindError: no range has this name, or the range has fewer seeds.

    Example:
        >>> from grind_env.policies.evaluation import episode_seeds
        >>> episode_seeds("evaluation", 64)
        range(2000000, 2000064)
    """
    if seeds not in tuple(SEEDS):
        raise GrindError(
            f"there are no seeds {quoted(seeds)}: the seeds are {', '.join(SEEDS)}; contexts are named by the split,"
            f" {', '.join(SPLITS)}"
        )
    if not 1 <= count <= SEEDS_EACH:
        raise GrindError(f"{count} episodes are asked for, but there are 1 to {SEEDS_EACH} {seeds} seeds")
    return range(SEEDS[seeds], SEEDS[seeds] + count)


@dataclass(frozen=True, slots=True)
class Evaluation:
    """Decisions and costs of a policy, episode by episode."""

    cost: Array  #: cost of each episode, $, shape (N,)
    good: Array  #: expected number of good parts, shape (N,)
    finished: Array  #: number of parts finished, shape (N,)
    speeds: Array  #: E, mm/min, shape (N, steps); NaN after the end of a shorter episode
    executions: Array  #: D, the number of dress executions, shape (N, steps); NaN after the end of a shorter episode

    @property
    def cost_per_good_part(self) -> Interval:
        """Cost per good part, $, with its 95 % interval."""
        return bootstrap(cost_per_good_part, self.cost, self.good)

    @property
    def speed(self) -> float:
        """Mean E, mm/min."""
        return float(np.nanmean(self.speeds))

    @property
    def dresses(self) -> float:
        """Mean D, dress executions per step."""
        return float(np.nanmean(self.executions))

    @property
    def scrap(self) -> float:
        """Share of the parts that are scrap."""
        return float(1.0 - self.good.sum() / self.finished.sum())

    @staticmethod
    def joined(parts: Sequence["Evaluation"]) -> "Evaluation":
        """Join evaluations of different episodes."""
        return Evaluation(
            *(np.concatenate([getattr(part, each.name) for part in parts]) for each in fields(Evaluation))
        )

    def first(self, count: int) -> "Evaluation":
        """Return the evaluation of the first `count` episodes."""
        return Evaluation(*(getattr(self, each.name)[:count] for each in fields(self)))

    def score(self, fixed: "Evaluation", planner: "Evaluation") -> Interval:
        """Return the score against two policies on the same episodes; see `statistics.normalised_score`."""
        return bootstrap(normalised_score, self.cost, fixed.cost, planner.cost)

    def _repr_html_(self) -> str:
        return html("evaluations", self)


def start_episodes(simulation: Simulation, seeds: Sequence[int], split: str = EVERY) -> Episodes:
    """Return the episodes of the seeds with contexts of a split, at their first block.

    Raises:
        ContextError: if there is no such split.
    """
    given = [Given(split=find_split(split))] * len(seeds)
    return simulation.start([np.random.default_rng(seed) for seed in seeds], given)


def run_seeds(
    policy: Policy,
    simulation: Simulation,
    seeds: Sequence[int],
    split: str = EVERY,
    model: Simulation | None = None,
) -> Evaluation:
    """Run the policy once through the episode of each seed, with contexts of a split; `model` as for `roll_out`.

    Raises:
        ContextError: if there is no such split.
    """
    return roll_out(policy, simulation, start_episodes(simulation, seeds, split), model)


def done(decision: Decision, simulation: Simulation, codec: ActionCodec, episodes: Episodes) -> tuple[Array, ...]:
    """Return a decision as the action space rounds it and the coming blocks execute it; each of shape (N,).

    Raises:
        ActionError: the decision has an E or a D that the environment does not have.
    """
    return simulation.applied_choice(episodes, codec.decode(codec.encode(*decision)))


class Step(NamedTuple):
    """Step of N episodes: observation before the step, choice and outcomes."""

    observation: NDArray[np.float32]  #: scaled observation, no unit, shape (N, entries)
    #: E in mm/min and D, a number of executions, and a pre-dress (1) where there is one, each shape (N,)
    choice: tuple[Array, ...]
    #: outcomes in the units of `Outcome`, shape (N, fields of `Outcome`); 0 for an episode that was over
    outcomes: Array
    over: NDArray[np.bool_]  #: whether an episode was over before the step, shape (N,)


def steps(
    policy: Policy, simulation: Simulation, episodes: Episodes, model: Simulation | None = None
) -> Iterator[Step]:
    """Yield the steps of the episodes from first to last, arguments as for `roll_out`; the episodes change in place.

    Raises:
        ActionError: if the policy decides an E or a D that the environment does not have.
    """
    codec = ActionCodec(simulation.task)
    held, shown = model or simulation, parted(policy, simulation, model, episodes)
    policy.begin(held, len(episodes.block))
    while not (over := simulation.over(episodes)).all():
        observation = simulation.observe(episodes)
        # a copy, because the policy may change its observation
        decision = policy.act(observation.copy(), reveal(policy.sees, held, shown(episodes)))
        choice = done(decision, simulation, codec, episodes)
        outcomes, _ = simulation.step(episodes, *choice, active=np.flatnonzero(~over))
        yield Step(observation, choice, outcomes, over)


def nobody(steps: int) -> None:
    """Ignore progress messages."""


def roll_out(
    policy: Policy,
    simulation: Simulation,
    episodes: Episodes,
    model: Simulation | None = None,
    advance: Callable[[int], object] = nobody,
) -> Evaluation:
    """Run the policy on the episodes from first to last step; the given episodes stay unchanged.

    Every decision goes through the action space, and the policy sees only what it declares.

    Args:
        policy: the policy.
        simulation: the simulation that grinds.
        episodes: episodes at their first block.
        model: simulation that the policy computes with, if it is not `simulation`; see `model_view`.
        advance: called with the number of steps since its last call.

    Raises:
        ActionError: if the policy decides an E or a D that the environment does not have.
    """
    n = len(episodes.block)
    totals, plan = np.zeros((n, 3)), list[tuple[Array, ...]]()
    for step in steps(policy, simulation, episodes.pick(np.arange(n)), model):
        totals += step.outcomes[:, [COST, GOOD, FINISHED]]
        plan.append(tuple(np.where(step.over, np.nan, values) for values in step.choice))
        advance(1)
    speeds, executions = np.array(plan).transpose(1, 2, 0)
    cost, good, finished = totals.T
    return Evaluation(cost, good, finished, speeds, executions)

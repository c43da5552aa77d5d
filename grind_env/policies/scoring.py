"""Evaluation of a policy: cost per good part and score on fixed seeds, with intervals."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import count, repeat
from typing import Any, get_args

import numpy as np

from grind_env.array_types import Array
from grind_env.data_table import Table, table_of
from grind_env.envs.distribution_splits import EVERY, SPLITS
from grind_env.errors import GrindError
from grind_env.message_text import quoted
from grind_env.notebook_loader import html
from grind_env.plants.plant_names import MODEL
from grind_env.policies.evaluation import SEEDS, Evaluation, episode_seeds, nobody, roll_out, start_episodes
from grind_env.policies.nominal_model import model_of, on
from grind_env.policies.policy import Policy, Sees
from grind_env.policies.policy_lookup import agent_of, named_policy
from grind_env.policies.problem_lookup import Problem, find_problem
from grind_env.policies.registry import make_policy
from grind_env.policies.score_statistics import (
    Interval,
    normalised_score,
    percentile_interval,
    resampled_means,
    score_of_means,
)
from grind_env.policies.tuned_parameters import ConfigError
from grind_env.score_scale import Reference, find_reference

REFERENCE_SEEDS = "evaluation"  #: seeds of the reference scores, which use the first episodes in the split `all`


@dataclass(frozen=True, slots=True)
class Judgement:
    """Result of a policy in an environment."""

    policy: str  #: name of the policy
    sees: Sees  #: information that the policy sees
    problem: str  #: name of the environment
    seeds: str  #: name of the seeds, or first and last seed
    split: str  #: split of the contexts
    evaluation: Evaluation  #: decisions and costs, episode by episode
    score: Interval | None  #: 0 for the best fixed plan, 100 for the hindsight planner; None without reference scores
    #: whether the fixed plan ran on the same episodes, and these are the episodes of the reference scores; otherwise
    #: the anchors are means of other episodes, and the interval ignores the error of these means
    paired: bool
    plant: str = ""  #: name of the machine, or of the set from which every episode draws a machine; empty for the model
    model: str = ""  #: name of the machine that planners and beliefs compute with
    first_seed: int = 0  #: first of the consecutive seeds of the episodes
    #: machines on which a trained agent learned; empty for other policies and where they are unknown
    trained_on: str = ""
    #: score of each resample, a ratio in %, shape (resamples,)
    draws: Array | None = field(default=None, repr=False, compare=False)

    @property
    def title(self) -> str:
        """Return the names of policy, problem and machine."""
        where = f" on {self.plant}" if self.plant else ""
        assumed = f" (policy assumes: {self.model})" if self.model not in ("", MODEL.name) else ""
        return f"{self.policy} in {self.problem}{where}{assumed}"

    @property
    def basis(self) -> str:
        """Return the episodes, and what the policy sees and was trained on."""
        seeds = f"{self.seeds} seeds" if self.seeds in SEEDS else f"seeds {self.seeds}"
        machines = "the model" if self.trained_on == MODEL.name else f"{self.trained_on} machines"
        trained = f", trained on {machines}" if self.trained_on else ""
        return f"{len(self.evaluation.cost)} episodes, {seeds}, split {self.split}; sees {self.sees}{trained}"

    def numbers(self) -> dict[str, Any]:
        """Return the results by name, for JSON; a cost is None if no part is good."""
        run = self.evaluation
        cost = [value if math.isfinite(value) else None for value in run.cost_per_good_part]
        found: dict[str, Any] = {
            "policy": self.policy,
            "sees": self.sees,
            "seeds": self.seeds,
            "split": self.split,
            "episodes": len(run.cost),
            "cost_per_good_part": cost[0],
            "low": cost[1],
            "high": cost[2],
            "scrap": run.scrap,
            "E": run.speed,
            "D": run.dresses,
        }
        if self.plant:
            found |= {"plant": self.plant, "model": self.model}
        if self.trained_on:
            found["trained_on"] = self.trained_on
        if self.score is not None:
            score = {"score": self.score.value, "score_low": self.score.low, "score_high": self.score.high}
            found |= {**score, "paired": self.paired}
        return found

    def episodes(self) -> Table:
        """Return a table with a row for each episode."""
        run = self.evaluation
        means = [np.nanmean(each, axis=1) for each in (run.speeds, run.executions)]
        rows = zip(repeat(self.policy), count(self.first_seed), run.cost, run.good, run.finished, *means, strict=False)
        return table_of(("policy", "seed", "cost, $", "good parts", "parts", "mean E, mm/min", "mean D"), rows)

    def __str__(self) -> str:
        cost, run = self.evaluation.cost_per_good_part, self.evaluation
        price = f"{cost.value:.3f} $ per good part ({cost.low:.3f} to {cost.high:.3f})"
        lines = [f"{self.title}: {price if math.isfinite(cost.value) else 'no good part'}"]
        if self.score is not None:
            others = f", unpaired: 100 is taken from other episodes ({REFERENCE_SEEDS} seeds, split {EVERY})"
            interval = f"({self.score.low:.1f} to {self.score.high:.1f})"
            lines.append(f"score {self.score.value:.1f} {interval}{'' if self.paired else others}")
        lines.append(f"{100 * run.scrap:.2f} % scrap, mean E {run.speed:.0f} mm/min, D {run.dresses:.2f}")
        return "\n".join([*lines, self.basis])

    def _repr_html_(self) -> str:
        return html("evaluations", self)


def evaluate(
    policy: Policy | str,
    problem: Problem | str,
    *,
    seeds: str | None = None,
    split: str = EVERY,
    episodes: int = 64,
    first_seed: int | None = None,
    plant: str | None = None,
    model: str | None = None,
    advance: Callable[[int], object] = nobody,
) -> Judgement:
    """Evaluate a policy on fixed seeds.

    Out-of-model machines and splits beyond the task give no score, because the anchors hold for model and task only.

    Args:
        policy: the policy, or a text for `named_policy`: a name, a file, a constant.
        problem: the problem, or a text for `find_problem`: an id, a task file, a part program.
        seeds: one of `SEEDS`; by default the evaluation seeds.
        split: split of the contexts, one of `grind_env.envs.distribution_splits.SPLITS`.
        episodes: number of episodes.
        first_seed: first of consecutive seeds of your own, in place of `seeds`.
        plant: name of the machine (`grind_env.plants`), by default the model; with a name without a seed, every episode
            draws a machine.
        model: name of the machine that planners, beliefs and experts compute with, by default the model.
        advance: called with the number of steps since its last call.

    Raises:
        GrindError: problem, policy, split or seeds do not exist, or the policy chooses an E or a D that the environment
            does not have.

    Example:
        >>> from grind_env import evaluate
        >>> found = evaluate("E7000D1", "grind/PowerLimited-v0", episodes=16)
        >>> found.sees, found.paired, round(found.evaluation.cost_per_good_part.value, 1)  # $
        ('measurements', True, 5.3)
    """
    problem = problem if isinstance(problem, Problem) else find_problem(problem)
    for name, value in (("episodes", episodes), ("first_seed", 0 if first_seed is None else first_seed)):
        if isinstance(value, bool) or not isinstance(value, int | np.integer):
            raise GrindError(f"{name} is {quoted(value)}, but must be a whole number")
    if episodes < 2:
        raise GrindError(f"{episodes} episodes have no interval: evaluate 2 at least")
    if first_seed is not None and first_seed < 0:
        raise GrindError(f"the first seed is {first_seed}: give 0 or more")
    if first_seed is not None and seeds is not None:
        raise GrindError(f"seeds is {quoted(seeds)}, and the first seed is {first_seed}: give one of both")
    named = REFERENCE_SEEDS if seeds is None else seeds
    chosen = episode_seeds(named, episodes) if first_seed is None else range(first_seed, first_seed + episodes)
    simulation = (problem if plant is None else on(problem, plant)).simulation()
    machines = simulation.plants
    if machines is None and model is not None:
        raise GrindError(f"model is {quoted(model)}, but what grinds is the model: give a plant, too")
    taken_for = MODEL.name if model is None else model
    held = None if machines is None else model_of(problem, taken_for)
    policy = named_policy(policy, held or simulation, modules=True) if isinstance(policy, str) else policy
    check_policy(policy)
    start = start_episodes(simulation, chosen, split)
    run = roll_out(policy, simulation, start, held, advance)
    anchored = machines is None and not SPLITS[split].leaves_task
    known, score, draws = find_reference(problem.id) if anchored else None, None, None
    paired = (chosen.start, split) == (SEEDS[REFERENCE_SEEDS], EVERY)
    if known is not None and not known.ratio:
        try:
            fixed = roll_out(make_policy(known.fixed_plan, simulation), simulation, start)
        except ConfigError:
            fixed = None
        paired = paired and fixed is not None
        score, draws = _score(run, fixed, known, simulation.task.reference_cost)
    said = named if first_seed is None else f"{chosen.start} to {chosen.stop - 1}"
    of_machine = ("", "") if machines is None else (machines.text, taken_for)
    name, sees, agent = policy.name, policy.sees, agent_of(policy)
    trained_on = "" if agent is None else agent.machines
    beside = (*of_machine, chosen.start, trained_on, draws)
    return Judgement(name, sees, problem.name, said, split, run, score, paired, *beside)


def check_policy(policy: Any) -> None:
    """Check that an object is a policy.

    Raises:
        GrindError: `policy` lacks `begin`, `act` or a name, or its `sees` is not a value of `Sees`.
    """
    decides = all(callable(getattr(policy, name, None)) for name in ("begin", "act"))
    if isinstance(policy, type) or not decides or not isinstance(getattr(policy, "name", None), str):
        raise GrindError(
            f"{quoted(policy)} is no policy: give one, or the text that names one, such as handbook or E8000D0"
        )
    if (sees := getattr(policy, "sees", None)) not in get_args(Sees):
        raise GrindError(f"{policy.name} sees {quoted(sees)}, but must see one of {', '.join(get_args(Sees))}")


def _score(
    run: Evaluation, fixed: Evaluation | None, known: Reference, reference_cost: float
) -> tuple[Interval, Array]:
    """Return the score and the score of each resample.

    The planner is too slow to be run here, so its saving on the fixed plan comes from the reference. Without a fixed
    plan on the same episodes, the anchors are the means of the reference.
    """
    span = (known.hundred - known.zero) * reference_cost
    if fixed is None:
        index = np.random.default_rng(0).integers(0, len(run.cost), (4000, len(run.cost)))
        zero = -known.zero * reference_cost
        draws = 100.0 * (zero - run.cost[index].mean(axis=1)) / span
        return percentile_interval(float(100.0 * (zero - run.cost.mean()) / span), draws), draws
    share = span / (-known.zero * reference_cost)
    planner = fixed.cost * (1.0 - share)
    draws = score_of_means(*resampled_means(np.array([run.cost, fixed.cost, planner])).T)
    return percentile_interval(float(normalised_score(run.cost, fixed.cost, planner)), draws), draws

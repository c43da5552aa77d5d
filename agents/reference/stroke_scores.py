"""Reference scores of `grind/Stroke-v0`: plans and rules, stroke by stroke.

There is no planner at this grain: 100 is a rule that sees the true state of the wheel and of the lot, with the
parameters that suit the very episode best.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import product
from pathlib import Path
from typing import Protocol

import numpy as np
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from agents.search import evolve
from grind_env.envs.names import environment_id
from grind_env.envs.observations import physical
from grind_env.envs.stroke.env import StrokeEnv
from grind_env.policies.choices import speed_bounds, speed_grid
from grind_env.policies.evaluation import episode_seeds
from grind_env.policies.scripted.rules import HANDBOOK_SPEED, REFERENCE_AREA
from grind_env.policies.statistics import Array
from grind_env.policies.tuned import write_whole
from grind_env.scores import FILE, Mean, Reference, read_references, write_text

TASK = "stroke"
EPISODES = 64
TRAINING = 12
"""Training episodes, some two thousand strokes."""
VALIDATION = 48
SHORTLIST = 12
"""Plans that are compared on the validation episodes."""
SPEEDS = 10
INTERVALS = (8, 12, 17, 24, 34, 48, 68)
"""Strokes from one dress to the next; a part has about 17."""
EVALUATIONS = 150
"""Of the CMA-ES run of a rule."""
IN_HINDSIGHT = 40
"""The same of the run on one episode, from the rule that suits all."""
NEARBY = 0.3
"""Initial step of that run."""

Seen = dict[str, float]


class Rule(Protocol):
    """Decides E (mm/min) of the coming stroke, and whether there is a dress before it."""

    def begin(self) -> None:
        """An episode begins."""

    def decide(self, seen: Seen) -> tuple[float, bool]:
        """Decide; `seen` are the readings in physical units, by name."""


@dataclass
class Uniform:
    """Uniform in the action space."""

    low: float
    high: float
    rng: np.random.Generator = field(default_factory=lambda: np.random.default_rng(0))

    def begin(self) -> None:
        """Nothing to do."""

    def decide(self, seen: Seen) -> tuple[float, bool]:
        """Draw."""
        E = math.exp(self.rng.uniform(math.log(self.low), math.log(self.high)))
        return E, bool(self.rng.random() < 0.5)


@dataclass
class Handbook:
    """The E that a handbook would give, and a dress before every part."""

    def begin(self) -> None:
        """Nothing to do."""

    def decide(self, seen: Seen) -> tuple[float, bool]:
        """Look whether a part begins."""
        return 1000.0 * HANDBOOK_SPEED, seen["starts_part"] > 0.5


@dataclass
class Constant:
    """One E, and a dress before every `every`-th stroke."""

    E: float
    every: int
    made: int = 0

    def begin(self) -> None:
        """Back to the first stroke."""
        self.made = 0

    def decide(self, seen: Seen) -> tuple[float, bool]:
        """The plan."""
        self.made += 1
        return self.E, self.made % self.every == 0


@dataclass
class Threshold:
    """What a power monitor allows: a dress above a specific energy, J/mm3, and a lower E near the power limit.

    Attributes:
        E: mm/min.
        upper: the energy.
        share: of the power limit.
        removal: width of the part times its pick, mm2.
        limit: of the power, W.
    """

    E: float
    upper: float
    share: float
    removal: float
    limit: float

    def begin(self) -> None:
        """Nothing to do."""

    def decide(self, seen: Seen) -> tuple[float, bool]:
        """Compare; after a dress there is no mean power until a full plunge has been made."""
        power, last = seen["mean_power"], 1000.0 * max(seen["last_speed"], 1e-3)
        expected = power * self.E / last
        E = self.E * min(1.0, self.share * self.limit / max(expected, 1.0))
        return E, power > self.upper * self.removal * last / 60.0


@dataclass
class FullState:
    """E and dresses by the true wear-flat area A and the severity k of the lot; x = ln(A / 0.015).

        ln E = ln E0 + gA x
        a dress if x > ln(A_dress / 0.015) - wK ln k + wL l, l the strokes left on the part over 20
    and none once less than `stop` of the parts are left.
    """

    E: float
    A_dress: float
    gA: float
    wK: float
    wL: float
    stop: float

    def begin(self) -> None:
        """Nothing to do."""

    def decide(self, seen: Seen) -> tuple[float, bool]:
        """Apply the rule."""
        x = math.log(max(seen["wear_flat"], 1e-4) / REFERENCE_AREA)
        threshold = math.log(self.A_dress / REFERENCE_AREA) - self.wK * math.log(max(seen["growth"], 0.05))
        dress = x > threshold + self.wL * seen["strokes_left"] / 20.0
        return self.E * math.exp(self.gA * x), dress and seen["remaining"] > self.stop


def returns(rule: Rule, seeds: Sequence[int], advance: Callable[[], object] = lambda: None) -> Array:
    """Return of the episode of each seed, shape (seeds,)."""
    env = StrokeEnv(observation="full", show_block=False)
    totals = np.zeros(len(seeds))
    for k, seed in enumerate(seeds):
        rule.begin()
        observation, terminated = env.reset(seed=int(seed))[0], False
        while not terminated:
            seen = {name: float(value) for name, value in physical(observation, env.observation_info()).items()}
            E, dress = rule.decide(seen)
            action = env.codec.encode(min(max(E, env.codec.low), env.codec.high), float(dress))[0]
            observation, reward, terminated, _, _ = env.step(action)
            totals[k] += reward
        advance()
    return totals


def constant(cost: Callable[[Rule], float], validated: Callable[[Rule], float], speeds: Sequence[float]) -> Constant:
    """The best constant E and interval of dresses.

    Without sensors a rare hard lot decides, and the training episodes have few of these: those plans of the grid that
    are best on them are compared on the validation episodes.
    """
    plans = [Constant(E, every) for E, every in product(speeds, INTERVALS)]
    # sorted by cost alone, the first of equals first
    best = sorted(plans, key=cost)[:SHORTLIST]
    return min(best, key=validated)


def threshold_of(vector: Array, removal: float, limit: float) -> Threshold:
    """The power rule of a search vector of 3."""
    return Threshold(9000.0 * scale(vector[0]), 60.0 * scale(vector[1]), 0.8 * scale(vector[2]), removal, limit)


def full_state_of(vector: Array) -> FullState:
    """The rule on the true state of a search vector of 6."""
    z = 0.2 * np.asarray(vector)
    return FullState(
        9000.0 * scale(vector[0]), 0.02 * scale(vector[1]), z[2] - 0.5, z[3] + 0.2, z[4], max(0.25 * z[5], 0.0)
    )


def scale(z: float) -> float:
    """A factor for a parameter that must be positive."""
    return math.exp(min(max(0.2 * z, -3.0), 3.0))


def in_hindsight(vector: Array, seed: int, evaluations: int) -> float:
    """Return of the rule of the vector, or of the best one found near it, on one episode."""

    def cost(trial: Array) -> float:
        return -float(returns(full_state_of(trial), [seed])[0])

    return -min(cost(vector), evolve(cost, vector, evaluations, 0, NEARBY).cost)


def stroke_reference(
    *,
    episodes: int = EPISODES,
    training: int = TRAINING,
    validation: int = VALIDATION,
    evaluations: int = EVALUATIONS,
    hindsight: int = IN_HINDSIGHT,
) -> Reference:
    """Tune the plan and the rules on the training episodes, and measure all on the evaluation episodes.

    Args:
        episodes: evaluation episodes.
        training: training episodes.
        validation: validation episodes of the plan.
        evaluations: of the CMA-ES run of a rule.
        hindsight: of the run on one episode.
    """
    task = StrokeEnv().task
    kind, seeds = task.kinds[0], episode_seeds("evaluation", episodes)
    removal, limit = kind.width * kind.pick, task.machine.power_limit
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, transient=True) as progress:
        total = SPEEDS * len(INTERVALS) + SHORTLIST + 2 * evaluations
        bar = progress.add_task(f"{TASK}: tuning", total=total)

        def cost(rule: Rule, split: str = "training", count: int = training) -> float:
            value = -float(returns(rule, episode_seeds(split, count)).mean())
            progress.advance(bar)
            return value

        def best(make: Callable[[Array], Rule], size: int) -> Array:
            point: Array = evolve(lambda vector: cost(make(vector)), np.zeros(size), evaluations, 0).point
            return point

        plan = constant(cost, lambda rule: cost(rule, "validation", validation), speed_grid(task, SPEEDS).tolist())
        power = threshold_of(best(lambda vector: threshold_of(vector, removal, limit), 3), removal, limit)
        vector = best(full_state_of, 6)
        rules: dict[str, Rule] = {
            "random": Uniform(*speed_bounds(task)),
            "handbook": Handbook(),
            "constant": plan,
            "power_threshold": power,
            "full_state_rule": full_state_of(vector),
        }
        progress.update(bar, description=TASK, total=(len(rules) + 1) * episodes, completed=0)
        found = {name: returns(rule, seeds, lambda: progress.advance(bar)) for name, rule in rules.items()}
        known = []
        for seed in seeds:
            known.append(in_hindsight(vector, seed, hindsight))
            progress.advance(bar)
        found["hindsight"] = np.array(known)
    return reference_of_returns(found, task.reference_cost)


def reference_of_returns(found: dict[str, Array], reference_cost: float) -> Reference:
    """The reference scores; the returns are those of the same episodes."""
    means = {
        name: Mean(round(float(each.mean()), 4), round(float(each.std(ddof=1)) / len(each) ** 0.5, 4))
        for name, each in found.items()
    }
    zero, hundred = means["constant"].value, means["hindsight"].value
    return Reference(
        zero=zero,
        hundred=hundred,
        ratio=False,
        fixed_plan="constant",
        best_scripted="power_threshold",
        J_fix=round(-zero * reference_cost, 4),
        J_plan=round(-hundred * reference_cost, 4),
        returns=means,
    )


def score_stroke(data: Path = FILE) -> None:
    """Measure the reference scores of the environment of single strokes."""
    found = stroke_reference()
    # read only now: others may have written to the file in the meantime
    write_whole(data, write_text({**read_references(data), environment_id(TASK): found}))

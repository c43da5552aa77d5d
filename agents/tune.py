"""Tunes the scripted policies on the training episodes of a task; between runs the validation episodes decide."""

from collections.abc import Callable
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from agents.evaluate import episode_seeds, roll_out, start_episodes
from agents.policy import Policy, speed_bounds, speed_grid
from agents.registry import TUNED, policy_names
from agents.scripted.rules import Fixed
from agents.search import Found, evolve, grid_search, refine
from agents.tuned import CONFIGS, ConfigError, Parameters, Tuned, arguments, read_tuned, write_tuned
from grind_env.envs.simulation import Simulation
from grind_env.envs.tasks import Task, load_task

EPISODES = 48
EVALUATIONS = 700
"""Evaluations of one CMA-ES run; every rule has `STARTS` runs."""
STARTS = 4

SPEEDS = 20
INTERVAL_SPEEDS = 12
INTERVALS = (2, 3, 4, 5, 6, 8, 10, 12, 16, 20, 24, 32, 48)
DIGITS = 5


class Coefficient(NamedTuple):
    """A parameter as the search sees it: `start + step z`, or `start exp(step z)` for one that must be positive.

    `by_kind` has one value a kind of block; `whole` is a number of executions, from 0 to the most of the task;
    `needs` is the table of a task without which the parameter has no meaning.
    """

    name: str
    start: float
    step: float
    positive: bool = False
    by_kind: bool = False
    whole: bool = False
    most: float = np.inf
    needs: str | None = None

    def size(self, task: Task) -> int:
        """How many entries of the search vector it takes: none if the task lacks what it needs."""
        if self.needs is not None and getattr(task, self.needs) is None:
            return 0
        return len(task.kinds) if self.by_kind else 1

    def value(self, z: float, executions: int) -> float:
        """The parameter at z, as it stands in the file; `executions` is the most of the task."""
        change = self.step * z
        value = self.start * np.exp(np.clip(change, -5.0, 5.0)) if self.positive else self.start + change
        return int(np.clip(np.rint(value), 0, executions)) if self.whole else rounded(min(value, self.most))


SHARPNESS = (
    Coefficient("E", 12.0, 0.2, positive=True, by_kind=True),
    Coefficient("A_dress", 0.015, 0.2, positive=True, by_kind=True),
    Coefficient("gA", -0.3, 0.2),
    Coefficient("gF", 0.0, 0.1),
    Coefficient("gH", 0.0, 0.1),
    Coefficient("wV", 0.0, 0.2),
    Coefficient("wH", 0.5, 0.2),
    Coefficient("gP", 0.0, 0.1, needs="due"),
    Coefficient("wP", 0.0, 0.1, needs="due"),
    Coefficient("gB", 0.0, 0.1, needs="wheel_change"),
    Coefficient("wB", 0.0, 0.1, needs="wheel_change"),
)
RULES: dict[str, tuple[Coefficient, ...]] = {
    "constant_per_kind": (
        Coefficient("E", 12.0, 0.4, positive=True, by_kind=True),
        Coefficient("D", 0.5, 0.5, by_kind=True, whole=True),
    ),
    "power_threshold": (
        Coefficient("E", 12.0, 0.2, positive=True),
        Coefficient("upper", 60.0, 0.2, positive=True),
        Coefficient("lower", 0.9, 0.1, positive=True, most=1.0),
        Coefficient("share", 0.8, 0.1, positive=True),
    ),
    "adaptive_rule": (
        *SHARPNESS,
        Coefficient("gS", 0.0, 0.1),
        Coefficient("wS", 0.1, 0.1),
    ),
    "full_state_rule": (
        *SHARPNESS,
        Coefficient("gK", 0.0, 0.1),
        Coefficient("gR", 0.0, 0.1),
        Coefficient("wK", 0.3, 0.2),
    ),
}
"""What CMA-ES tunes."""

Advance = Callable[[], object]


class Tuner:
    """Costs of policies on the training and validation episodes of a task.

    Args:
        task: the task.
        episodes: number of episodes of each.
        advance: called after every evaluation.
    """

    def __init__(self, task: Task, episodes: int = EPISODES, advance: Advance = lambda: None) -> None:
        self.task = task
        self.seeds = {split: episode_seeds(split, episodes) for split in ("training", "validation")}
        self.simulation = Simulation(task)
        self._episodes = {split: start_episodes(self.simulation, seeds) for split, seeds in self.seeds.items()}
        self._advance = advance

    def cost(self, policy: Policy, split: str = "training") -> float:
        """Mean cost of an episode, $."""
        evaluation = roll_out(policy, self.simulation, self._episodes[split])
        self._advance()
        return float(evaluation.cost.mean())

    def constant(self) -> tuple[Fixed, int]:
        """The best constant E and D, and the evaluations spent."""
        return self._fixed("constant", SPEEDS, range(self.task.action.executions + 1), (1,))

    def interval(self) -> tuple[Fixed, int]:
        """The best constant E with one or two executions in every N-th block."""
        return self._fixed("interval", INTERVAL_SPEEDS, range(1, min(2, self.task.action.executions) + 1), INTERVALS)

    def _fixed(self, name: str, speeds: int, D: range, every: tuple[int, ...]) -> tuple[Fixed, int]:
        def plan(E: float, D: int, every: int) -> Fixed:
            return Fixed(rounded(E), D, every, name)

        found = grid_search(lambda point: self.cost(plan(*point)), product(self._speeds(speeds), D, every))
        E, *rest = found.point
        found = self._refine(lambda E: self.cost(plan(E, *rest)), found._replace(point=E))
        return plan(found.point, *rest), found.evaluations

    def _speeds(self, count: int) -> list[float]:
        return [float(speed) / 1000.0 for speed in speed_grid(self.task, count)]

    def _refine(self, cost: Callable[[float], float], found: Found) -> Found:
        if self.task.action.speed_levels is not None:
            return found
        low, high = speed_bounds(self.task)
        return refine(cost, found, low / 1000.0, high / 1000.0)

    def rule(self, name: str, evaluations: int) -> tuple[Policy, Parameters, int]:
        """The best of `STARTS` CMA-ES runs of a rule, on the validation episodes."""
        coefficients = RULES[name]

        def parameters(vector: Any) -> Parameters:
            return from_vector(coefficients, self.task, vector)

        def make(vector: Any) -> Policy:
            return TUNED[name](**arguments(parameters(vector)))

        size = sum(coefficient.size(self.task) for coefficient in coefficients)
        runs = []
        for seed in range(STARTS):
            # the first run starts where the table says, every other from a point of its own
            start = np.random.default_rng(seed).standard_normal(size) * (seed > 0)
            runs.append(evolve(lambda vector: self.cost(make(vector)), start, evaluations, seed))
        best = min(runs, key=lambda run: self.cost(make(run.point), "validation"))
        return make(best.point), parameters(best.point), sum(run.evaluations for run in runs)


def from_vector(coefficients: tuple[Coefficient, ...], task: Task, vector: Any) -> Parameters:
    """Parameters of a rule from a search vector, with as many entries for each coefficient as it has for the task."""
    result: dict[str, Any] = {}
    position = 0
    for coefficient in coefficients:
        size = coefficient.size(task)
        values = [coefficient.value(z, task.action.executions) for z in vector[position : position + size]]
        position += size
        if values:
            result[coefficient.name] = values if coefficient.by_kind else values[0]
    return result


def rounded(value: Any) -> float:
    """The value as it stands in the file."""
    return float(f"{value:.{DIGITS}g}")


def tunable(task: Task) -> list[str]:
    """Names of the policies that can be tuned for a task."""
    return [name for name in policy_names(task) if name in TUNED]


def tune_policy(name: str, tuner: Tuner, evaluations: int) -> Tuned:
    """Tune one policy."""
    if name in RULES:
        policy, parameters, spent = tuner.rule(name, evaluations)
    else:
        plan, spent = tuner.constant() if name == "constant" else tuner.interval()
        policy, parameters = plan, {"E": plan.E, "D": plan.D, "every": plan.every}
    return Tuned(
        parameters=parameters,
        training_cost=round(tuner.cost(policy), 4),
        validation_cost=round(tuner.cost(policy, "validation"), 4),
        evaluations=spent,
        training_seeds=[tuner.seeds["training"].start, len(tuner.seeds["training"])],
        validation_seeds=[tuner.seeds["validation"].start, len(tuner.seeds["validation"])],
    )


def tune(
    task_name: str,
    names: list[str] | None = None,
    *,
    evaluations: int = EVALUATIONS,
    episodes: int = EPISODES,
    folder: Path = CONFIGS,
    fresh: bool = False,
) -> dict[str, Tuned]:
    """Tune the policies that the file of the task does not have yet, and store each as soon as it is done.

    Args:
        task_name: name of the task.
        names: policies; all that can be tuned by default.
        evaluations: of each CMA-ES run.
        episodes: of the training and of the validation split.
        folder: of the files.
        fresh: tune again what the file has.

    Raises:
        ConfigError: if a policy has nothing to tune.
    """
    task = load_task(task_name)
    for name in names or ():
        if name not in tunable(task):
            raise ConfigError(f"{name!r} cannot be tuned for {task_name}: choose from {', '.join(tunable(task))}")
    tuned = read_tuned(task_name, folder)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns) as progress:
        for name in names or tunable(task):
            if name in tuned and not fresh:
                continue
            total = STARTS * evaluations if name in RULES else None
            bar = progress.add_task(name, total=total)
            tuner = Tuner(task, episodes, partial(progress.advance, bar))
            tuned[name] = tune_policy(name, tuner, evaluations)
            progress.update(bar, total=progress.tasks[bar].completed)
            tuned = {each: tuned[each] for each in tunable(task) if each in tuned}
            write_tuned(task_name, tuned, folder)
    return tuned

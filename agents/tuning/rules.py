"""Tunes the scripted policies on the training episodes of a task; between runs the validation episodes decide."""

import hashlib
from collections.abc import Callable, Sequence
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from agents.budgets import TUNING_EPISODES, TUNING_EVALUATIONS, TUNING_STARTS
from agents.cells import RUNS, behaviour, sources
from agents.tuning.coefficients import RULES, entry_names, from_vector, rounded
from agents.tuning.search import Found, evolve, grid_search, refine
from agents.tuning.studies import KeptCosts, open_study, sqlite_url
from grind_env.envs.simulation import Simulation
from grind_env.errors import quoted
from grind_env.policies.choices import speed_bounds, speed_grid
from grind_env.policies.evaluation import episode_seeds, roll_out, start_episodes
from grind_env.policies.policy import Policy
from grind_env.policies.problem import Problem
from grind_env.policies.registry import TUNED, policy_names
from grind_env.policies.scripted.rules import Fixed
from grind_env.policies.tuned import (
    ConfigError,
    Parameters,
    Tuned,
    arguments,
    read_tuned,
    tuned_folder,
    write_tuned,
)

SPEEDS = 20
INTERVAL_SPEEDS = 12
INTERVALS = (2, 3, 4, 5, 6, 8, 10, 12, 16, 20, 24, 32, 48)
"""Blocks from one dress to the next."""
STROKES = (4, 6, 8, 12, 17, 24, 34, 48, 68, 96, 136)
"""Strokes from one dress to the next, where a step is one."""

Advance = Callable[[], object]


class Tuner:
    """Costs of policies on the training and validation episodes of a problem.

    Args:
        simulation: of the problem.
        storage: URL of the database of the studies, one for each policy and start.
        episodes: number of episodes of each split.
        fresh: whether to throw away what the studies hold.
        advance: called after every trial, whether evaluated now or kept.
    """

    def __init__(
        self,
        simulation: Simulation,
        storage: str,
        episodes: int = TUNING_EPISODES,
        fresh: bool = False,
        advance: Advance = lambda: None,
    ) -> None:
        self.simulation, self.task = simulation, simulation.task
        self.seeds = {split: episode_seeds(split, episodes) for split in ("training", "validation")}
        self._episodes = {split: start_episodes(self.simulation, seeds) for split, seeds in self.seeds.items()}
        self._storage, self._fresh, self._advance = storage, fresh, advance

    def cost(self, policy: Policy, split: str = "training") -> float:
        """Mean cost of an episode, $."""
        return float(roll_out(policy, self.simulation, self._episodes[split]).cost.mean())

    def constant(self) -> tuple[Fixed, int]:
        """The best constant E and D, and the evaluations spent."""
        return self._fixed("constant", SPEEDS, range(self.task.action.executions + 1), (1,))

    def interval(self) -> tuple[Fixed, int]:
        """The best constant E with one or two executions in every N-th block."""
        D = range(1, min(2, self.task.action.executions) + 1)
        return self._fixed("interval", INTERVAL_SPEEDS, D, INTERVALS if self.simulation.by_block else STROKES)

    def _fixed(self, name: str, speeds: int, D: range, every: tuple[int, ...]) -> tuple[Fixed, int]:
        def plan(E: float, D: int, every: int) -> Fixed:
            return Fixed(rounded(E), D, every, name)

        cost = self._kept(name, ("E", "D", "every"), lambda point: self.cost(plan(*point)))
        found = grid_search(cost, product(self._speeds(speeds), D, every))
        E, *rest = found.point
        found = self._refine(lambda E: cost((E, *rest)), found._replace(point=E))
        return plan(found.point, *rest), found.evaluations

    def _speeds(self, count: int) -> list[float]:
        return [float(speed) / 1000.0 for speed in speed_grid(self.task, count)]

    def _refine(self, cost: Callable[[float], float], found: Found) -> Found:
        if self.task.action.speed_levels is not None:
            return found
        low, high = speed_bounds(self.task)
        return refine(cost, found, low / 1000.0, high / 1000.0)

    def rule(self, name: str, evaluations: int, starts: int) -> tuple[Policy, Parameters, int]:
        """The best of several CMA-ES runs of a rule, on the validation episodes."""
        coefficients = RULES[name]
        entries = entry_names(coefficients, self.task)

        def parameters(vector: Any) -> Parameters:
            return from_vector(coefficients, self.task, vector)

        def make(vector: Any) -> Policy:
            return TUNED[name](**arguments(parameters(vector)))

        runs = []
        for seed in range(starts):
            # the first run starts where the table says, every other from a point of its own
            start = np.random.default_rng(seed).standard_normal(len(entries)) * (seed > 0)
            cost = self._kept(f"{name}/{seed}", entries, lambda vector: self.cost(make(vector)))
            runs.append(evolve(cost, start, evaluations, seed))
        best = min(runs, key=lambda run: self.cost(make(run.point), "validation"))
        return make(best.point), parameters(best.point), sum(run.evaluations for run in runs)

    def _kept(self, search: str, entries: Sequence[str], cost: Callable[[Any], float]) -> KeptCosts:
        """The cost function of a search, with its study; another code, task or list of seeds has another study."""
        policy = search.partition("/")[0]
        decides = TUNED[policy]
        module = (decides.func if isinstance(decides, partial) else decides).__module__
        facts = f"{sources(module)} {behaviour(self.simulation)} {RULES.get(policy)} {self.seeds}"
        name = f"{self.task.name}/{search}/{hashlib.sha256(facts.encode()).hexdigest()[:8]}"
        return KeptCosts(open_study(self._storage, name, fresh=self._fresh), entries, cost, self._advance)


def tunable(simulation: Simulation) -> list[str]:
    """Names of the policies that can be tuned for an environment."""
    return [name for name in policy_names(simulation) if name in TUNED]


def tune_policy(name: str, tuner: Tuner, evaluations: int, starts: int) -> Tuned:
    """Tune one policy."""
    if name in RULES:
        policy, parameters, spent = tuner.rule(name, evaluations, starts)
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
    problem: Problem,
    names: list[str] | None = None,
    *,
    evaluations: int = TUNING_EVALUATIONS,
    starts: int = TUNING_STARTS,
    episodes: int = TUNING_EPISODES,
    storage: str | None = None,
    folder: Path | None = None,
    runs: Path = RUNS,
    fresh: bool = False,
) -> dict[str, Tuned]:
    """Tune the policies that the file of the task does not have yet, and store each as soon as it is done.

    Args:
        problem: what is ground.
        names: policies; all that can be tuned by default.
        evaluations: of each CMA-ES run.
        starts: number of CMA-ES runs of a rule.
        episodes: of the training and of the validation split.
        storage: URL of the database that keeps the trials, so that a search that was killed goes on; by default an
            SQLite file `<task>/tune.db` below `runs`.
        folder: of the files; by default that of `tuned_folder`.
        runs: folder of the trials.
        fresh: tune again what the file has; one that is damaged is written anew, with these policies only.

    Raises:
        ConfigError: if a policy has nothing to tune, or the file is damaged and `fresh` is not asked for.
    """
    simulation, known = problem.simulation(), tunable(problem.simulation())
    for name in names or ():
        if name not in known:
            raise ConfigError(f"{quoted(name)} cannot be tuned for {problem.name}: choose from {', '.join(known)}")
    folder = tuned_folder(simulation.task, folder)
    tuned = _readable(problem.name, folder, fresh)
    url = sqlite_url(runs / problem.name / "tune.db") if storage is None else storage
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns) as progress:
        for name in names or known:
            if name in tuned and not fresh:
                continue
            total = starts * evaluations if name in RULES else None
            bar = progress.add_task(name, total=total)
            tuner = Tuner(simulation, url, episodes, fresh, partial(progress.advance, bar))
            tuned[name] = tune_policy(name, tuner, evaluations, starts)
            progress.update(bar, total=progress.tasks[bar].completed)
            # another process may have tuned other policies meanwhile
            tuned = _readable(problem.name, folder, fresh) | {name: tuned[name]}
            tuned = {each: tuned[each] for each in known if each in tuned}
            write_tuned(problem.name, tuned, folder)
    return tuned


def _readable(problem: str, folder: Path, fresh: bool) -> dict[str, Tuned]:
    """The tuned policies of a task; none if the file is damaged and to be written anew."""
    try:
        return read_tuned(problem, folder)
    except ConfigError:
        if fresh:
            return {}
        raise

"""Tuning of scripted policies on training episodes of a task, and choice between runs on validation episodes."""

import hashlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from agents.command_defaults import TUNING_EPISODES, TUNING_EVALUATIONS, TUNING_STARTS
from agents.evaluation_cache import RUNS, behaviour, sources
from agents.parallel_trials import run_all
from agents.tuning.minimisers import BestPoint, CachedCosts, evolve, grid_search, refine
from agents.tuning.tunable_parameters import RULES, from_vector, rounded, vector_size
from grind_env.envs.episode_state import Episodes
from grind_env.envs.simulation import Simulation
from grind_env.message_text import quoted
from grind_env.output_checks import check_replaceable
from grind_env.policies.choices import Decision, speed_grid
from grind_env.policies.evaluation import episode_seeds, roll_out, start_episodes
from grind_env.policies.policy import Policy, Sees
from grind_env.policies.problem_lookup import Problem
from grind_env.policies.registry import ABLATIONS, TUNED, make_policy, policy_names
from grind_env.policies.scripted.rules import Fixed
from grind_env.policies.tuned_parameters import (
    TUNED_FILE,
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
INTERVALS = (2, 3, 4, 5, 6, 8, 10, 12, 16, 20, 24, 32, 48)  #: tried numbers of blocks from one dress to the next
COST_DIGITS = 1e-3  #: tolerance of the cost of an episode in a file, $


class SideBySide:
    """Policies on measurements as one policy: each decides for an equal share of the episodes, in this order."""

    name: ClassVar[str] = "side_by_side"
    sees: ClassVar[Sees] = "measurements"

    def __init__(self, policies: Sequence[Policy]) -> None:
        self.policies = policies

    def begin(self, simulation: Simulation, episodes: int) -> None:
        for policy in self.policies:
            policy.begin(simulation, episodes // len(self.policies))

    def act(self, observation: NDArray[np.float32], episodes: Episodes | None) -> Decision:
        shares = np.split(observation, len(self.policies))
        decided = [policy.act(share, None) for policy, share in zip(self.policies, shares, strict=True)]
        return Decision(*map(np.concatenate, zip(*decided, strict=True)))


class Tuner:
    """Costs of policies on training and validation episodes of a problem, cached in a folder if there is one."""

    def __init__(
        self,
        simulation: Simulation,
        folder: Path | None,
        episodes: int = TUNING_EPISODES,
        fresh: bool = False,
        advance: Callable[[int], object] = lambda points: None,
    ) -> None:
        self.simulation, self.task = simulation, simulation.task
        self.seeds = {name: episode_seeds(name, episodes) for name in ("training", "validation")}
        self._episodes = {name: start_episodes(self.simulation, seeds) for name, seeds in self.seeds.items()}
        self._folder, self._fresh, self._advance = folder, fresh, advance

    def cost(self, policy: Policy, seeds: str = "training") -> float:
        """Return the mean cost of an episode, $."""
        return float(roll_out(policy, self.simulation, self._episodes[seeds]).cost.mean())

    def costs(self, policies: Sequence[Policy]) -> list[float]:
        """Return the mean costs of a training episode under several policies, $."""
        # policies that see more get copies of the episodes at every step: together they are no faster
        if policies[0].sees != "measurements":
            return [self.cost(policy) for policy in policies]
        n = len(self.seeds["training"])
        episodes = self._episodes["training"].pick(np.tile(np.arange(n), len(policies)))
        run = roll_out(SideBySide(policies), self.simulation, episodes)
        return [float(run.cost[first : first + n].mean()) for first in range(0, len(run.cost), n)]

    def constant(self) -> tuple[Fixed, int]:
        """Return the best constant E and D, and the evaluations spent."""
        return self._fixed("constant", SPEEDS, range(self.task.action.executions + 1), (1,))

    def interval(self) -> tuple[Fixed, int]:
        """Return the best constant E with one or two executions in every N-th block, and the evaluations spent."""
        D = range(1, min(2, self.task.action.executions) + 1)
        return self._fixed("interval", INTERVAL_SPEEDS, D, INTERVALS)

    def _fixed(self, name: str, speeds: int, D: range, every: tuple[int, ...]) -> tuple[Fixed, int]:
        def plan(E: float, D: int, every: int) -> Fixed:
            return Fixed(rounded(E), D, every, name)

        costs = self._cached(name, lambda point: plan(*point))
        found = grid_search(costs, product(speed_grid(self.task, speeds).tolist(), D, every))
        E, *rest = found.point
        found = found._replace(point=E)
        if self.task.action.speed_levels is None:
            found = refine(lambda E: costs([(E, *rest)])[0], found, *self.task.action.speed_ends)
        return plan(found.point, *rest), found.evaluations

    def rule(self, name: str, evaluations: int, starts: int) -> tuple[Policy, Parameters, int]:
        """Return policy, parameters and evaluations of the CMA-ES run of a rule with the least validation cost."""
        runs = [self.run(self.cached_run(name, seed), name, evaluations, seed) for seed in range(starts)]
        best = min(runs, key=lambda run: self.cost(self._made(name, run.point), "validation"))
        return self._made(name, best.point), self._parameters(name, best.point), sum(run.evaluations for run in runs)

    def run(self, costs: CachedCosts, name: str, evaluations: int, seed: int) -> BestPoint:
        # the first run starts at the values in `RULES`, every other run at a random point
        start = np.random.default_rng(seed).standard_normal(vector_size(RULES[name], self.task)) * (seed > 0)
        return evolve(costs, start, evaluations, seed)

    def cached_run(self, name: str, seed: int) -> CachedCosts:
        """Return the costs of a CMA-ES run of a rule."""
        return self._cached(f"{name}-{seed}", lambda vector: self._made(name, vector))

    def _made(self, name: str, vector: Any) -> Policy:
        policy: Policy = TUNED[name](**arguments(self._parameters(name, vector)))
        return policy

    def _parameters(self, name: str, vector: Any) -> Parameters:
        return from_vector(RULES[name], self.task, vector)

    def _cached(self, search: str, made: Callable[[Any], Policy]) -> CachedCosts:
        """Return the costs of a search over policies, cached by code, task and seeds."""
        policy = search.partition("-")[0]
        decides = TUNED[policy]
        module = (decides.func if isinstance(decides, partial) else decides).__module__
        code = sources(module), sources(CachedCosts.__module__), behaviour(self.simulation)
        digest = hashlib.sha256(f"{code} {RULES.get(policy)} {self.seeds}".encode()).hexdigest()[:8]
        path = self._folder and self._folder / f"{search}-{digest}.jsonl"
        if path and self._fresh:
            path.unlink(missing_ok=True)
        return CachedCosts(lambda points: self.costs([made(point) for point in points]), path, self._advance)


@dataclass(frozen=True)
class TuningRun:
    """CMA-ES run of a rule, which another process may do; see `tune`."""

    problem: Problem
    policy: str
    seed: int
    folder: Path | None  #: folder of the cache; None for a run on a node, which cannot reach the cache
    evaluations: int
    episodes: int
    fresh: bool

    def __str__(self) -> str:
        return f"{self.problem.name} {self.policy}, run {self.seed}"

    def costs(self) -> tuple[Tuner, CachedCosts]:
        """Return the tuner of the run and its cached costs."""
        tuner = Tuner(self.problem.simulation(), self.folder, self.episodes, self.fresh)
        return tuner, tuner.cached_run(self.policy, self.seed)


def do_run(run: TuningRun) -> list[Any]:
    """Do a run and cache its costs; return the costs only if the run has no folder."""
    tuner, costs = run.costs()
    tuner.run(costs, run.policy, run.evaluations, run.seed)
    return [] if run.folder else [*costs.known.items()]


def tunable(simulation: Simulation) -> list[str]:
    """Return the names of the listed policies of an environment that can be tuned."""
    return [name for name in policy_names(simulation) if name in TUNED]


def tune_policy(name: str, tuner: Tuner, evaluations: int, starts: int) -> Tuned:
    """Tune one policy; return its parameters and costs."""
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
    folder: Path | None = None,
    runs: Path = RUNS,
    fresh: bool = False,
    jobs: int = 1,
    ray: str | None = None,
) -> dict[str, Tuned]:
    """Tune the policies missing in the task's file, and store each one when it is done.

    Policies tuned for another task are tuned again. A killed search resumes from its cache in `<task>/tuning` below
    `runs`. The result does not depend on `jobs` or `ray`.

    Raises:
        ConfigError: a policy has nothing to tune, or the file is damaged and `fresh` is not asked for.
    """
    simulation = problem.simulation()
    listed, cache = tunable(simulation), runs / problem.name / "tuning"
    known = [*listed, *ABLATIONS]
    for name in names or ():
        if name not in known:
            raise ConfigError(f"{quoted(name)} cannot be tuned for {problem.name}: choose from {', '.join(known)}")
    folder = tuned_folder(simulation.task, folder)
    check_replaceable(folder / f"{problem.name}.toml", TUNED_FILE, "--parameters")
    tuned = _readable(problem.name, folder, fresh)
    names = listed if names is None else names
    if not fresh:
        names = [name for name in names if name not in tuned or not _holds(name, tuned[name], simulation, folder)]
    asked = [
        TuningRun(problem, name, seed, cache, evaluations, episodes, fresh) for name in names for seed in range(starts)
    ]
    done = _side_by_side(asked, jobs, ray)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns) as progress:
        for name in names:
            total = starts * evaluations if name in RULES else None
            bar = progress.add_task(name, total=total)
            tuner = Tuner(simulation, cache, episodes, fresh and name not in done, partial(progress.advance, bar))
            tuned[name] = tune_policy(name, tuner, evaluations, starts)
            progress.update(bar, total=progress.tasks[bar].completed)
            # another process may have tuned other policies meanwhile
            tuned = _readable(problem.name, folder, fresh) | {name: tuned[name]}
            tuned = {each: tuned[each] for each in known if each in tuned}
            write_tuned(problem.name, tuned, folder)
    return tuned


def _side_by_side(runs: Sequence[TuningRun], jobs: int, ray: str | None) -> set[str]:
    """Do the runs of rules on a cluster or in several processes; return the names of these policies.

    A run that fails here fails again, with its error, when `tune` needs its result.
    """
    # the policies that take longest come last in all lists
    runs = [run for run in reversed(runs) if run.policy in RULES]
    if not runs or (ray is None and (jobs == 1 or len(runs) < 2)):
        return set()

    sent = [run if ray is None else replace(run, folder=None) for run in runs]
    cached = dict(zip(sent, runs, strict=True))

    def keep(run: TuningRun, found: list[Any]) -> None:
        if found:
            cached[run].costs()[1].add(dict(found))

    run_all(sent, do_run, jobs, Console(), ray, keep)
    return {run.policy for run in runs}


def _holds(name: str, tuned: Tuned, simulation: Simulation, folder: Path) -> bool:
    """Return whether parameters have the cost that their file states; parameters of another task do not."""
    try:
        policy = make_policy(name, simulation, folder)
    except ConfigError:
        return False
    first, count = tuned.training_seeds
    found = roll_out(policy, simulation, start_episodes(simulation, range(first, first + count)))
    return abs(float(found.cost.mean()) - tuned.training_cost) < COST_DIGITS


def _readable(problem: str, folder: Path, fresh: bool) -> dict[str, Tuned]:
    """Return the tuned policies of a task; none if the file is damaged and `fresh`."""
    try:
        return read_tuned(problem, folder)
    except ConfigError:
        if fresh:
            return {}
        raise

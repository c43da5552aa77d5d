"""The dress study as trials, one finding each, with tables and pictures."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

from agents.benchmark.cpu_time import DECISION, USUAL_DECISION
from agents.benchmark.figures import write_figure
from agents.dressing.figure import dress_figure
from agents.dressing.findings import PLANS, DressFinding, best_plan, csv_text, dressers, finding, intervals
from agents.evaluation_cache import RUNS, cached_evaluation, code_of
from agents.study import Study, StudyOptions
from grind_env.envs.blocks.task_simulation import BlockSimulation
from grind_env.envs.tasks import Dress
from grind_env.files import is_file
from grind_env.output_checks import FileKind, check_replaceable
from grind_env.policies.evaluation import episode_seeds, run_seeds
from grind_env.policies.policy_lookup import FALLBACK, named_policy, usual_name
from grind_env.policies.problem_lookup import Problem
from grind_env.policies.registry import policy_names
from grind_env.policies.tuned_parameters import write_whole

PICTURE = FileKind("picture of `python -m agents dress-study`, whose table would lie beside it", lambda head: False)
PLANNED = 4e-6  #: CPU-seconds of a block under a fixed plan
#: policies that do not decide when to dress
BASELINES = ("random", "handbook", "constant", "constant_per_kind", "interval")


@dataclass(frozen=True)
class DressTrial:
    """Question about a way to dress; `what` holds the intervals to try, or the name of the policy that decides."""

    problem: Problem
    question: str
    what: tuple[int, ...] | str
    episodes: int
    dress: Dress | None = None
    runs: Path = field(default=RUNS, repr=False, compare=False)

    def __str__(self) -> str:
        what = self.what if isinstance(self.what, str) or len(self.what) == 1 else "best plan"
        return f"{self.problem.name}, {self.question}: {what}"


def study(asked: StudyOptions) -> Study:
    """Return the study of each problem; tasks, which set the dresser, have questions on its settings, too."""
    for each in asked.problems:
        if not is_file(asked.results / f"{each.name}.csv"):
            check_replaceable(asked.results / f"{each.name}.png", PICTURE, "--results")
    trials, episodes, runs = list[DressTrial](), asked.episodes, asked.options.runs.absolute()
    for problem in asked.problems:
        every = tuple(intervals(problem.simulation()))
        trials += [DressTrial(problem, "interval", (each,), episodes) for each in every]
        trials.append(DressTrial(problem, "plan", every, episodes))
        trials += [DressTrial(problem, question, PLANS, episodes, dress) for question, dress in dressers(problem)]
        trials += [DressTrial(problem, "decision", name, episodes, runs=runs) for name in deciding(problem)]
    return Study(
        name="dress-study",
        title="",
        trials=trials,
        run=find,
        seconds=seconds,
        decides=decides,
        files={f"{problem.name}.csv": "task,question,policy," for problem in asked.problems},
        publish=partial(write, episodes),
    )


def find(trial: DressTrial) -> dict[str, object]:
    """Return the finding of a trial."""
    problem, simulation, seeds = trial.problem, trial.problem.simulation(), episode_seeds("evaluation", trial.episodes)
    if isinstance(trial.what, str):
        policy = named_policy(trial.what, simulation)
        run = cached_evaluation(policy, problem, seeds, trial.runs)
        return asdict(finding(problem.name, simulation, "decision", policy, run))
    if trial.dress is not None:
        assert isinstance(simulation, BlockSimulation)
        simulation = type(simulation)(replace(simulation.task, dress=trial.dress), plants=simulation.plants)
    plan = best_plan(simulation, [interval for interval in trial.what if interval <= simulation.task.blocks])
    run = run_seeds(plan, simulation, seeds)
    return asdict(finding(problem.name, simulation, trial.question, plan, run, plan.every))


def seconds(trial: DressTrial) -> float:
    """Return the estimated CPU time of a trial, s; plans grind training episodes, too."""
    blocks = trial.episodes * trial.problem.simulation().task.blocks
    if isinstance(trial.what, str):
        return blocks * DECISION.get(trial.what, USUAL_DECISION)
    return 2 * blocks * len(trial.what) * PLANNED


def decides(trial: DressTrial) -> object:
    """Return the fingerprint of the policy that decides in a trial; False for a fixed plan."""
    what, problem = trial.what, trial.problem
    return isinstance(what, str) and code_of(named_policy(what, problem.simulation()), problem)


def deciding(problem: Problem) -> list[str]:
    """Return the policies that decide when to dress in a problem: scripted policies, planners, bundled agent."""
    simulation = problem.simulation()
    names, bundled = policy_names(simulation), usual_name(simulation)
    return [*(name for name in names if name not in BASELINES), *([bundled] if bundled != FALLBACK else [])]


def write(episodes: int, found: Mapping[DressTrial, Mapping[str, Any]], folder: Path) -> str:
    """Write the table and the picture of each problem."""
    for problem in dict.fromkeys(trial.problem for trial in found):
        findings = [DressFinding(**each) for trial, each in found.items() if trial.problem == problem]
        write_whole(folder / f"{problem.name}.csv", csv_text(findings, episode_seeds("evaluation", episodes)))
        write_figure(dress_figure(findings, problem.simulation().task.title), folder / f"{problem.name}.png")
    return f"tables and pictures: {folder}"

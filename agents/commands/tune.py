"""`python -m agents tune`."""

from pathlib import Path
from typing import Annotated

import typer

from agents.command_defaults import TUNING_EPISODES, TUNING_EVALUATIONS, TUNING_STARTS
from agents.commands.options import going_on
from agents.evaluation_cache import RUNS
from agents.study import Fresh, Jobs, Ray, Runs
from grind_env.file_arguments import Keeps
from grind_env.policies.problem_lookup import find_problem
from grind_env.policies.tuned_parameters import tuned_folder
from grind_env.policy_commands import JobFile, NamedProblem, Parts


def tuning(
    task: NamedProblem = "power_limited",
    job: JobFile = None,
    parts: Parts = 1,
    policies: Annotated[str | None, typer.Option(help="Names of policies, with commas between; default all.")] = None,
    evaluations: Annotated[int, typer.Option(min=1, help="Evaluations of each CMA-ES run.")] = TUNING_EVALUATIONS,
    starts: Annotated[int, typer.Option(min=1, help="CMA-ES runs of a policy.")] = TUNING_STARTS,
    episodes: Annotated[int, typer.Option(min=1, help="Episodes for training, and for validation.")] = TUNING_EPISODES,
    configs: Annotated[
        Path | None, typer.Option("--parameters", help="Folder of the tuned parameters."), Keeps()
    ] = None,
    runs: Runs = RUNS,
    fresh: Fresh = False,
    jobs: Jobs = 2,
    ray: Ray = None,
) -> None:
    """Tune scripted policies and store their parameters.

    To resume a killed run, repeat the command.
    """
    from agents.tuning.rule_tuning import tune

    problem = find_problem(task, job, parts)
    names = None if policies is None else [name.strip() for name in policies.split(",")]
    with going_on(fresh):
        tuned = tune(
            problem,
            names,
            evaluations=evaluations,
            starts=starts,
            episodes=episodes,
            folder=configs,
            runs=runs,
            fresh=fresh,
            jobs=jobs,
            ray=ray,
        )
    for name, entry in tuned.items():
        print(f"{name}: {entry.training_cost} $ an episode in training, {entry.validation_cost} $ in validation")
    print(f"parameters: {tuned_folder(problem.simulation().task, configs) / problem.name}.toml")

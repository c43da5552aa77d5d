"""`python -m agents clone`."""

from typing import Annotated

import typer

from grind_env.commands import Configs, JobFile, NamedProblem, Parts
from grind_env.errors import printable
from grind_env.policies.evaluation import episode_seeds
from grind_env.policies.judging import evaluate
from grind_env.policies.problem import find_problem


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command(epilog="Example: python -m agents clone --task power_limited --quality rule")(clone)


def clone(
    task: NamedProblem = "power_limited",
    job: JobFile = None,
    parts: Parts = 1,
    quality: Annotated[str, typer.Option(help="Of the dataset: novice, rule or planner.")] = "rule",
    epochs: Annotated[int, typer.Option(min=1, help="Passes over the dataset.")] = 60,
    seed: Annotated[int, typer.Option(min=0, help="Of the network.")] = 0,
    episodes: Annotated[int, typer.Option(min=2, help="Evaluation episodes.")] = 64,
    configs: Configs = None,
) -> None:
    """Clone a published dataset: fit a network to it, and judge it beside the policy that it is of.

    The dataset is that of `dataset --quality`, made where it is not there yet.
    """
    from agents.offline.cloning import clone as cloned
    from agents.offline.dataset import make_dataset, stored_episodes
    from agents.offline.qualities import EPISODES, SEEDS, policy_of

    problem = find_problem(task, job, parts)
    simulation = problem.simulation()
    taught = policy_of(quality, simulation, configs)
    data = stored_episodes(make_dataset(taught, problem, episode_seeds(SEEDS, EPISODES)))
    student = cloned(data, simulation, f"clone of {taught.name}", epochs=epochs, seed=seed)
    for policy in (taught, student):
        print(printable(str(evaluate(policy, problem, episodes=episodes))))

"""`python -m agents dataset`."""

from typing import Annotated

import typer

from grind_env.arguments import FILE
from grind_env.commands import Configs, JobFile, NamedProblem, Parts, Split
from grind_env.envs.splits import EVERY
from grind_env.errors import GrindError, printable, quoted
from grind_env.policies.evaluation import SEEDS, episode_seeds
from grind_env.policies.problem import find_problem


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command(epilog="Example: python -m agents dataset --task power_limited --quality planner")(dataset)


def dataset(
    task: NamedProblem = "power_limited",
    job: JobFile = None,
    parts: Parts = 1,
    policy: Annotated[
        str | None, typer.Option(help="A policy, the file of an agent, or a constant; by default adaptive_rule."), FILE
    ] = None,
    quality: Annotated[
        str | None,
        typer.Option(
            help="Instead: novice (random), rule (adaptive_rule) or planner (mpc, which sees the true state)."
        ),
    ] = None,
    episodes: Annotated[int, typer.Option(min=1, help="Number of episodes.")] = 200,
    seeds: Annotated[str, typer.Option(help=f"Seeds: {', '.join(SEEDS)}.")] = "training",
    split: Split = EVERY,
    trust: Annotated[
        bool, typer.Option("--trust", help="Load a .zip of Stable-Baselines3, which can run code of its author.")
    ] = False,
    configs: Configs = None,
    fresh: Annotated[bool, typer.Option("--fresh", help="Put it in place of a dataset of the same id.")] = False,
) -> None:
    """Record a policy as a Minari dataset, for offline reinforcement learning.

    The hash of its content is printed, and beside it whether it is that of the published one, where there is one.
    """
    import minari

    from agents.offline.dataset import PLACE, dataset_id, make_dataset, stored_episodes
    from agents.offline.qualities import content_hash, policy_of, verdict
    from grind_env.policies.naming import Unzip, chosen_policy

    problem = find_problem(task, job, parts)
    unzip: Unzip | None = None
    if trust:
        from grind_env.sb3 import load_zip

        unzip = load_zip
    if quality is not None and policy is not None:
        raise GrindError(f"policy is {quoted(policy)}, and the quality is {quoted(quality)}: give one of both")
    simulation = problem.simulation()
    if quality is not None:
        acts = policy_of(quality, simulation, configs)
    else:
        acts = chosen_policy(policy or "adaptive_rule", simulation, configs, unzip)
    path = make_dataset(acts, problem, episode_seeds(seeds, episodes), split, fresh=fresh)
    stored = minari.MinariDataset(path / "data")
    size = sum(each.stat().st_size for each in path.rglob("*") if each.is_file())
    what = f"{episodes} episodes, {seeds} seeds, split {split}, {stored.total_steps} steps, {size / 1e6:.1f} MB"
    print(printable(f"{dataset_id(problem, acts)}: {what}, in {path}"))
    print(verdict(problem.name, acts, content_hash(stored_episodes(stored)), episodes, seeds, split))
    print(f"load it with {PLACE}={path.parents[2]} and minari.load_dataset({dataset_id(problem, acts)!r})")

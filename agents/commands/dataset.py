"""`python -m agents dataset`."""

from pathlib import Path
from typing import Annotated

import typer

from grind_env.envs.tasks import load_task
from grind_env.policies.evaluation import SPLITS, episode_seeds
from grind_env.policies.tuned import CONFIGS


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command(epilog="Example: python -m agents dataset --task power_limited --policy adaptive_rule")(dataset)


def dataset(
    task: Annotated[str, typer.Option(help="Name of the task.")] = "power_limited",
    policy: Annotated[str, typer.Option(help="A policy, the file of an agent, or a constant.")] = "adaptive_rule",
    episodes: Annotated[int, typer.Option(min=1, help="Number of episodes.")] = 200,
    split: Annotated[str, typer.Option(help=f"Seeds: {', '.join(SPLITS)}.")] = "training",
    trust: Annotated[
        bool, typer.Option("--trust", help="Load a .zip of Stable-Baselines3, which can run code of its author.")
    ] = False,
    configs: Annotated[Path, typer.Option(help="Folder of the tuned parameters of the scripted policies.")] = CONFIGS,
    fresh: Annotated[bool, typer.Option("--fresh", help="Put it in place of a dataset of the same id.")] = False,
) -> None:
    """Record a policy as a Minari dataset, for offline reinforcement learning.

    Killed at any moment, the same command goes on; a dataset of the very same episodes stays as it is.
    """
    from agents.dataset_writer import PLACE
    from agents.datasets import dataset_id, datasets_folder, make_dataset
    from grind_env.policies.naming import Unzip, chosen_policy

    job = load_task(task)
    unzip: Unzip | None = None
    if trust:
        from grind_env.sb3 import load_zip

        unzip = load_zip
    acts = chosen_policy(policy, job, configs, unzip)
    path = make_dataset(acts, job, episode_seeds(split, episodes), fresh=fresh)
    size = sum(each.stat().st_size for each in path.rglob("*") if each.is_file())
    print(f"{dataset_id(job, acts)}: {episodes * job.blocks} steps, {size / 1e6:.1f} MB, in {path}")
    print(f"load it with {PLACE}={datasets_folder()} and minari.load_dataset({dataset_id(job, acts)!r})")

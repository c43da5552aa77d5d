"""`python -m agents play`."""

from pathlib import Path
from typing import Annotated

import typer

from grind_env.envs.tasks import load_task
from grind_env.files import write_atomically
from grind_env.policies.evaluation import SPLITS
from grind_env.policies.tuned import CONFIGS


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command(epilog="Example: python -m agents play power_limited --policy adaptive_rule --output played.gif")(play)


def play(
    task: Annotated[str, typer.Argument(help="Name of the task.")] = "power_limited",
    policy: Annotated[
        str | None,
        typer.Option(help="A policy, the file of a trained agent, or a constant: E8D0; by default the shipped one."),
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the episode.")] = SPLITS["evaluation"],
    output: Annotated[Path | None, typer.Option(help="Write the episode to this .gif file instead.")] = None,
    program: Annotated[
        Path | None, typer.Option(help="Write the part program to this .nc file instead of showing both.")
    ] = None,
    window: Annotated[
        bool, typer.Option(help="A window where there is a screen; without, text in the terminal.")
    ] = True,
    trust: Annotated[
        bool, typer.Option("--trust", help="Load a .zip of Stable-Baselines3, which can run code of its author.")
    ] = False,
    configs: Annotated[Path, typer.Option(help="Folder of the tuned parameters of the scripted policies.")] = CONFIGS,
) -> None:
    """Show an episode, what it cost, and the part program that the policy wrote."""
    from agents.video import record
    from grind_env.policies.naming import Unzip, chosen_policy
    from grind_env.policies.play import play as play_episode

    job = load_task(task)
    unzip: Unzip | None = None
    if trust:
        from grind_env.sb3 import load_zip

        unzip = load_zip
    plays = chosen_policy(policy, job, configs, unzip)
    if output is not None:
        record([plays], job, seed, output)
        print(f"{output}: {output.stat().st_size / 1e6:.1f} MB")
    shown = None if output is not None or program is not None else "human" if window else "ansi"
    played = play_episode(plays, job, seed, shown)
    if program is None:
        print(played.program)
    else:
        write_atomically(program, lambda path: path.write_text(played.program, encoding="utf-8"))
    print(
        f"{plays.name}, seed {seed}: {played.cost:.2f} $ for {played.good:.1f} good parts of {played.finished},"
        f" {played.cost / played.good:.3f} $ each; {played.dresses} dress executions,"
        f" {played.seconds / 3600.0:.2f} h on the machine"
    )

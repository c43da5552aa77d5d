"""`python -m agents train`."""

from math import isfinite
from pathlib import Path
from typing import Annotated

import typer

from agents.cells import RUNS
from agents.commands.interrupted import going_on
from agents.commands.options import Ray
from agents.learning.curve import SPENT, curve_path, read_curve, seconds_to
from agents.learning.settings import DEFAULTS, LAST_SEED, settings_of
from grind_env.arguments import Keeps
from grind_env.commands import JobFile, NamedProblem, Parts, Plant
from grind_env.errors import GrindError, printable
from grind_env.files import write_atomically
from grind_env.policies.held import training_machines
from grind_env.policies.problem import find_problem
from grind_env.targets import check_own
from grind_env.terminal import table_console


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command(epilog="Example: python -m agents train --task power_limited --kind ppo --seed 0")(train)


def train(
    task: NamedProblem = "power_limited",
    job: JobFile = None,
    parts: Parts = 1,
    plant: Plant = None,
    kind: Annotated[str, typer.Option(help=f"Kind of agent: {', '.join(DEFAULTS)}.")] = "ppo",
    seed: Annotated[
        int, typer.Option(min=0, max=LAST_SEED, help="Seed of the agent and of its training episodes.")
    ] = 0,
    steps: Annotated[
        int | None, typer.Option(min=1, help="Environment steps, in whole rollouts; by default those of the kind.")
    ] = None,
    split: Annotated[
        str | None,
        typer.Option(help="Contexts of the training, as of evaluate; by default inner."),
    ] = None,
    runs: Annotated[Path, typer.Option(help="Folder of the results."), Keeps()] = RUNS,
    fresh: Annotated[bool, typer.Option("--fresh", help="Train anew, from the first step.")] = False,
    compare: Annotated[
        bool,
        typer.Option("--compare-batches", help="Train PPO with the batches of Stable-Baselines3, too; draw both."),
    ] = False,
    ray: Ray = None,
) -> None:
    """Train an agent.

    On machines that are not the model, such as `--plant public`, its memory holds the model, and it has no score. An
    agent already trained by the same code, settings and seed is kept, and a training that was interrupted goes on.
    """
    # torch takes seconds to load
    from agents.learning.batches import PICTURE, compare_batches
    from agents.learning.cells import Cell, Request, train_away
    from agents.learning.train import trained_agent
    from agents.pool import work_on_all

    problem = training_machines(find_problem(task, job, parts), plant)
    settings = settings_of(problem, "ppo" if compare else kind, steps, split)
    contexts = settings.split
    if compare and ray is not None:
        raise GrindError(
            "--ray trains one agent, and --compare-batches trains two to be compared: leave one of them out"
        )
    with going_on(fresh, "from the last checkpoint"):
        if compare:
            picture = runs / problem.name / "batches.png"
            check_own(picture, PICTURE, "--runs")
            image = compare_batches(problem, seed, steps, runs, fresh, split)
            write_atomically(picture, lambda unfinished: unfinished.write_bytes(image))
            print(printable(f"learning curves, trained on split {contexts}: {picture}"))
            return
        if ray is None:
            path = trained_agent(problem, kind, seed, steps, runs, fresh, split=split)
        else:
            request = Request(steps=settings.steps, split=split, runs=runs, fresh=fresh)
            found, failed = work_on_all([Cell(problem, kind, seed)], request, 1, table_console(), train_away, ray)
            if failed:
                raise typer.Exit(1)
            path = runs / found[0]
    points = read_curve(curve_path(path))
    last = points[-1]
    print(
        f"validation cost {last.cost:.2f} $ an episode after {last.steps} steps and {last.seconds:.0f} s"
        + (f"; score {last.score:.1f}, 95 % of it from {seconds_to(points):.0f} s on" if isfinite(last.score) else "")
    )
    print("time: " + ", ".join(f"{100.0 * getattr(last, name) / last.seconds:.0f} % {name}" for name in SPENT))
    print(printable(f"agent trained on split {contexts}: {path}"))

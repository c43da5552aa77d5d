"""`python -m agents track`."""

from typing import Annotated

import typer

from agents.benchmark.plan import chosen_problems
from agents.budgets import TRACK_EPISODES
from agents.cells import RESULTS, RUNS
from agents.commands.interrupted import going_on
from agents.commands.options import Tasks
from agents.study import Fresh, Jobs, Options, Ray, Results, Runs
from grind_env.arguments import FILE
from grind_env.commands import JobFile, Parts
from grind_env.terminal import table_console


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command(epilog="Example: python -m agents track --machines public:1 --adapters bc --blocks 0,60 --seeds 1")(
        track
    )


def track(
    tasks: Tasks = None,
    job: JobFile = None,
    parts: Parts = 1,
    machines: Annotated[
        list[str] | None,
        typer.Option("--machines", help="Their number, of held-out:1 on, or a name; may be repeated; 20 by default."),
    ] = None,
    adapters: Annotated[
        list[str] | None,
        typer.Option(
            "--adapters",
            help="Name, policy, file or module:name of your own; may be repeated; the headline by default.",
        ),
        FILE,
    ] = None,
    blocks: Annotated[
        str | None, typer.Option(help="Blocks on a machine when it is judged, whole shifts; 0,60,300,1200 by default.")
    ] = None,
    episodes: Annotated[int, typer.Option(min=2, help="Evaluation episodes.")] = TRACK_EPISODES,
    seeds: Annotated[int, typer.Option(min=1, help="Runs of each adapter on each machine.")] = 3,
    wide: Annotated[bool, typer.Option("--wide", help="More adapters, and WideRails, too, on 8 machines.")] = False,
    jobs: Jobs = 2,
    ray: Ray = None,
    runs: Runs = RUNS,
    results: Results = None,
    fresh: Fresh = False,
) -> None:
    """How fast, how safely and how well policies adapt to machines that are not the model, from measurements alone.

    An adapter grinds shift after shift on a machine that is held out, is told what was measured, and may change its
    policy after each. What the machine remembers goes from one to the next; on the way episodes judge it.
    """
    from agents.track.study import asked_for, tunings
    from agents.track.study import track as study

    folder = results or (runs if tasks or machines or adapters or blocks else RESULTS)
    problems = chosen_problems(tasks, job, parts) if tasks else []
    options = Options(jobs=jobs, ray=ray, runs=runs, fresh=fresh, console=table_console())
    cells = asked_for(problems, machines or [], adapters or [], blocks, seeds, episodes, wide=wide)
    with going_on(fresh):
        before = tunings(cells)
        before.check(folder)
        study(cells, before.found(options)).publish_to(folder, options)

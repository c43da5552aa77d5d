"""The commands `grind figure ...`."""

from pathlib import Path
from typing import Annotated

import typer

from grind_env.arguments import FILE, Application, Writes
from grind_env.commands import JobFile as ProblemJob
from grind_env.commands import NamedProblem, Parts
from grind_env.shop.commands.arguments import JobFile, ProgramFile

app = Application(
    no_args_is_help=True,
    rich_markup_mode=None,
    help="Figures for papers: vector formats, as wide as a column or a page, readable in grey.",
)

Output = Annotated[Path, typer.Option("--output", "-o", help="The .pdf, .svg or .png file."), Writes()]


@app.command(epilog="Example: grind figure cycle plate.nc -o cycle.pdf")
def cycle(program: ProgramFile, output: Output, job: JobFile = None) -> None:
    """The strokes of a program: depth, power, heat, wheel, roughness and size, 170 mm wide."""
    from grind_env.figures.cycle import cycle_figure
    from grind_env.machine.grind_file import grind_file
    from grind_env.render.figures import prepare_figure, write_figure

    prepare_figure(output)
    write_figure(cycle_figure(grind_file(program, job)), output)


@app.command(epilog="Example: grind figure wheel plate.nc --parts 30 -o wheel.pdf")
def wheel(
    program: ProgramFile,
    output: Output,
    job: JobFile = None,
    parts: Annotated[int, typer.Option(min=1, max=1000, help="Runs of the program; the wheel carries over.")] = 30,
) -> None:
    """The state of the wheel over a batch of parts, 85 mm wide.

    Wear flats and loading over the volume ground since the dress, all intervals from dress to dress upon one another,
    and diameter lost over the parts.
    """
    from grind_env.control import read_file
    from grind_env.envs.job.text import repeated
    from grind_env.figures.wheel import wheel_figure
    from grind_env.machine.grind_file import grind_file
    from grind_env.machine.job.file import job_beside
    from grind_env.render.figures import prepare_figure, write_figure

    prepare_figure(output)
    batch = repeated(read_file(program), parts)
    write_figure(wheel_figure(grind_file(batch, job_beside(program) if job is None else job)), output)


@app.command(epilog="Example: grind figure interval plate.nc --dress-every 1..30 -o interval.pdf")
def interval(
    program: ProgramFile,
    output: Output,
    job: JobFile = None,
    speed: Annotated[
        str | None, typer.Option("--E", help="As 8000..24000, mm/min, of the first block; as it is if not given.")
    ] = None,
    every: Annotated[str, typer.Option("--dress-every", help="Parts from dress to dress.")] = "1..20",
    parts: Annotated[int, typer.Option(min=1, max=1000, help="Runs of the program in a batch.")] = 50,
    seed: Annotated[int, typer.Option(min=0, help="Of the lots.")] = 1,
) -> None:
    """What a part costs over the dress interval, as `grind sweep` finds it, 85 mm wide."""
    from grind_env.figures.interval import interval_figure
    from grind_env.render.figures import prepare_figure, write_figure
    from grind_env.shop import calls
    from grind_env.shop.commands import texts

    prepare_figure(output)
    intervals = texts.ends("--dress-every", "intervals", every)
    speeds = None if speed is None else texts.ends("--E", "E", speed)
    found = calls.sweep(program, job, E=speeds, dress_every=intervals, parts=parts, seed=seed)
    write_figure(interval_figure(found), output)


@app.command(epilog="Example: grind figure dress --env power_limited --E 7 --every 10 -o dress.pdf")
def dress(
    output: Output,
    env: NamedProblem = "power_limited",
    job: ProblemJob = None,
    parts: Parts = 1,
    speed: Annotated[float, typer.Option("--E", help="Table speed, m/min.")] = 7.0,
    every: Annotated[int, typer.Option(min=1, help="Blocks from dress to dress.")] = 10,
) -> None:
    """What a dress changes: the last part on a dull wheel, and the next one after the dress, 170 mm wide."""
    from grind_env.figures.dress import dress_figure, dressed_run
    from grind_env.policies.problem import find_problem
    from grind_env.render.figures import prepare_figure, write_figure

    prepare_figure(output)
    write_figure(dress_figure(dressed_run(find_problem(env, job, parts), speed, every)), output)


@app.command(epilog="Example: grind figure policy-map --env power_limited -o map.pdf")
def policy_map(
    output: Output,
    env: NamedProblem = "power_limited",
    policy: Annotated[
        str | None, typer.Option(help="The .safetensors file of a trained agent; by default the shipped one."), FILE
    ] = None,
    episodes: Annotated[int, typer.Option(min=1, help="In which the agent is watched.")] = 32,
) -> None:
    """E and D of a learned agent over what it believes of the wheel, with states that it got into, 170 mm wide.

    The axes are the believed wear-flat area and the believed factor on its growth; whatever else the agent sees is what
    goes with these two on average (linear regression over the states of the episodes).
    """
    from grind_env.figures.policy_map import policy_map as ask
    from grind_env.figures.policy_map import policy_map_figure
    from grind_env.render.figures import prepare_figure, write_figure

    prepare_figure(output)
    write_figure(policy_map_figure(ask(policy, env, episodes=episodes)), output)

"""The commands `grind figure ...`."""

from pathlib import Path
from typing import Annotated

import typer

from grind_env.arguments import FILE, Application, Writes
from grind_env.commands import JobFile as ProblemJob
from grind_env.commands import NamedProblem, Parts

app = Application(
    no_args_is_help=True,
    rich_markup_mode=None,
    help="Figures for papers: vector formats, as wide as a column or a page, readable in grey.",
)

Output = Annotated[Path, typer.Option("--output", "-o", help="The .pdf, .svg or .png file."), Writes()]


@app.command(epilog="grind figure dress --env power_limited --E 7 --every 10 -o dress.pdf")
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


@app.command(epilog="grind figure policy-map --env power_limited -o map.pdf")
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

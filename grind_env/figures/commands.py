"""The commands `grind figure ...`."""

from pathlib import Path
from typing import Annotated

import typer

from grind_env.file_arguments import Application, Writes
from grind_env.policy_commands import JobFile as ProblemJob
from grind_env.policy_commands import NamedProblem, Parts

app = Application(no_args_is_help=True, help="Draw figures for papers, as vector graphics of page width.")


@app.command(
    epilog="grind figure dress -o dress.pdf\ngrind figure dress --task rush --E 12000 --dress-every 5 -o rush.svg"
)
def dress(
    output: Annotated[Path, typer.Option("--output", "-o", help="The .pdf, .svg or .png file."), Writes()],
    env: NamedProblem = "power_limited",
    job: ProblemJob = None,
    parts: Parts = 1,
    speed: Annotated[float, typer.Option("--E", help="E, mm/min.")] = 7000.0,
    dress_every: Annotated[int, typer.Option(min=1, help="Blocks from dress to dress.")] = 10,
) -> None:
    """Draw the last part before a dress and the first after it."""
    from grind_env.figures.dress_effect import dress_figure, dressed_run
    from grind_env.policies.problem_lookup import find_problem
    from grind_env.render.figures import prepare_figure, write_figure

    prepare_figure(output)
    write_figure(dress_figure(dressed_run(find_problem(env, job, parts), speed, dress_every)), output)

"""`python -m agents figure`."""

from pathlib import Path
from typing import Annotated

import typer

from grind_env.arguments import CURVE, Application, Writes
from grind_env.render.figures import prepare_figure, write_figure

figures = Application(
    no_args_is_help=True,
    rich_markup_mode=None,
    help="Figures for papers: vector formats, as wide as a column, readable in grey.",
)


def register(app: typer.Typer) -> None:
    """Add the commands to the application."""
    app.add_typer(figures, name="figure")


@figures.callback()
def callback() -> None:
    """Let the only command keep its name."""


@figures.command(epilog="Example: python -m agents figure learning-curves runs/power_limited/ppo-*.csv -o curves.pdf")
def learning_curves(
    curves: Annotated[list[Path], typer.Argument(help="Agents (.safetensors), or the .csv files beside them."), CURVE],
    output: Annotated[Path, typer.Option("--output", "-o", help="The .pdf, .svg or .png file."), Writes()],
) -> None:
    """Validation score over environment steps, a line for each training: 0 is the best fixed plan, 100 the planner."""
    from agents.learning.figure import curves_figure, read_curves

    prepare_figure(output)
    write_figure(curves_figure(read_curves(curves)), output)

"""The command `python -m agents`."""

import sys

import typer

from agents.commands import benchmark, dataset, dress_study, evaluate, play, scores, train, tune, video
from grind_env.errors import GrindError

BAD_INPUT = 2

app = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    help="Tune, train, evaluate and compare policies on the tasks of grind_env.",
)

for command in (tune, train, evaluate, benchmark, scores, dress_study, play, video, dataset):
    command.register(app)


def main() -> None:
    """Run the command; a user's mistake, or a file that cannot be written, is one sentence and exit status 2."""
    try:
        app(prog_name="python -m agents")
    except (GrindError, OSError) as error:
        print(f"agents: {error}", file=sys.stderr)
        sys.exit(BAD_INPUT)


if __name__ == "__main__":
    main()

"""The commands of `python -m agents` as one application."""

from agents.commands import benchmark, dataset, studies, tune, video
from grind_env.arguments import Application

app = Application(
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    help="Tune, train and compare policies in the environments of grind_env, from a checkout.",
)

for command in (tune, studies, benchmark, video, dataset):
    command.register(app)

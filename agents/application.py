"""The commands of `python -m agents` as one application."""

from typing import ClassVar

from agents.commands import benchmark, dataset, studies, tune, video
from grind_env.arguments import Application
from grind_env.command_help import HelpfulGroup


class AgentCommands(HelpfulGroup):
    """The commands of `python -m agents` in groups."""

    groups: ClassVar = {
        "Train and compare": "tune benchmark dataset video",
        "Studies": "scores gaps splits recipe safety dress-study intervals plants track replicate",
    }


app = Application(
    cls=AgentCommands, no_args_is_help=True, help="Tune, train and compare policies, and run the published studies."
)

for command in (tune, studies, benchmark, video, dataset):
    command.register(app)

"""The commands of `python -m agents` as one application."""

from collections.abc import Callable
from typing import ClassVar

from agents.commands import studies
from agents.commands.benchmark import benchmark
from agents.commands.dataset import dataset
from agents.commands.tune import tuning
from agents.commands.video import video
from grind_env.command_help import HelpfulGroup
from grind_env.file_arguments import Application


class AgentCommands(HelpfulGroup):
    """The commands of `python -m agents` in groups."""

    groups: ClassVar = {
        "Train and compare": "tune benchmark dataset video",
        "Studies": "scores gaps splits recipe safety dress-study intervals plants track replicate",
    }


app = Application(
    cls=AgentCommands, no_args_is_help=True, help="Tune, train and compare policies, and run the published studies."
)
#: commands other than the studies, each with the options of two examples
EXAMPLES: dict[str, tuple[Callable[..., None], str, str]] = {
    "tune": (tuning, "--task rush", "--task rush --policies belief_rule,look_ahead"),
    "benchmark": (benchmark, "", "--tasks core --kinds ppo,plain_gru@3M --seeds 3"),
    "video": (video, "--left adaptive_rule --output one.gif", "--left adaptive_rule --right E8000D0 --output two.gif"),
    "dataset": (dataset, "--task rush", "--policy adaptive_rule --episodes 50"),
}

for name, (function, *examples) in EXAMPLES.items():
    epilog = "\n".join(f"python -m agents {name} {options}".rstrip() for options in examples)
    app.command(name=name, epilog=epilog)(function)
studies.register(app)

"""The commands of `python -m agents` as one application."""

from agents.commands import (
    benchmark,
    dataset,
    dress_study,
    figure,
    gaps,
    plants,
    recipe,
    scores,
    track,
    train,
    tune,
    video,
)
from grind_env.arguments import Application

app = Application(
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    help="Tune, train and compare policies in the environments of grind_env.",
)

for command in (tune, train, recipe, benchmark, scores, gaps, dress_study, plants, track, figure, video, dataset):
    command.register(app)

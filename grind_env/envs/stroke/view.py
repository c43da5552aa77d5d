"""The view of an episode of `grind/Stroke-v0`, stroke by stroke."""

from collections.abc import Callable, Sequence
from dataclasses import replace

from grind_env.envs.blocks.tables import Outcome
from grind_env.envs.blocks.tape import TapeRow
from grind_env.envs.simulation import Episodes
from grind_env.envs.stroke.program import StrokeBlock
from grind_env.envs.tasks import Task
from grind_env.envs.view import view_of
from grind_env.process.cost import NO_LIMIT
from grind_env.render.view import GroundBlock, View

STOCK = TapeRow._fields.index("stock")


def stroke_view(
    task: Task,
    episodes: Episodes,
    i: int,
    blocks: Sequence[StrokeBlock],
    outcomes: Sequence[Outcome],
    text: Callable[[Task, StrokeBlock], str],
) -> View:
    """Episode i as it stands, at rest between two strokes; arguments as for `view_of`.

    A plunge too hot counts as a burn even if the strokes after it grind it off. Size and roughness count when the
    part is finished.
    """
    view = view_of(task, episodes, i, blocks, outcomes, text)
    strokes = sum(task.strokes(task.kinds[0], stock) for stock in episodes.tape[i, :, STOCK].tolist())
    return replace(
        view,
        extent=replace(view.extent, blocks=strokes),
        ground=tuple(each if each.finished else _in_work(each) for each in view.ground),
    )


def _in_work(ground: GroundBlock) -> GroundBlock:
    return replace(ground, limits=ground.limits._replace(roughness=NO_LIMIT, size=NO_LIMIT))

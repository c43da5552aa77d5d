"""The view of an episode of `grind/Stroke-v0`, stroke by stroke."""

from dataclasses import replace

from grind_env.process.cost import NO_LIMIT
from grind_env.render.view import GroundBlock, View


def in_strokes(view: View, strokes: int) -> View:
    """A view as it stands between two of that many strokes.

    A plunge too hot counts as a burn even if the strokes after it grind it off. Size and roughness count when the
    part is finished.
    """
    return replace(
        view,
        extent=replace(view.extent, blocks=strokes),
        ground=tuple(each if each.finished else _in_work(each) for each in view.ground),
    )


def _in_work(ground: GroundBlock) -> GroundBlock:
    return replace(ground, limits=ground.limits._replace(roughness=NO_LIMIT, size=NO_LIMIT))

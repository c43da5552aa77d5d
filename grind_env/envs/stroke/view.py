"""The view of an episode of `grind/Stroke-v0`, stroke by stroke."""

from collections.abc import Sequence
from dataclasses import replace

from grind_env.envs.stroke.episode import StrokeEpisode, StrokeRun
from grind_env.envs.view import extent_of, part_on_machine
from grind_env.machine.part import PartRun
from grind_env.process.cost import NO_LIMIT, Limits
from grind_env.render.view import GroundBlock, View


def block_of_stroke(run: StrokeRun, speed: float, dress: bool, part: PartRun, limits: Limits) -> GroundBlock:
    """A stroke at E `speed` (mm/min), after a dress or not, on a part.

    A plunge too hot counts as a burn even if the strokes after it grind it off. Size and roughness count when the
    part is finished.
    """
    finished = run.finished
    return GroundBlock(
        speed=speed,
        executions=int(dress),
        power=run.stroke.power,
        rise=run.stroke.T if finished is None else float(finished["rise"]),
        roughness=run.stroke.Ra,
        size_error=1000.0 * part.left,
        limits=limits._replace(roughness=NO_LIMIT, size=NO_LIMIT) if finished is None else limits,
        cost=sum(run.costs.values()),
        finished=finished is not None,
        good=0.0 if finished is None else float(finished["survival"]),
    )


def stroke_view(episode: StrokeEpisode, ground: Sequence[GroundBlock], part: PartRun, text: str) -> View:
    """An episode as it stands, at rest between two strokes.

    Args:
        episode: the episode.
        ground: the strokes that it has made.
        part: the one last ground.
        text: what the control has read for the last stroke.
    """
    return View(
        extent=replace(extent_of(episode.task), blocks=episode.all_strokes),
        ground=tuple(ground),
        wheel=episode.wheel,
        part=part_on_machine(part, episode.task.kinds[0].name),
        text=text,
    )

"""The views of the environments that step a part program block by block or stroke by stroke."""

from collections.abc import Sequence

from grind_env.envs.job_outline import Choice, Outline
from grind_env.envs.program_episode import BlockRun, ProgramEpisode
from grind_env.envs.stroke_episode import StrokeEpisode, StrokeRun
from grind_env.envs.view import STOCK_ROOM, job_of
from grind_env.machine.part import PartRun
from grind_env.process.cost import NO_LIMIT, Limits
from grind_env.process.state import WheelState
from grind_env.render.view import GroundBlock, Job, View, Workpiece


def block_of_run(run: BlockRun, choice: Choice, part: PartRun, limits: Limits, cost: float) -> GroundBlock:
    """A cycle block of a program.

    Args:
        run: what came of it.
        choice: E and D.
        part: on the machine after it.
        limits: of the part; size and roughness count when it is finished.
        cost: $.
    """
    finished, strokes = run.finished, run.strokes
    plunges = strokes["T"][run.increments > 0.0]
    return GroundBlock(
        speed=choice.speed,
        executions=choice.executions,
        power=float(strokes["power"].max(initial=0.0)),
        rise=float(finished["rise"][-1] if finished.size else plunges.max(initial=0.0)),
        roughness=float(strokes["Ra"][-1]) if strokes.size else 0.0,
        size_error=float(finished["worst_error"][-1]) if finished.size else 1000.0 * part.left,
        limits=limits if finished.size else limits._replace(roughness=NO_LIMIT, size=NO_LIMIT),
        cost=cost,
        finished=bool(finished.size),
        good=float(finished["survival"].sum()),
    )


def program_view(
    outline: Outline, episode: ProgramEpisode, ground: Sequence[GroundBlock], text: str, speeds: tuple[float, float]
) -> View:
    """An episode of a user's program as it stands, at rest between two blocks.

    Args:
        outline: of the program.
        episode: the episode.
        ground: the blocks that it has run.
        text: the last of them.
        speeds: lowest and highest E, mm/min.
    """
    part, wheel = episode.run.part, episode.run.wheel
    blocks = len(outline.blocks)
    return View(
        job=Job(
            title=outline.programs.name,
            blocks=blocks,
            parts=outline.parts,
            new_diameter=outline.job.setup.wheel.diameter,
            lowest_speed=speeds[0],
            highest_speed=speeds[1],
            most_executions=max((block.executions for block in ground), default=1) or 1,
            longest=part.job.part.length,
            thickest=STOCK_ROOM * part.job.part.stock,
        ),
        ground=tuple(ground),
        wheel=outline.wheel if wheel is None else wheel,
        part=_workpiece(part, f"part {part.number}"),
        text=text,
    )


def block_of_stroke(run: StrokeRun, speed: float, dress: bool, part: PartRun, limits: Limits) -> GroundBlock:
    """A stroke at E `speed` (mm/min), after a dress or not, on a part; arguments as for `block_of_run`.

    A plunge too hot counts as a burn even if the strokes after it grind it off.
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
    """An episode of strokes as it stands, at rest between two of them; arguments as for `program_view`.

    `part` is the one last ground.
    """
    job, kind = job_of(episode.task), episode.task.kinds[0]
    frame = Job(
        title=job.title,
        blocks=episode.all_strokes,
        parts=job.parts,
        new_diameter=job.new_diameter,
        lowest_speed=job.lowest_speed,
        highest_speed=job.highest_speed,
        most_executions=1,
        longest=job.longest,
        thickest=job.thickest,
    )
    wheel: WheelState = episode.wheel
    return View(job=frame, ground=tuple(ground), wheel=wheel, part=_workpiece(part, kind.name), text=text)


def _workpiece(part: PartRun, name: str) -> Workpiece:
    return Workpiece(name=name, length=part.job.part.length, stock=part.stock, left=part.left)

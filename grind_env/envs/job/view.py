"""The view of an episode of `grind/Job-v0`: a user's program, block by block."""

from collections.abc import Sequence

from grind_env.envs.job.outline import Choice, Outline
from grind_env.envs.program_episode import BlockRun, ProgramEpisode
from grind_env.envs.view import STOCK_ROOM, part_on_machine
from grind_env.machine.part import PartRun
from grind_env.process.cost import NO_LIMIT, Limits
from grind_env.render.view import Extent, GroundBlock, View


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


def job_view(
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
        extent=Extent(
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
        part=part_on_machine(part, f"part {part.number}"),
        text=text,
    )

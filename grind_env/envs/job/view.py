"""The view of an episode of `grind/Job-v0`: a user's program, block by block."""

from collections.abc import Sequence
from typing import NamedTuple

from grind_env.envs.cost import Outcome
from grind_env.envs.episodes import Episodes
from grind_env.envs.job.outline import BlockOutline, parts_of
from grind_env.envs.job.readings import ACTION
from grind_env.envs.tape import TapeRow
from grind_env.envs.view import STOCK_ROOM, ground_block
from grind_env.machine.job import Job
from grind_env.machine.loops.cycle import PartState
from grind_env.process.cost import NO_LIMIT
from grind_env.render.view import EpisodePicture, Extent, GroundBlock, Workpiece

STOCK = TapeRow._fields.index("stock")


class RunBlock(NamedTuple):
    """A cycle block with what was chosen for it."""

    number: int
    """Of the block, from 0."""
    speed: float
    """E, mm/min."""
    executions: int
    """D."""
    own: tuple[float, ...]
    """What process and gauge remembered besides the wheel as it began."""


def job_view(
    name: str,
    job: Job,
    outlines: Sequence[BlockOutline],
    episodes: Episodes,
    i: int,
    blocks: Sequence[RunBlock],
    outcomes: Sequence[Outcome],
    text: str,
) -> EpisodePicture:
    """Episode i of a user's program as it stands, at rest between two blocks."""
    number = min(int(episodes.block[i]), len(outlines) - 1)
    coming = outlines[number]
    loads = coming.starts_part and (not blocks or blocks[-1].number != number)
    stock = float(episodes.tape[i, number if loads else max(number - 1, 0), STOCK])
    part = PartState(*episodes.parts[i].tolist())
    shown = coming.part if loads or not blocks else outlines[blocks[-1].number].part
    lowest, highest = ACTION.speed_ends
    parts = [each.part for each in job.met] or [job.part]
    name_of = job.station_of(shown + 1)
    return EpisodePicture(
        extent=Extent(
            title=name,
            blocks=len(outlines),
            parts=parts_of(outlines),
            new_diameter=job.setup.wheel.diameter,
            lowest_speed=1000.0 * lowest,
            highest_speed=1000.0 * highest,
            most_executions=max((block.executions for block in blocks), default=1) or 1,
            longest=max(each.length for each in parts),
            thickest=STOCK_ROOM * max(each.stock for each in parts),
        ),
        ground=tuple(
            _ground(job.of_part(outlines[each[0].number].part + 1), *each)
            for each in zip(blocks, outcomes, strict=True)
        ),
        wheel=episodes.wheel(i),
        part=Workpiece(
            name=f"part {shown + 1}{f' ({name_of})' if name_of else ''}",
            length=job.of_part(shown + 1).part.length,
            stock=stock,
            left=stock if not blocks else stock - part.S,
        ),
        text=text,
    )


def _ground(job: Job, block: RunBlock, outcome: Outcome) -> GroundBlock:
    # size and roughness count when the part is finished
    limits = job.limits if outcome.finished > 0.0 else job.limits._replace(roughness=NO_LIMIT, size=NO_LIMIT)
    return ground_block(block, outcome, limits)

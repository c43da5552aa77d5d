"""The view of an episode of `grind/Job-v0`: a user's program, block by block."""

from collections.abc import Sequence
from typing import NamedTuple

from grind_env.envs.blocks.tables import Outcome
from grind_env.envs.blocks.tape import TapeRow
from grind_env.envs.job.simulation import JobSimulation
from grind_env.envs.simulation import Episodes
from grind_env.envs.view import STOCK_ROOM
from grind_env.machine.cycle import PartState
from grind_env.process.cost import NO_LIMIT
from grind_env.process.state import WheelState
from grind_env.render.view import Extent, GroundBlock, View, Workpiece

STOCK = TapeRow._fields.index("stock")


class RunBlock(NamedTuple):
    """A cycle block with what was chosen for it."""

    number: int
    """Of the block, from 0."""
    speed: float
    """E, mm/min."""
    executions: int
    """D."""


def job_view(
    simulation: JobSimulation,
    episodes: Episodes,
    i: int,
    blocks: Sequence[RunBlock],
    outcomes: Sequence[Outcome],
    speeds: tuple[float, float],
) -> View:
    """Episode i of a user's program as it stands, at rest between two blocks.

    Args:
        simulation: of the program.
        episodes: its episodes.
        i: which of them.
        blocks: those that it has run.
        outcomes: what came of each.
        speeds: lowest and highest E, mm/min.
    """
    job, number = simulation.job, min(int(episodes.block[i]), len(simulation.blocks) - 1)
    coming = simulation.blocks[number]
    loads = coming.starts_part and (not blocks or blocks[-1].number != number)
    stock = float(episodes.tape[i, number if loads else max(number - 1, 0), STOCK])
    part = PartState(*episodes.parts[i].tolist())
    shown = coming.part if loads or not blocks else simulation.blocks[blocks[-1].number].part
    return View(
        extent=Extent(
            title=simulation.programs.name,
            blocks=len(simulation.blocks),
            parts=simulation.parts,
            new_diameter=job.setup.wheel.diameter,
            lowest_speed=speeds[0],
            highest_speed=speeds[1],
            most_executions=max((block.executions for block in blocks), default=1) or 1,
            longest=job.part.length,
            thickest=STOCK_ROOM * job.part.stock,
        ),
        ground=tuple(_ground(simulation, *each) for each in zip(blocks, outcomes, strict=True)),
        wheel=WheelState(*episodes.wheels[i].tolist()),
        part=Workpiece(
            name=f"part {shown + 1}",
            length=job.part.length,
            stock=stock,
            left=stock if not blocks else stock - part.S,
        ),
        text=text_of(simulation, blocks[-1]) if blocks else "",
    )


def text_of(simulation: JobSimulation, block: RunBlock) -> str:
    """What the control reads for a block."""
    return simulation.text(block.number, block.speed, block.executions)


def _ground(simulation: JobSimulation, block: RunBlock, outcome: Outcome) -> GroundBlock:
    finished, limits = outcome.finished > 0.0, simulation.job.limits
    return GroundBlock(
        speed=block.speed,
        executions=block.executions,
        power=outcome.peak_power,
        torque=outcome.peak_torque,
        rise=outcome.rise,
        roughness=outcome.roughness,
        size_error=outcome.size_error,
        # size and roughness count when the part is finished
        limits=limits if finished else limits._replace(roughness=NO_LIMIT, size=NO_LIMIT),
        cost=outcome.cost,
        finished=finished,
        good=outcome.good,
    )

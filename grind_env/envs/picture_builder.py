"""The picture of a running episode as data: an `EpisodePicture` from a task or job and its finished blocks."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from grind_env.envs.cost import Outcome
from grind_env.envs.episode_state import Episodes
from grind_env.envs.noise_tape import TapeRow
from grind_env.envs.tasks import Task
from grind_env.machine.job import Job
from grind_env.machine.loops.cycle import PartState
from grind_env.process.cost import NO_LIMIT, Limits
from grind_env.render.picture_data import EpisodePicture, Extent, GroundBlock, Workpiece

STOCK = TapeRow._fields.index("stock")
#: largest ratio of stock to nominal stock that fits into the picture; its standard deviation in tasks is a quarter
STOCK_ROOM = 1.75


def extent_of(task: Task) -> Extent:
    """Return the data of pictures of a task that never change."""
    kinds = [task.kinds[task.kind_of_block(k)] for k in range(task.blocks)]
    lowest, highest = task.action.speed_ends
    return Extent(
        title=task.title,
        blocks=task.blocks,
        parts=sum(kind.ends_part for kind in kinds),
        new_diameter=task.wheel.diameter,
        lowest_speed=lowest,
        highest_speed=highest,
        most_executions=task.action.executions,
        longest=max(kind.length for kind in kinds),
        thickest=STOCK_ROOM * max(kind.stock for kind in kinds),
    )


class Viewer(ABC):
    """Viewer of episodes of a simulation."""

    @abstractmethod
    def view(self, episodes: Episodes, i: int, blocks: Sequence[Any], outcomes: Sequence[Outcome]) -> EpisodePicture:
        """Return the data of a picture of episode i after these steps, which had these outcomes."""


@dataclass(frozen=True, slots=True)
class TaskViewer(Viewer):
    """Viewer of episodes of a task; `text` writes a block."""

    task: Task
    text: Callable[[Any], str]

    def view(self, episodes: Episodes, i: int, blocks: Sequence[Any], outcomes: Sequence[Outcome]) -> EpisodePicture:
        limits = {kind.name: self.task.limits(kind) for kind in self.task.kinds}
        return EpisodePicture(
            extent=extent_of(self.task),
            ground=tuple(
                ground_block(block, outcome, limits[block.kind.name])
                for block, outcome in zip(blocks, outcomes, strict=True)
            ),
            wheel=episodes.wheel(i),
            part=_ground_part(blocks[-1], outcomes[-1]) if blocks else coming_part(self.task, episodes, i),
            text=self.text(blocks[-1]) if blocks else "",
        )


@dataclass(frozen=True, slots=True)
class ProgramViewer(Viewer):
    """Viewer of episodes of a user's program, given a `BlockOutline` for each block; `text` writes a block."""

    name: str
    task: Task
    job: Job
    outlines: Sequence[Any]
    parts: int
    text: Callable[[Any], str]

    def view(self, episodes: Episodes, i: int, blocks: Sequence[Any], outcomes: Sequence[Outcome]) -> EpisodePicture:
        job, outlines = self.job, self.outlines
        number = min(int(episodes.block[i]), len(outlines) - 1)
        coming = outlines[number]
        loads = coming.starts_part and (not blocks or blocks[-1].number != number)
        stock = float(episodes.tape[i, number if loads else max(number - 1, 0), STOCK])
        part = PartState(*episodes.parts[i].tolist())
        shown = coming.part if loads or not blocks else outlines[blocks[-1].number].part
        kinds = [each.part for each in job.part_stations] or [job.part]
        name_of = job.station_of(shown + 1)
        lowest, highest = self.task.action.speed_ends
        extent = Extent(
            title=self.name,
            blocks=len(outlines),
            parts=self.parts,
            new_diameter=job.setup.wheel.diameter,
            lowest_speed=lowest,
            highest_speed=highest,
            most_executions=max((block.executions for block in blocks), default=1) or 1,
            longest=max(each.length for each in kinds),
            thickest=STOCK_ROOM * max(each.stock for each in kinds),
        )
        ground = []
        for block, outcome in zip(blocks, outcomes, strict=True):
            limits = job.of_part(outlines[block.number].part + 1).limits
            # size and roughness count when the part is finished
            limits = limits if outcome.finished > 0.0 else limits._replace(roughness=NO_LIMIT, size=NO_LIMIT)
            ground.append(ground_block(block, outcome, limits))
        return EpisodePicture(
            extent=extent,
            ground=tuple(ground),
            wheel=episodes.wheel(i),
            part=Workpiece(
                name=f"part {shown + 1}{f' ({name_of})' if name_of else ''}",
                length=job.of_part(shown + 1).part.length,
                stock=stock,
                left=stock if not blocks else stock - part.S,
            ),
            text=self.text(blocks[-1]) if blocks else "",
        )


def ground_block(block: Any, outcome: Outcome, limits: Limits) -> GroundBlock:
    """Return the picture data of a finished block with E and D, and of its outcome."""
    return GroundBlock(
        speed=block.speed,
        executions=block.executions,
        power=outcome.peak_power,
        torque=outcome.peak_torque,
        rise=outcome.rise,
        roughness=outcome.roughness,
        size_error=outcome.size_error,
        limits=limits,
        cost=outcome.cost,
        finished=outcome.finished > 0.0,
        good=outcome.good,
    )


def coming_part(task: Task, episodes: Episodes, i: int) -> Workpiece:
    """Return the part of the next block of episode i, with all the stock of that block on it."""
    row = TapeRow(*episodes.row(i).tolist())
    kind = task.kinds[int(row.kind)]
    return Workpiece(name=kind.name, length=kind.length, stock=row.stock, left=row.stock)


def _ground_part(block: Any, outcome: Outcome) -> Workpiece:
    left = 0.001 * outcome.size_error
    return Workpiece(name=block.kind.name, length=block.kind.length, stock=block.stock, left=left)

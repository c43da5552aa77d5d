"""The cycle blocks of a program, which a branch may try one by one: each is a row, and the same text is a kind."""

from collections.abc import Mapping, Sequence

import numpy as np

from grind_env.arrays import Numbers, Table
from grind_env.control.rules import motion_time
from grind_env.envs.branches import Branches
from grind_env.envs.episodes import Episodes
from grind_env.envs.job.outline import BlockOutline
from grind_env.envs.tape import BLOCKS, DRAWN
from grind_env.envs.transition import KIND
from grind_env.machine.dress.mounting import USUAL_DEPTH, USUAL_LEAD, first_wheel
from grind_env.machine.job import Job
from grind_env.process.cost import running_cost
from grind_env.process.equations import dressed_volume


class ProgramBranches(Branches):
    """Those of a program, with one dress program, which is the first, and one wheel that every episode begins with.

    Args:
        blocks: of the program.
        job: its job.
        kind_of_row: number of the kind of each block.
        revolutions: of the wheel, 1/s.

    Attributes:
        strokes: of each block on nominal parts, shape (blocks,); who has ground them sets it.
    """

    strokes: Table

    def __init__(self, blocks: Sequence[BlockOutline], job: Job, kind_of_row: Numbers, revolutions: float) -> None:
        jobs = [job.of_part(block.part + 1) for block in blocks]
        self._blocks, self._stocks = blocks, np.array([each.part.stock for each in jobs])
        parameters = [each.parameters for each in jobs]
        self.kind_of_row = kind_of_row
        self.base = np.array(parameters if job.stations else [job.parameters])
        _, firsts = np.unique(kind_of_row, return_index=True)
        self.nominal = self.base[np.minimum(firsts, len(self.base) - 1)]
        self.wheel = np.array(first_wheel(job, blocks[0].dress, jobs[0].parameters))
        self.dress_price, self.usual_dress = 0.0, (USUAL_LEAD * revolutions, USUAL_DEPTH)
        self.change_seconds = job.times.wheel_change or 0.0
        self.second_price: float = job.rates.hourly / 3600.0
        self._control = job.control
        self.own_speeds: Table | None = np.array([blocks[first].plan.feed for first in firsts])
        self._lengths = np.array([abs(block.plan.primary - block.plan.secondary) for block in blocks])
        dress = next((block.dress for block in blocks if block.dress is not None), None)
        if dress is not None:
            wheel = job.setup.wheel
            volume = dressed_volume(dress.passes, dress.depth, wheel.diameter, wheel.width)
            self.dress_price = running_cost(dress.seconds, volume, 1.0, job.rates)
            self.usual_dress = dress.feed, dress.depth

    def coming_rows(self, seen: Mapping[str, Table]) -> Numbers:
        """As `Branches.coming_rows`: from the share of the program that remains."""
        blocks = len(self._blocks)
        return np.clip(np.rint(blocks * (1.0 - seen["remaining"])), 0, blocks - 1).astype(np.int64)

    def seconds(self, rows: Numbers, speeds: Table) -> Table:
        control = self._control
        strokes = [motion_time(length, E / 60.0, control.acceleration) + control.reversal_dwell
                   for length, E in zip(self._lengths[rows].tolist(), speeds.tolist(), strict=True)]  # fmt: skip
        return np.asarray(self.strokes[rows] * np.array(strokes))

    def part_from(self, block: int) -> range:
        last = block
        while last + 1 < len(self._blocks) and not self._blocks[last].finished:
            last += 1
        return range(block, last + 1)

    def lengthened(self, episodes: Episodes, blocks: range) -> Episodes:
        tape = np.repeat(episodes.tape, len(blocks), axis=1)
        tape[:, :, KIND] = blocks
        return episodes.on(tape)

    def first_wheels(self, count: int) -> Table:
        """As `Branches.first_wheels`: all the same."""
        return np.tile(self.wheel, (count, 1))

    def stocks(self, rows: Numbers, ratios: Table) -> Table:
        return np.asarray(ratios * self._stocks[rows])

    def load(self, episodes: Episodes, index: Numbers, rows: Numbers, stocks: Table) -> None:
        super().load(episodes, index, rows, stocks)
        episodes.source[index[:, None], [BLOCKS, DRAWN]] = (len(self._blocks) - rows)[:, None]

"""Branches of a problem, for planners, beliefs and advisers: single blocks on copies of episodes, and prices.

`Episodes` has the methods that tasks and programs share: copies, windows of tapes, and the coming blocks.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from grind_env.array_types import Numbers, Table
from grind_env.control.cycle_formulas import motion_time
from grind_env.envs.block_kind_rows import KindRow, kind_table, parameter_table
from grind_env.envs.episode_generator import EpisodeGenerator
from grind_env.envs.episode_state import Episodes
from grind_env.envs.noise_tape import BLOCKS, DRAWN
from grind_env.envs.step_arrays import KIND, MATERIAL, STOCK
from grind_env.envs.tasks import Task
from grind_env.machine.dress.mounted_wheel import USUAL_DEPTH, USUAL_LEAD, first_wheel
from grind_env.machine.job import Job
from grind_env.process.cost import running_cost
from grind_env.process.equations import dressed_volume

NOMINAL_STOCK = KindRow._fields.index("stock")


class Branches(ABC):
    """Data and methods to try single blocks of a problem on branches of an episode."""

    #: nominal stroke parameters, shape (any, fields of `StrokeParameters`): one row, or one for each kind row
    base: Table
    nominal: Table  #: nominal stroke parameters of each kind, shape (kinds, fields of `StrokeParameters`)
    kind_of_row: Numbers  #: number of the kind of each row of `Simulation.kinds`
    dress_price: float  #: price of a dress execution, $; 0 without a dress program
    #: traverse feed of the diamond, mm/s, and depth of a pass, mm, with which a new wheel is dressed
    usual_dress: tuple[float, float]
    change_seconds: float  #: time of a wheel change, s
    second_price: float  #: price of a second of the machine, $/s
    own_speeds: Table | None  #: E of the program in blocks of each kind, mm/min, shape (kinds,); None for a task

    materials: int = 1  #: number of rows of a kind: one for each material
    _ends: Sequence[bool]  #: True for each block of the nominal sequence that ends a part

    @abstractmethod
    def seconds(self, rows: Numbers, speeds: Table) -> Table:
        """Return the nominal time of blocks of these rows at E in mm/min without a dress, s; all of shape (N,)."""

    @abstractmethod
    def coming_rows(self, seen: Mapping[str, Table]) -> Numbers:
        """Return the row in `Simulation.kinds` of the coming block from the readings, shape (N,)."""

    def part_from(self, block: int) -> range:
        """Return a block of the nominal sequence and those after it up to the end of its part."""
        last = block
        while last + 1 < len(self._ends) and not self._ends[last]:
            last += 1
        return range(block, last + 1)

    @abstractmethod
    def lengthened(self, episodes: Episodes, blocks: range) -> Episodes:
        """Return episodes of one block with longer tapes: `blocks` of the nominal sequence, the first as it is."""

    @abstractmethod
    def first_wheels(self, count: int) -> Table:
        """Return possible first wheels, spread evenly over the draws, shape (count, fields of `WheelState`)."""

    @abstractmethod
    def stocks(self, rows: Numbers, ratios: Table) -> Table:
        """Return the stock of blocks of these rows, mm, from its ratio to the nominal stock; all of shape (N,)."""

    def rows_of(self, tape: Table) -> Numbers:
        """Return the rows in `Simulation.kinds` of the blocks on a tape, shape (..., fields of `TapeRow`)."""
        return np.asarray(tape[..., KIND] * self.materials + tape[..., MATERIAL]).astype(np.int64)

    def load(self, episodes: Episodes, index: Numbers, rows: Numbers, stocks: Table) -> None:
        """Set the block of one-block episodes: its row in `Simulation.kinds` and its stock over the nominal stock.

        `index`, `rows` and `stocks` have shape (M,).
        """
        episodes.block[index] = 0
        episodes.tape[index, 0, KIND], episodes.tape[index, 0, MATERIAL] = np.divmod(rows, self.materials)
        episodes.tape[index, 0, STOCK] = self.stocks(rows, stocks)


class BlockBranches(Branches):
    """Branches of a task; the tables have a row for every pair of kind and material, kind by kind."""

    def __init__(self, task: Task) -> None:
        self._task, self.materials = task, len(task.materials)
        self.base = parameter_table(task)
        self.nominal = np.array([task.parameters(kind) for kind in task.kinds])
        self.kind_of_row = np.arange(len(self.base)) // self.materials
        volume = dressed_volume(task.dress.passes, task.dress.depth, task.wheel.diameter, task.wheel.width)
        self.dress_price = running_cost(task.dress_seconds, volume, 1.0, task.rates)
        self.usual_dress = task.dress_feed, task.dress.depth
        self.change_seconds = task.wheel_change.seconds if task.wheel_change else 0.0
        self.second_price: float = task.rates.hourly / 3600.0
        self.own_speeds = None
        self._stocks = kind_table(task)[:, NOMINAL_STOCK]
        # only parts of a fixed sequence have several blocks
        ends = (task.orders is not None or task.kinds[task.kind_of_block(k)].ends_part for k in range(task.blocks))
        self._ends = tuple(ends)

    def seconds(self, rows: Numbers, speeds: Table) -> Table:
        task = self._task
        kinds = self.kind_of_row[rows].tolist()
        return np.array([task.nominal_seconds(task.kinds[k], E) for k, E in zip(kinds, speeds, strict=True)])

    def coming_rows(self, seen: Mapping[str, Table]) -> Numbers:
        task, names = self._task, self._task.materials
        kind = np.zeros(len(seen["remaining"]), np.int64)
        if len(task.kinds) > 1:
            kind = np.asarray(np.argmax([seen[f"coming_{each.name}"] for each in task.kinds], axis=0))
        material = np.array([names.index(each.material) for each in task.kinds])[kind]
        for number, name in enumerate(names):
            material = np.where(seen.get(f"material_{name}", np.zeros(len(kind))) > 0.5, number, material)
        return np.asarray(kind * len(names) + material)

    def lengthened(self, episodes: Episodes, blocks: range) -> Episodes:
        task = self._task
        # the handover of the wheel is charged after the last block of a tape
        length = len(blocks) + (blocks[-1] + 1 < task.blocks)
        tape = np.repeat(episodes.tape, length, axis=1)
        for k, block in enumerate(blocks[1:], 1):
            number = task.kind_of_block(block)
            tape[:, k, KIND], tape[:, k, STOCK] = number, task.kinds[number].stock
        return episodes.on(tape)

    def first_wheels(self, count: int) -> Table:
        generator = EpisodeGenerator(self._task)
        flats = self._task.spread.diamond_flat * (np.arange(count) + 0.5) / count
        return np.array([generator.wheel(float(flat)) for flat in flats])

    def stocks(self, rows: Numbers, ratios: Table) -> Table:
        return np.asarray(np.round(1000.0 * ratios * self._stocks[rows]) / 1000.0)


class ProgramBranches(Branches):
    """Branches of a program: prices hold for its first dress program, and every episode begins with the same wheel.

    Args:
        blocks: blocks of the program, a `BlockOutline` each.
        job: job of the program.
        kind_of_row: number of the kind of each block.
        revolutions: wheel speed, 1/s.
    """

    strokes: Table  #: strokes of each block on nominal parts, shape (blocks,); set after these are ground

    def __init__(self, blocks: Sequence[Any], job: Job, kind_of_row: Numbers, revolutions: float) -> None:
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
        self._ends = [block.finished > 0 for block in blocks]
        self.own_speeds: Table | None = np.array([blocks[first].plan.feed for first in firsts])
        self._lengths = np.array([abs(block.plan.primary - block.plan.secondary) for block in blocks])
        dress = next((block.dress for block in blocks if block.dress is not None), None)
        if dress is not None:
            wheel = job.setup.wheel
            volume = dressed_volume(dress.passes, dress.depth, wheel.diameter, wheel.width)
            self.dress_price = running_cost(dress.seconds, volume, 1.0, job.rates)
            self.usual_dress = dress.feed, dress.depth

    def coming_rows(self, seen: Mapping[str, Table]) -> Numbers:
        blocks = len(self._blocks)
        return np.clip(np.rint(blocks * (1.0 - seen["remaining"])), 0, blocks - 1).astype(np.int64)

    def seconds(self, rows: Numbers, speeds: Table) -> Table:
        control = self._control
        strokes = [motion_time(length, E / 60.0, control.acceleration) + control.reversal_dwell
                   for length, E in zip(self._lengths[rows].tolist(), speeds.tolist(), strict=True)]  # fmt: skip
        return np.asarray(self.strokes[rows] * np.array(strokes))

    def lengthened(self, episodes: Episodes, blocks: range) -> Episodes:
        tape = np.repeat(episodes.tape, len(blocks), axis=1)
        tape[:, :, KIND] = blocks
        return episodes.on(tape)

    def first_wheels(self, count: int) -> Table:
        return np.tile(self.wheel, (count, 1))

    def stocks(self, rows: Numbers, ratios: Table) -> Table:
        return np.asarray(ratios * self._stocks[rows])

    def load(self, episodes: Episodes, index: Numbers, rows: Numbers, stocks: Table) -> None:
        super().load(episodes, index, rows, stocks)
        episodes.source[index[:, None], [BLOCKS, DRAWN]] = (len(self._blocks) - rows)[:, None]


def coming_kinds(branches: Branches, seen: Mapping[str, Table]) -> Numbers:
    """Return the kind number of the coming block from the readings, shape (N,)."""
    return branches.kind_of_row[branches.coming_rows(seen)]

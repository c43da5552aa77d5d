"""The blocks of a task, which a branch may try one by one."""

from collections.abc import Mapping

import numpy as np

from grind_env.arrays import Numbers, Table
from grind_env.envs.blocks.episode import EpisodeGenerator
from grind_env.envs.branches import Branches
from grind_env.envs.episodes import Episodes
from grind_env.envs.tables import KindRow, kind_table, parameter_table
from grind_env.envs.tasks import Task
from grind_env.envs.transition import KIND, STOCK
from grind_env.process.cost import running_cost
from grind_env.process.equations import dressed_volume

NOMINAL_STOCK = KindRow._fields.index("stock")


class BlockBranches(Branches):
    """Those of a task; the tables have a row for every pair of kind and material, kind by kind."""

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
        self.own_speeds: Table | None = None
        self._stocks = kind_table(task)[:, NOMINAL_STOCK]

    def seconds(self, rows: Numbers, speeds: Table) -> Table:
        task = self._task
        kinds = self.kind_of_row[rows].tolist()
        return np.array([task.nominal_seconds(task.kinds[k], E / 1000.0) for k, E in zip(kinds, speeds, strict=True)])

    def coming_rows(self, seen: Mapping[str, Table]) -> Numbers:
        task, names = self._task, self._task.materials
        kind = np.zeros(len(seen["remaining"]), np.int64)
        if len(task.kinds) > 1:
            kind = np.asarray(np.argmax([seen[f"coming_{each.name}"] for each in task.kinds], axis=0))
        material = np.array([names.index(each.material) for each in task.kinds])[kind]
        for number, name in enumerate(names):
            material = np.where(seen.get(f"material_{name}", np.zeros(len(kind))) > 0.5, number, material)
        return np.asarray(kind * len(names) + material)

    def part_from(self, block: int) -> range:
        task, last = self._task, block
        # only parts of a fixed sequence have several blocks
        while task.orders is None and not task.kinds[task.kind_of_block(last)].ends_part:
            last += 1
        return range(block, last + 1)

    def lengthened(self, episodes: Episodes, blocks: range) -> Episodes:
        task = self._task
        # the wheel left behind is charged after the last block of a tape
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

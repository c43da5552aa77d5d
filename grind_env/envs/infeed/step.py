"""The step of `grind/Reciprocation-v0`; cost and memory of a block are those of `envs.blocks.step`."""

import functools
import math
from collections.abc import Callable
from typing import Any, NamedTuple

from grind_env.envs.blocks.step import Choices, EpisodeArrays, draw_coming, floor_of, stroking_of
from grind_env.envs.infeed.infeed import Infeed, write_motions
from grind_env.envs.step import Work, step_of
from grind_env.envs.tables import KindRow, Shop, ShopMemory, read_shop
from grind_env.kernel import entry, inlined
from grind_env.kernel.columns import column_writer, replacer
from grind_env.machine.loops.cycle import Stroking
from grind_env.machine.loops.feeding import FEED, FULL, Feeding
from grind_env.machine.loops.loops import loops_of
from grind_env.machine.loops.rows import RULES_FROM, read_stroking, write_stroking
from grind_env.machine.loops.rules import motion_time
from grind_env.process.gauge import Gauge
from grind_env.process.process import Process

PICK = ShopMemory._fields.index("pick")

write_feeding = column_writer(Feeding, RULES_FROM)
full_from = replacer(Stroking, "full_plunge")


class InfeedTables(NamedTuple):
    """What the task is made of, and room for N cycles; the first seven as in `Tables`."""

    kinds: Any
    base: Any
    shops: Any
    drawn: Any
    spreads: Any
    cycles: Any
    parameters: Any
    motions: Any
    """Room for the infeeds, shape (N, motions, fields of `Motion`)."""
    infeed: float
    """F, mm/s."""


@entry
def infeed_of(
    kind: KindRow, stock: float, E: float, dwell: float, D: float, acceleration: float, rate: float
) -> Infeed:
    """The infeed of the G81 block that grinds `stock` mm with D requests and F `rate` (mm/s).

    The table goes at E (mm/min) and rests for `dwell` s; `acceleration` is mm/s2.

    An entry and not inlined, because the program text needs it in every step of the single environment, too.
    """
    return Infeed(
        travel=motion_time(kind.stroke, E / 60.0, acceleration),
        dwell=dwell,
        rate=rate,
        acceleration=acceleration,
        target=stock,
        requests=D,
        sparkout=kind.sparkout + 1.0,
    )


@inlined
def infeed_stroking(kind: KindRow, shop: Shop, E: float, infeed: Infeed) -> Stroking:
    """The strokes of a block at E (mm/min)."""
    seconds = infeed.travel + infeed.dwell
    stroking = stroking_of(kind, shop, E, seconds, 0.0, 0.0, infeed.target, infeed.target)
    # the depth of a stroke is what the infeed covers in it
    return full_from(stroking, (FULL * infeed.rate * seconds,))


@inlined
def feeding_of(infeed: Infeed, pre_dress: float, motion: int) -> Feeding:
    """The strokes beside that infeed, whose motions stand from row `motion` on, perhaps after a pre-dress (1)."""
    return Feeding(
        pre_dress=pre_dress,
        first_travel=infeed.travel,
        travel=infeed.travel,
        dwell=infeed.dwell,
        acceleration=infeed.acceleration,
        made=0.0,
        away=0.0,
        to_secondary=0.0,
        motion=float(motion),
        gauged_at=math.inf,
    )


@functools.cache
def feedings_step(process: Process, gauge: Gauge) -> Callable[..., None]:
    """The compiled step of G81 blocks with an infeed."""
    (begin, settle_one), grind_feedings = floor_of(process, gauge), loops_of(FEED, process).lanes

    @entry
    def prepare(tables: InfeedTables, episodes: EpisodeArrays, choices: Choices, active: Any, results: Any) -> None:
        """Write the strokes beside the infeeds, and these; every block is a part."""
        shop = read_shop(tables.shops, 0)
        n, rows, fields = tables.motions.shape
        table = tables.motions.reshape(n * rows, fields)
        for i in active:
            kind, row, drive = begin(i, tables, episodes, shop, choices.speeds[i], results)
            E, D = drive.share * choices.speeds[i], choices.executions[i]
            infeed = infeed_of(kind, row.stock, E, drive.dwell, D, shop.acceleration, tables.infeed)
            write_stroking(tables.cycles, i, infeed_stroking(kind, shop, E, infeed))
            write_feeding(tables.cycles, i, feeding_of(infeed, choices.pre_dresses[i], i * rows))
            write_motions(table, i * rows, infeed)

    @entry
    def grind(tables: InfeedTables, episodes: EpisodeArrays, choices: Choices, active: Any, results: Any) -> None:
        """Run the strokes."""
        n, rows, fields = tables.motions.shape
        table = tables.motions.reshape(n * rows, fields)
        grind_feedings(tables.cycles, tables.parameters, episodes.wheels, episodes.parts, results, table, active, 0, 1)

    @entry
    def settle(
        tables: InfeedTables, episodes: EpisodeArrays, choices: Choices, active: Any, results: Any, outcomes: Any
    ) -> None:
        """As for G82 blocks, but for the pick."""
        shop = read_shop(tables.shops, 0)
        for i in active:
            settle_one(i, tables, episodes, choices, shop, results, outcomes)
            episodes.memory[i, PICK] = tables.infeed * read_stroking(tables.cycles, i).stroke_seconds
        draw_coming(tables, episodes, active)

    return step_of(Work(InfeedTables, EpisodeArrays, Choices, prepare, grind, settle))

"""The compiled step of `grind/Reciprocation-v0`; cost and memory of a block are those of `envs.blocks.step`."""

import math
from typing import Any

from grind_env.envs.blocks.step import Choices, EpisodeArrays, Tables, prepare, settle
from grind_env.envs.blocks.tables import KindRow, Shop, ShopMemory, read_kind, read_shop
from grind_env.envs.blocks.tape import read_row
from grind_env.envs.infeed.infeed import Infeed, write_motions
from grind_env.kernel import entry, inlined
from grind_env.kernel.columns import column_writer
from grind_env.machine.batch import FEEDS
from grind_env.machine.feeding import FULL, Feeding
from grind_env.machine.rules import motion_time

PICK = ShopMemory._fields.index("pick")
STROKE_SECONDS = Feeding._fields.index("stroke_seconds")
grind_feedings = FEEDS.lanes

write_feeding = column_writer(Feeding)


@entry
def infeed_of(kind: KindRow, stock: float, E: float, D: float, shop: Shop, rate: float) -> Infeed:
    """The infeed of the G81 block that grinds `stock` mm with E (mm/min), D requests and F `rate` (mm/s).

    An entry and not inlined, because the program text needs it in every step of the single environment, too.
    """
    return Infeed(
        travel=motion_time(kind.stroke, E / 60.0, shop.acceleration),
        dwell=shop.dwell,
        rate=rate,
        acceleration=shop.acceleration,
        target=stock,
        requests=D,
        sparkout=kind.sparkout + 1.0,
    )


@inlined
def feeding_of(kind: KindRow, infeed: Infeed, E: float, shop: Shop, pre_dress: float, motion: int) -> Feeding:
    """The strokes beside that infeed, whose motions stand from row `motion` on, perhaps after a pre-dress (1)."""
    seconds, middle = infeed.travel + infeed.dwell, 0.5 * infeed.travel
    return Feeding(
        speed=E / 60.0,
        first_seconds=seconds,
        stroke_seconds=seconds,
        pre_dress=pre_dress,
        full_plunge=FULL * infeed.rate * seconds,
        finish=infeed.target,
        width=kind.width,
        length=kind.length,
        dress_passes=shop.dress_passes,
        dress_feed=shop.dress_feed,
        dress_depth=shop.dress_depth,
        dress_seconds=shop.dress_seconds,
        first_middle=middle,
        middle=middle,
        acceleration=infeed.acceleration,
        surface=0.0,
        made=0.0,
        away=0.0,
        to_secondary=0.0,
        motion=float(motion),
        gauged_at=math.inf,
    )


@entry
def step_feedings(
    infeed: float,
    feedings: Any,
    motions: Any,
    cycles: Any,
    parameters: Any,
    kinds: Any,
    base: Any,
    shops: Any,
    tape: Any,
    block: Any,
    wheels: Any,
    parts: Any,
    memory: Any,
    speeds: Any,
    executions: Any,
    pre_dresses: Any,
    materials: int,
    active: Any,
    results: Any,
    outcomes: Any,
) -> None:
    """Grind the next block of the episodes in `active`; every block is a part.

    Args:
        infeed: F, mm/s.
        feedings: room for the strokes beside the infeed, shape (N, fields of `Feeding`).
        motions: room for the infeed, shape (N, motions, fields of `Motion`).
        cycles: as for `envs.blocks.step.step_blocks`, like all that follow.
        parameters: room for them.
        kinds: of the task.
        base: nominal parameters.
        shops: numbers of the task.
        tape: noise tape.
        block: number of the coming block; updated.
        wheels: updated.
        parts: updated.
        memory: updated.
        speeds: E, mm/min.
        executions: D, requests of the operator.
        pre_dresses: 1 for G81.1.
        materials: number of materials in the two tables.
        active: indices of the episodes to step.
        results: written.
        outcomes: written.
    """
    shop = read_shop(shops, 0)
    tables = Tables(kinds, base, shop, materials)
    episodes = EpisodeArrays(tape, block, wheels, parts, memory)
    choices = Choices(speeds, executions, pre_dresses)
    prepare(tables, episodes, choices, active, cycles, parameters, results)
    n, rows, fields = motions.shape
    table = motions.reshape(n * rows, fields)
    for i in active:
        row = read_row(tape[i], block[i])
        kind = read_kind(kinds, int(row.kind) * materials + int(row.material))
        feed = infeed_of(kind, row.stock, speeds[i], executions[i], shop, infeed)
        write_motions(table, i * rows, feed)
        write_feeding(feedings, i, feeding_of(kind, feed, speeds[i], shop, pre_dresses[i], i * rows))
    grind_feedings(feedings, parameters, wheels, parts, results, table, active, 0, 1)
    settle(tables, episodes, choices, active, cycles, parameters, results, outcomes)
    for i in active:
        # the depth of a stroke is what the infeed covers in it
        memory[i, PICK] = infeed * feedings[i, STROKE_SECONDS]

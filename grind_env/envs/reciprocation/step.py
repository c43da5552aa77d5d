"""The compiled step of `grind/Reciprocation-v0`; `envs.step` says what a block costs and what is remembered of it."""

from typing import Any

import numpy as np

from grind_env.envs.rows import KindRow, Memory, Shop, read_kind, read_shop
from grind_env.envs.step import CYCLE_FIELDS, Choices, EpisodeArrays, Tables, prepare, settle
from grind_env.envs.tape import read_row
from grind_env.kernel import entry
from grind_env.kernel.rows import column_writer
from grind_env.machine.reciprocation import Feeding, feed_blocks
from grind_env.machine.rules import motion_time
from grind_env.process.state import Stroke

PICK = Memory._fields.index("pick")
INFEED, TRAVEL, DWELL = (Feeding._fields.index(name) for name in ("infeed", "travel", "dwell"))
FEEDING_FIELDS, STROKE_FIELDS = len(Feeding._fields), len(Stroke._fields)

write_feeding = column_writer(Feeding)


@entry
def feeding_of(kind: KindRow, stock: float, E: float, D: float, shop: Shop, infeed: float, pre_dress: float) -> Feeding:
    """The G81 block that grinds `stock` mm with E (mm/min), D requests, F `infeed` (mm/s), perhaps a pre-dress (1).

    An entry and not inlined, because the program text needs it in every step of the single environment, too.
    """
    speed = E / 60.0
    return Feeding(
        speed=speed,
        travel=motion_time(kind.stroke, speed, shop.acceleration),
        dwell=shop.dwell,
        infeed=infeed,
        acceleration=shop.acceleration,
        target=stock,
        requests=D,
        pre_dress=pre_dress,
        sparkout=kind.sparkout + 1.0,
        width=kind.width,
        length=kind.length,
        dress_passes=shop.dress_passes,
        dress_feed=shop.dress_feed,
        dress_depth=shop.dress_depth,
        dress_seconds=shop.dress_seconds,
    )


@entry
def step_feedings(
    infeed: float,
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
        kinds: as for `envs.step.step_blocks`, like all that follow.
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
    n = block.size
    feedings, cycles = np.empty((n, FEEDING_FIELDS)), np.empty((n, CYCLE_FIELDS))
    parameters = np.empty((n, base.shape[1]))
    prepare(tables, episodes, choices, active, cycles, parameters)
    for i in active:
        row = read_row(tape[i], block[i])
        kind = read_kind(kinds, int(row.kind) * materials + int(row.material))
        feeding = feeding_of(kind, row.stock, speeds[i], executions[i], shop, infeed, pre_dresses[i])
        write_feeding(feedings, i, feeding)
    feed_blocks(feedings, parameters, wheels, parts, results, np.empty((n, 0, STROKE_FIELDS)), active)
    settle(tables, episodes, choices, active, cycles, parameters, results, outcomes)
    for i in active:
        # the depth of a stroke is what the infeed covers in it
        memory[i, PICK] = feedings[i, INFEED] * (feedings[i, TRAVEL] + feedings[i, DWELL])

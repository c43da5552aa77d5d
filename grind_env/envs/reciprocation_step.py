"""The compiled step of `grind/Reciprocation-v0`; `envs.step` says what a block costs and what is remembered of it."""

from typing import Any

import numpy as np

from grind_env.envs.rows import KindRow, Memory, Shop
from grind_env.envs.step import CYCLE_FIELDS, STROKE_FIELDS, prepare, settle
from grind_env.envs.tape import TapeRow
from grind_env.kernel import entry
from grind_env.kernel.rows import column_reader, column_writer
from grind_env.machine.reciprocation import Feeding, feed_blocks
from grind_env.machine.rules import motion_time

PICK = Memory._fields.index("pick")
INFEED, TRAVEL, DWELL = (Feeding._fields.index(name) for name in ("infeed", "travel", "dwell"))
FEEDING_FIELDS = len(Feeding._fields)

read_kind, read_row, write_feeding = column_reader(KindRow), column_reader(TapeRow), column_writer(Feeding)


@entry
def step_feedings(
    kinds: Any,
    base: Any,
    shop: Shop,
    infeed: float,
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
        kinds: as for `envs.step.step_blocks`, like all but the infeed.
        base: nominal parameters.
        shop: numbers of the task.
        infeed: F, mm/s.
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
    n = block.size
    feedings = np.empty((n, FEEDING_FIELDS))
    cycles = np.empty((n, CYCLE_FIELDS))
    parameters = np.empty((n, base.shape[1]))
    prepare(
        kinds,
        base,
        shop,
        tape,
        block,
        wheels,
        parts,
        memory,
        speeds,
        executions,
        pre_dresses,
        materials,
        active,
        cycles,
        parameters,
    )
    for i in active:
        row = read_row(tape[i], block[i])
        kind = read_kind(kinds, int(row.kind) * materials + int(row.material))
        speed = speeds[i] / 60.0
        feeding = Feeding(
            speed,
            motion_time(kind.stroke, speed, shop.acceleration),
            shop.dwell,
            infeed,
            shop.acceleration,
            row.stock,
            executions[i],
            pre_dresses[i],
            kind.sparkout + 1.0,
            kind.width,
            kind.length,
            shop.dress_passes,
            shop.dress_feed,
            shop.dress_depth,
            shop.dress_seconds,
        )
        write_feeding(feedings, i, feeding)
    feed_blocks(feedings, parameters, wheels, parts, results, np.empty((n, 0, STROKE_FIELDS)), active)
    settle(
        kinds,
        shop,
        tape,
        block,
        wheels,
        parts,
        memory,
        speeds,
        executions,
        pre_dresses,
        materials,
        active,
        cycles,
        parameters,
        results,
        outcomes,
    )
    for i in active:
        # the depth of a stroke is what the infeed covers in it
        memory[i, PICK] = feedings[i, INFEED] * (feedings[i, TRAVEL] + feedings[i, DWELL])

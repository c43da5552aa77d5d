"""The compiled step of `grind/WidePlates-v0`; cost and memory of a block are those of `envs.blocks.step`."""

from typing import Any

import numpy as np

from grind_env.envs.blocks.step import TARGET, Choices, EpisodeArrays, Tables, prepare, settle
from grind_env.envs.blocks.tables import read_shop
from grind_env.kernel import entry
from grind_env.machine.batch import NO_MOTIONS, TRAVERSES, longest_first
from grind_env.machine.cycle import Cycle, PartState
from grind_env.machine.gauging import gauge_zones
from grind_env.machine.rows import write_part

START, AT_DEPTH = Cycle._fields.index("start"), Cycle._fields.index("at_depth")
CROSS_END = Cycle._fields.index("cross_end")
PRIMARY_CROSS_PICK = Cycle._fields.index("primary_cross_pick")
SECONDARY_CROSS_PICK = Cycle._fields.index("secondary_cross_pick")
grind_traverses = TRAVERSES.lanes


@entry
def step_traverses(
    zones: Any,
    crossover: float,
    cross_pick: float,
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
    taper: Any,
    taper_noise: Any,
    speeds: Any,
    executions: Any,
    pre_dresses: Any,
    materials: int,
    active: Any,
    results: Any,
    outcomes: Any,
) -> None:
    """Grind the next block of the episodes in `active`; every block is a part, judged where it is worst.

    Args:
        zones: of a new part, shape (zones, fields of `Zone`).
        crossover: way across of a traverse, mm.
        cross_pick: K, mm.
        cycles: as for `envs.blocks.step.step_blocks`, like all that follow.
        parameters: room for them.
        kinds: of the task.
        base: nominal parameters.
        shops: numbers of the task.
        tape: noise tape.
        block: number of the coming block; updated.
        wheels: updated.
        parts: updated: the depth S is that where the part is farthest from its size.
        memory: updated.
        taper: of the parts as gauged, um, shape (N,); written.
        taper_noise: of the gauge, um, shape (N, blocks).
        speeds: E, mm/min.
        executions: D.
        pre_dresses: 1 for G83.1.
        materials: number of materials in the two tables.
        active: indices of the episodes to step.
        results: written.
        outcomes: written.
    """
    tables = Tables(kinds, base, read_shop(shops, 0), materials)
    episodes = EpisodeArrays(tape, block, wheels, parts, memory)
    choices = Choices(speeds, executions, pre_dresses)
    surfaces = np.empty((block.size, zones.shape[0], zones.shape[1]))
    prepare(tables, episodes, choices, active, cycles, parameters, results)
    for i in active:
        # the wheel sets out from the surface: the stroke to the primary point makes no cut, and each pick a traverse
        cycles[i, START] = 0.0
        cycles[i, AT_DEPTH] -= 1.0
        cycles[i, CROSS_END] = crossover
        cycles[i, PRIMARY_CROSS_PICK] = cross_pick
        cycles[i, SECONDARY_CROSS_PICK] = cross_pick
        for k in range(zones.shape[0]):
            for field in range(zones.shape[1]):
                surfaces[i, k, field] = zones[k, field]
    order = np.empty(active.size, np.int64)
    longest_first(cycles, active, order)
    grind_traverses(cycles, parameters, wheels, surfaces, results, NO_MOTIONS, order, 0, 1)
    for i in active:
        stock = cycles[i, TARGET]
        found = gauge_zones(surfaces[i], stock)
        write_part(parts, i, PartState(Z=stock, S=stock - 0.001 * found.worst_error, Rs=found.Ra))
        taper[i] = found.taper + taper_noise[i, block[i]]
    settle(tables, episodes, choices, active, cycles, parameters, results, outcomes)

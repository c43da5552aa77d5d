"""The compiled readings before a block."""

from typing import Any

import numpy as np

from grind_env.envs.cost import Shop, read_shop
from grind_env.envs.history import read_memory
from grind_env.envs.observations import LEAST_SLACK, Layout, Readings
from grind_env.envs.tables import read_kind
from grind_env.envs.tape import TapeRow, place_of, read_row
from grind_env.kernel import entry, inlined, log
from grind_env.kernel.columns import lane_writer
from grind_env.machine.loops.rows import OWN_FROM, read_wheel

READINGS = len(Readings._fields)
KIND = TapeRow._fields.index("kind")

LANES = 32
"""Episodes whose readings are scaled side by side, in vector registers."""

write_readings = lane_writer(Readings, 0, LANES)


@entry
def write_entries(
    values: Any, first: int, columns: Any, offset: Any, scale: Any, low: Any, high: Any, observations: Any
) -> None:
    """Write the entries of the observation that are readings, each cut at the range of its sensor.

    Args:
        values: every reading of `LANES` episodes from `first` on, shape (readings, LANES); overwritten.
        first: number of an episode.
        columns: which reading every entry is, shape (entries,), like the next four; -1 for none.
        offset: of each entry.
        scale: of each entry.
        low: of each entry.
        high: of each entry.
        observations: shape (N, entries), float32; written.
    """
    count = min(LANES, observations.shape[0] - first)
    for at in range(columns.size):
        if columns[at] >= 0:
            row, zero, unit, least, most = values[columns[at]], offset[at], scale[at], low[at], high[at]
            for lane in range(count):
                row[lane] = min(max((row[lane] - zero) / unit, least), most)
            for lane in range(count):
                observations[first + lane, at] = row[lane]


def heat_column(own: type[Any]) -> int:
    """Column of the part's heat in a row of a wheel with what process and gauge remember; -1 where they do not."""
    return OWN_FROM + own._fields.index("dT") if "dT" in own._fields else -1


@inlined
def part_rise(wheels: Any, i: int, heat: int, in_work: bool) -> float:
    """Temperature above the hall of a part, K, if it is still that of the strokes before."""
    return wheels[i, heat] if in_work and heat >= 0 else 0.0


@inlined
def observe_block(
    i: int,
    kinds: Any,
    total: int,
    tape: Any,
    block: Any,
    wheels: Any,
    heat: int,
    memory: Any,
    shop: Shop,
    layout: Layout,
    lanes: Any,
    observations: Any,
) -> None:
    """Write the readings of episode i to its lane, and the flags of its observation."""
    rows = tape.shape[1]
    materials = layout.materials.size
    execution_depth = 2.0 * shop.dress_passes * shop.dress_depth
    wheel, seen = read_wheel(wheels, i), read_memory(memory, i)
    ahead = block[i] < total
    row = read_row(tape[i], place_of(min(block[i], total - 1), rows))
    number, material = int(row.kind), int(row.material)
    kind = read_kind(kinds, number * materials + material)
    here = 1.0 if ahead else 0.0
    in_work, changed = ahead and kind.starts_part == 0.0, seen.wheel_changes > 0.0
    growth = row.spare_kA if changed else row.kA
    ra_scale = row.spare_ra_scale if changed else row.ra_scale
    time_to_due = here * (row.due - seen.clock)
    slack = log(max(time_to_due / row.work, LEAST_SLACK)) if here * row.work > 0.0 else 0.0
    reading = Readings(
        mean_power=seen.mean_power,
        first_power=seen.first_power,
        peak_power=seen.peak_power,
        last_speed=seen.speed,
        last_executions=seen.executions,
        last_pick=seen.pick,
        last_width=seen.width,
        size_error=seen.size_error,
        roughness=seen.roughness,
        parts_since_gauged=seen.since_gauged,
        volume=seen.volume,
        blocks_since_dress=seen.blocks_since_dress,
        dresses=seen.dresses,
        diameter=seen.diameter,
        pick=here * kind.pick,
        width=here * kind.width,
        length=here * kind.length,
        sparkout=here * kind.sparkout,
        stock=here * row.gauged / kind.stock,
        roughness_limit=here * kind.roughness,
        tolerance=here * kind.size,
        scrap=here * kind.scrap,
        new_lot=here * row.new_lot,
        remaining=(total - block[i]) / total,
        last_pre_dress=seen.pre_dress,
        executions_left=(seen.diameter - shop.least_diameter) / execution_depth,
        time_to_due=time_to_due,
        slack=slack,
        taper=seen.taper,
        wear_flat=wheel.A,
        loading=wheel.lam,
        diamond_flat=wheel.wd,
        dressed_roughness=wheel.Rd,
        dressed_density=wheel.Cd,
        growth=growth,
        pressure=row.pm,
        fracture=row.fc,
        wear=row.Gref,
        convection=row.hf,
        roughness_scale=ra_scale,
        wheel_volume=wheel.V,
        part_rise=part_rise(wheels, i, heat, in_work),
    )
    write_readings(lanes, i % LANES, reading)
    if ahead and layout.kinds > 0:
        observations[i, layout.first_kind + number] = 1.0
        if block[i] + 1 < total:
            after = int(tape[i, place_of(block[i] + 1, rows), KIND])
            observations[i, layout.first_kind + layout.kinds + after] = 1.0
    if ahead and layout.materials[material] >= 0:
        observations[i, layout.materials[material]] = 1.0


@entry
def observe_blocks(
    kinds: Any,
    total: int,
    tape: Any,
    block: Any,
    wheels: Any,
    heat: int,
    memory: Any,
    shops: Any,
    layout: Layout,
    offset: Any,
    scale: Any,
    low: Any,
    high: Any,
    observations: Any,
) -> None:
    """Write the observations before the coming blocks.

    Args:
        kinds: of `step.Tables`.
        total: blocks of an episode.
        tape: of `step.EpisodeArrays`, like the next three.
        block: coming block.
        wheels: wheel states.
        heat: column of them with the heat of the part, see `heat_column`.
        memory: what is remembered.
        shops: numbers of the task, shape (1, fields of `Shop`).
        layout: which readings are shown, and where.
        offset: of each entry, shape (entries,), like the next three.
        scale: of each entry.
        low: of each entry.
        high: of each entry.
        observations: shape (N, entries), float32, all 0; written.
    """
    shop = read_shop(shops, 0)
    lanes = np.empty(READINGS * LANES)
    values = lanes.reshape((READINGS, LANES))
    for first in range(0, block.size, LANES):
        for i in range(first, min(first + LANES, block.size)):
            observe_block(i, kinds, total, tape, block, wheels, heat, memory, shop, layout, lanes, observations)
        write_entries(values, first, layout.columns, offset, scale, low, high, observations)

"""Compiled observations: readings of the episodes, scaled and written into arrays."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from grind_env.envs.block_kind_rows import read_kind
from grind_env.envs.cost import Shop, read_shop
from grind_env.envs.noise_tape import place_of, read_row
from grind_env.envs.observations import LEAST_SLACK, Reading, Readings
from grind_env.envs.past_readings import read_memory
from grind_env.envs.step_arrays import KIND
from grind_env.envs.tasks import Task
from grind_env.kernel import entry, inlined, log
from grind_env.kernel.row_accessors import lane_writer
from grind_env.machine.loops.row_io import OWN_FROM, read_wheel


class Layout(NamedTuple):
    """Sources of the entries of an observation."""

    #: index into `Readings` of every entry, shape (entries,); -1 for an entry that is no reading
    columns: NDArray[np.int64]
    kinds: int  #: number of flags of the coming kind; the same number of flags of the following kind comes next
    first_kind: int  #: index of the first of these flags
    materials: NDArray[np.int64]  #: index of the entry of every material of the catalogue; -1 for none


class Scaling(NamedTuple):
    """Scaling of readings to entries of an observation.

    `offset` and `scale` have the units of the readings; `low` and `high` have no unit.
    """

    layout: Layout
    offset: NDArray[np.float64]  #: offset of each entry, shape (entries,), like the next three
    scale: NDArray[np.float64]
    low: NDArray[np.float64]
    high: NDArray[np.float64]


def scaling(task: Task, entries: tuple[Reading, ...]) -> Scaling:
    """Return the scaling of an observation with these entries."""
    columns = (np.array([getattr(entry, name) for entry in entries]) for name in ("offset", "scale", "low", "high"))
    return Scaling(_layout(task, entries), *columns)


def _layout(task: Task, entries: tuple[Reading, ...]) -> Layout:
    """Return the sources of entries; entries that are neither reading nor flag read 0 until the caller writes them."""
    names = [entry.name for entry in entries]
    first, flags = f"coming_{task.kinds[0].name}", [f"material_{name}" for name in task.materials]
    return Layout(
        columns=np.array([Readings._fields.index(name) if name in Readings._fields else -1 for name in names]),
        kinds=len(task.kinds) if first in names else 0,
        first_kind=names.index(first) if first in names else 0,
        materials=np.array([names.index(flag) if flag in names else -1 for flag in flags]),
    )


READINGS = len(Readings._fields)

LANES = 32  #: number of episodes whose readings are scaled side by side, in vector registers

write_readings = lane_writer(Readings, 0, LANES)


@entry
def write_entries(
    values: Any, first: int, columns: Any, offset: Any, scale: Any, low: Any, high: Any, observations: Any
) -> None:
    """Write the entries of the observation that are readings, each cut at the range of its sensor.

    `values` are the readings of `LANES` episodes from `first` on, shape (readings, LANES), which are overwritten;
    `columns` are those of the `Layout`, and the other arguments are as for `observe_blocks`.
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
    """Return the first column with the part's heat in rows of wheel, process and gauge memory; -1 if there is none."""
    return OWN_FROM + own._fields.index("dT_1") if "dT_1" in own._fields else -1


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
    wheel, seen = read_wheel(wheels, i), read_memory(memory, i)
    ahead = block[i] < total
    row = read_row(tape[i], place_of(min(block[i], total - 1), rows))
    number, material = int(row.kind), int(row.material)
    kind = read_kind(kinds, number * materials + material)
    here = 1.0 if ahead else 0.0
    changed = seen.wheel_changes > 0.0
    # temperature rise of the part in work, if the coming block continues this part
    rise = wheels[i, heat] + wheels[i, heat + 1] + wheels[i, heat + 2] + wheels[i, heat + 3]
    part_rise = rise if ahead and kind.starts_part == 0.0 and heat >= 0 else 0.0
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
        executions_left=(seen.diameter - shop.least_diameter) / shop.execution_depth,
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
        part_rise=part_rise,
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
        kinds: numbers of the kinds, as in `step_arrays.Tables`.
        total: number of blocks of an episode.
        tape: tapes, as in `step_arrays.EpisodeArrays`, like `block`, `wheels` and `memory`.
        block: number of the coming block.
        wheels: wheels with the memory of process and gauge.
        heat: column of `wheels` with the heat of the part, see `heat_column`.
        memory: memory of the shop floor.
        shops: numbers of the task, shape (1, fields of `Shop`).
        layout: sources of the entries.
        offset: offset of each entry, shape (entries,).
        scale: scale of each entry, shape (entries,).
        low: lowest value of each entry, shape (entries,).
        high: highest value of each entry, shape (entries,).
        observations: shape (N, entries), float32, all 0; written.
    """
    shop = read_shop(shops, 0)
    lanes = np.empty(READINGS * LANES)
    values = lanes.reshape((READINGS, LANES))
    for first in range(0, block.size, LANES):
        for i in range(first, min(first + LANES, block.size)):
            observe_block(i, kinds, total, tape, block, wheels, heat, memory, shop, layout, lanes, observations)
        write_entries(values, first, layout.columns, offset, scale, low, high, observations)

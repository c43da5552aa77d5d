"""The compiled readings before a stroke."""

from typing import Any

import numpy as np

from grind_env.envs.blocks.observe import LANES, part_rise, write_entries
from grind_env.envs.strokes.readings import StrokeReadings
from grind_env.envs.strokes.step import PART, kind_of, pick_before, read_strokes, row_in_work, strokes_of
from grind_env.envs.tables import read_memory
from grind_env.kernel import entry, inlined
from grind_env.kernel.columns import lane_writer
from grind_env.machine.loops.rows import read_wheel

READINGS = len(StrokeReadings._fields)

write_readings = lane_writer(StrokeReadings, 0, LANES)


@inlined
def observe_stroke(
    i: int,
    kinds: Any,
    materials: int,
    parts: int,
    block: Any,
    wheels: Any,
    heat: int,
    memory: Any,
    tape: Any,
    strokes: Any,
    lanes: Any,
) -> None:
    """Write the readings of episode i to its lane."""
    ahead = block[i] < parts
    row, done = row_in_work(tape, block, parts, i), read_strokes(strokes, i)
    wheel, seen = read_wheel(wheels, i), read_memory(memory, i)
    kind = kind_of(kinds, materials, row.material, PART)
    here = 1.0 if ahead else 0.0
    starts = 1.0 if done.made == 0.0 else 0.0
    # the first stroke touches off: until then only the pre-gauge says how much there is to grind
    known = row.stock if done.made > 0.0 else row.gauged
    left = strokes_of(known, kind.pick, kind.sparkout) - done.made
    # without a coming part the entry itself is 0: a stock of nominal size
    stock = row.gauged / kind.stock if ahead else 1.0
    reading = StrokeReadings(
        power=seen.first_power,
        mean_power=seen.mean_power,
        peak_power=seen.peak_power,
        last_speed=seen.speed,
        last_dress=seen.executions,
        size_error=seen.size_error,
        roughness=seen.roughness,
        parts_since_gauged=seen.since_gauged,
        volume=seen.volume,
        dresses=seen.dresses,
        diameter=seen.diameter,
        pick=here * pick_before(done.made, known, kind.pick),
        strokes_left=here * left,
        stock=stock,
        starts_part=here * starts,
        new_lot=here * row.new_lot,
        remaining=(parts - block[i]) / parts,
        wear_flat=wheel.A,
        loading=wheel.lam,
        diamond_flat=wheel.wd,
        wheel_volume=wheel.V,
        growth=row.kA,
        pressure=row.pm,
        part_rise=part_rise(wheels, i, heat, done.made > 0.0),
    )
    write_readings(lanes, i % LANES, reading)


@entry
def observe_strokes(
    kinds: Any,
    materials: int,
    parts: int,
    block: Any,
    wheels: Any,
    heat: int,
    memory: Any,
    tape: Any,
    strokes: Any,
    columns: Any,
    offset: Any,
    scale: Any,
    low: Any,
    high: Any,
    observations: Any,
) -> None:
    """Write the observations before the coming strokes.

    Args:
        kinds: of `step.StrokeTables`; the arrays of N rows are those of `step.StrokeArrays`.
        materials: number of materials in the tables.
        parts: of an episode.
        block: number of the coming part.
        wheels: wheel states.
        heat: column of them with the heat of the part, see `blocks.observe.heat_column`.
        memory: what is remembered.
        tape: rows of the coming parts.
        strokes: what is remembered beside.
        columns: index into `StrokeReadings` of each entry, shape (entries,), like the next four.
        offset: of each entry.
        scale: of each entry.
        low: of each entry.
        high: of each entry.
        observations: shape (N, entries), float32; written.
    """
    lanes = np.empty(READINGS * LANES)
    values = lanes.reshape((READINGS, LANES))
    for first in range(0, block.size, LANES):
        for i in range(first, min(first + LANES, block.size)):
            observe_stroke(i, kinds, materials, parts, block, wheels, heat, memory, tape, strokes, lanes)
        write_entries(values, first, columns, offset, scale, low, high, observations)

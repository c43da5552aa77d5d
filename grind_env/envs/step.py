"""The compiled step: cycle parameters from E and D, the block kernel, cost, and the next readings."""

from typing import Any

import numpy as np

from grind_env.envs.episode import FACTORS, TapeRow
from grind_env.envs.observations import (
    GAUGE_EVERY,
    POWER_NOISE,
    POWER_NOISE_FLOOR,
    ROUGHNESS_NOISE,
    SIZE_NOISE,
    Readings,
)
from grind_env.envs.rows import KindRow, Memory, Outcome, Shop
from grind_env.kernel import entry, inlined
from grind_env.kernel.rows import column_reader, column_writer
from grind_env.machine.batch import longest_first
from grind_env.machine.block import run_blocks
from grind_env.machine.cycle import Cycle, CycleResult, PartState, dress_lead
from grind_env.machine.rules import motion_time
from grind_env.process.cost import Limits, Rates, handover_cost, running_cost, survival
from grind_env.process.equations import INITIAL_ROUGHNESS
from grind_env.process.state import Stroke, StrokeParameters, WheelState

WEAR = WheelState._fields.index("W")
TARGET = Cycle._fields.index("target")
FACTOR_COLUMNS = tuple(TapeRow._fields.index(name) for name in FACTORS)
PARAMETER_COLUMNS = tuple(StrokeParameters._fields.index(name) for name in FACTORS)
CYCLE_FIELDS, STROKE_FIELDS, READINGS = len(Cycle._fields), len(Stroke._fields), len(Readings._fields)

read_kind, read_row = column_reader(KindRow), column_reader(TapeRow)
read_parameters, write_parameters = column_reader(StrokeParameters), column_writer(StrokeParameters)
read_wheel, write_wheel = column_reader(WheelState), column_writer(WheelState)
read_part, write_part = column_reader(PartState), column_writer(PartState)
read_memory, write_memory = column_reader(Memory), column_writer(Memory)
read_result, write_cycle, write_outcome = (
    column_reader(CycleResult),
    column_writer(Cycle),
    column_writer(Outcome),
)
write_readings = column_writer(Readings)


@inlined
def cycle_of(kind: KindRow, row: TapeRow, part: PartState, E: float, D: float, shop: Shop) -> Cycle:
    """The cycle of a block.

    The wheel is set to the first depth before the first stroke, off the part, so the cycle itself makes one
    pick less than there are depths, and one spark-out stroke more follows its last cut.
    """
    surface = 0.0 if kind.starts_part > 0.0 else part.Z
    speed = E / 60.0
    seconds = motion_time(kind.stroke, speed, shop.acceleration) + shop.dwell
    target = surface + row.stock
    return Cycle(
        speed,
        seconds,
        seconds,
        min(surface + kind.pick, target),
        target,
        kind.pick,
        kind.pick,
        kind.sparkout + 1.0,
        1.0,
        D,
        0.0,
        kind.width,
        kind.length,
        shop.dress_passes,
        shop.dress_feed,
        shop.dress_depth,
        shop.dress_seconds,
    )


@inlined
def measured(power: float, z: float) -> float:
    """A power reading, W; z is standard normal times the task's factor on the noise."""
    return max(power * (1.0 + POWER_NOISE * z) + POWER_NOISE_FLOOR * z, 0.0)


@entry
def step_blocks(
    kinds: Any,
    base: Any,
    shop: Any,
    tape: Any,
    block: Any,
    wheels: Any,
    parts: Any,
    memory: Any,
    speeds: Any,
    executions: Any,
    active: Any,
    results: Any,
    outcomes: Any,
) -> None:
    """Grind the next block of the episodes in `active`.

    Args:
        kinds: shape (kinds, fields of `KindRow`).
        base: nominal parameters, shape (kinds, fields of `StrokeParameters`).
        shop: numbers of the task.
        tape: shape (N, blocks, fields of `TapeRow`).
        block: number of the coming block, shape (N,), int64; updated.
        wheels: shape (N, fields of `WheelState`); updated, like the next two.
        parts: shape (N, fields of `PartState`).
        memory: shape (N, fields of `Memory`).
        speeds: E, mm/min, shape (N,).
        executions: D, shape (N,).
        active: indices of the episodes to step, int64.
        results: shape (N, fields of `CycleResult`); written in the rows of `active`.
        outcomes: shape (N, fields of `Outcome`); written likewise.
    """
    n = block.size
    cycles = np.empty((n, CYCLE_FIELDS))
    parameters = np.empty((n, base.shape[1]))
    for i in active:
        row = read_row(tape[i], block[i])
        number = int(row.kind)
        kind = read_kind(kinds, number)
        cycle = cycle_of(kind, row, read_part(parts, i), speeds[i], executions[i], shop)
        write_cycle(cycles, i, cycle)
        parameters[i] = base[number]
        for k in range(len(FACTOR_COLUMNS)):
            parameters[i, PARAMETER_COLUMNS[k]] *= tape[i, block[i], FACTOR_COLUMNS[k]]
        # the part is touched off or gauged before every block: wear of the wheel up to now is known
        wheels[i, WEAR] = 0.0
        if kind.starts_part > 0.0:
            write_part(parts, i, PartState(0.0, 0.0, INITIAL_ROUGHNESS))
    order = np.empty(active.size, np.int64)
    longest_first(cycles, active, order)
    run_blocks(cycles, parameters, wheels, parts, results, np.empty((n, 0, STROKE_FIELDS)), order, 0, 1)

    rates = Rates(shop.hourly, shop.wheel_price, shop.dress_price)
    for i in active:
        row = read_row(tape[i], block[i])
        kind = read_kind(kinds, int(row.kind))
        wheel, part, p = read_wheel(wheels, i), read_part(parts, i), read_parameters(parameters, i)
        result, old = read_result(results, i), read_memory(memory, i)
        ends = kind.ends_part > 0.0

        rise = result.plunge_rise if kind.counts_all > 0.0 else result.finish_rise
        size_error = 1000.0 * (cycles[i, TARGET] - part.S)
        limits = Limits(kind.rise, kind.power, kind.roughness, kind.size)
        alive = (1.0 if kind.starts_part > 0.0 else old.survival) * survival(
            rise, result.peak_power, part.Rs, size_error, limits
        )
        time_cost = running_cost(result.seconds + kind.load, 0.0, 0.0, rates)
        wheel_cost = running_cost(0.0, result.worn + result.dressed_off, 0.0, rates)
        dress_cost = running_cost(0.0, 0.0, result.dresses, rates)
        scrap_cost = kind.scrap * (1.0 - alive) if ends else 0.0
        handover = 0.0
        if block[i] + 1 == tape.shape[1]:
            lead = dress_lead(wheel, shop.dress_feed, p)
            handover = handover_cost(wheel, shop.dress_passes, lead, shop.dress_depth, shop.dress_seconds, p, rates)
        cost = time_cost + wheel_cost + dress_cost + scrap_cost + handover
        outcome = Outcome(
            time_cost=time_cost,
            wheel_cost=wheel_cost,
            dress_cost=dress_cost,
            scrap_cost=scrap_cost,
            handover_cost=handover,
            cost=cost,
            reward=-cost / shop.reference_cost,
            good=alive if ends else 0.0,
            finished=1.0 if ends else 0.0,
            seconds=result.seconds + kind.load,
            burn_ratio=result.burn_ratio,
            rise=rise,
            peak_power=result.peak_power,
            roughness=part.Rs,
            size_error=size_error,
        )
        write_outcome(outcomes, i, outcome)
        mean = result.last_power / result.last_count if result.last_count > 0.0 else 0.0
        first = result.first_power / result.first_count if result.first_count > 0.0 else 0.0
        gauge_now = ends and int(old.parts) % GAUGE_EVERY == 0
        ratio = part.Rs / kind.roughness if kind.roughness > 0.0 else 0.0
        known = ends and old.gauged >= 0.0
        # by position: numba compiles no call with so many keywords and conditions
        write_memory(
            memory,
            i,
            Memory(
                speeds[i] / 1000.0,
                executions[i],
                kind.pick,
                kind.width,
                measured(mean, row.mean_noise) if result.last_count > 0.0 else 0.0,
                measured(first, row.first_noise) if result.first_count > 0.0 else 0.0,
                measured(result.peak_power, row.peak_noise),
                size_error + SIZE_NOISE * row.size_noise if ends else old.size_error,
                old.gauged if known else old.roughness,
                ratio * (1.0 + ROUGHNESS_NOISE * row.roughness_noise) if gauge_now else (-1.0 if ends else old.gauged),
                1.0 if known else old.since_gauged + (1.0 if ends else 0.0),
                # the executions stand evenly in the depth: an equal share of it is ground after the last one
                row.stock * kind.length / (result.dresses + 1.0) + (0.0 if result.dresses > 0.0 else old.volume),
                0.0 if result.dresses > 0.0 else old.blocks_since_dress + 1.0,
                old.dresses + result.dresses,
                old.parts + (1.0 if ends else 0.0),
                alive,
            ),
        )
        block[i] += 1


@entry
def observe_blocks(
    kinds: Any,
    tape: Any,
    block: Any,
    wheels: Any,
    memory: Any,
    plain: int,
    offset: Any,
    scale: Any,
    low: Any,
    high: Any,
    observations: Any,
) -> None:
    """Write the observations before the coming blocks.

    Args:
        kinds: as for `step_blocks`, like the next four.
        tape: noise tape.
        block: coming block.
        wheels: wheel states.
        memory: what is remembered.
        plain: number of readings shown, before those that name the kind of block.
        offset: of each entry, shape (entries,), like the next three.
        scale: of each entry.
        low: of each entry.
        high: of each entry.
        observations: shape (N, entries), float32; written.
    """
    values = np.empty((1, READINGS))
    total = tape.shape[1]
    for i in range(block.size):
        wheel, seen = read_wheel(wheels, i), read_memory(memory, i)
        ahead = block[i] < total
        row = read_row(tape[i], min(block[i], total - 1))
        number = int(row.kind)
        kind = read_kind(kinds, number)
        here = 1.0 if ahead else 0.0
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
            diameter=wheel.ds,
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
            wear_flat=wheel.A,
            loading=wheel.lam,
            waviness=wheel.alw,
            diamond_flat=wheel.wd,
            dressed_roughness=wheel.Rd,
            dressed_density=wheel.Cd,
            growth=row.kA,
            pressure=row.pm,
            fracture=row.fc,
            wear=row.Gref,
            convection=row.hf,
            roughness_scale=row.ra_scale,
            wheel_volume=wheel.V,
        )
        write_readings(values, 0, reading)
        for k in range(plain):
            observations[i, k] = min(max((values[0, k] - offset[k]) / scale[k], low[k]), high[k])
        if kinds.shape[0] > 1 and ahead:
            observations[i, plain + number] = 1.0
            if block[i] + 1 < total:
                after = int(read_row(tape[i], block[i] + 1).kind)
                observations[i, plain + kinds.shape[0] + after] = 1.0

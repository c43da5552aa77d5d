"""The compiled step: cycle parameters from E and D, the block kernel, cost, and what is remembered of them."""

from typing import Any

import numpy as np

from grind_env.envs.observations import GAUGE_EVERY, POWER_NOISE, POWER_NOISE_FLOOR, ROUGHNESS_NOISE, SIZE_NOISE
from grind_env.envs.rows import KindRow, Memory, Outcome, Shop
from grind_env.envs.tape import FACTORS, SPARE_FACTORS, TapeRow
from grind_env.kernel import entry, inlined
from grind_env.kernel.rows import column_reader, column_writer
from grind_env.machine.batch import longest_first
from grind_env.machine.block import run_blocks
from grind_env.machine.cycle import Cycle, CycleResult, PartState, dress_lead
from grind_env.machine.rules import motion_time
from grind_env.process.cost import Limits, Rates, handover_cost, running_cost, survival
from grind_env.process.equations import INITIAL_ROUGHNESS
from grind_env.process.state import Stroke, StrokeParameters, WheelState
from grind_env.process.stroke import dressed_wheel

WEAR = WheelState._fields.index("W")
TARGET = Cycle._fields.index("target")
FACTOR_COLUMNS = tuple(TapeRow._fields.index(name) for name in FACTORS)
SPARE_COLUMNS = tuple(TapeRow._fields.index(name) for name in SPARE_FACTORS)
PARAMETER_COLUMNS = tuple(StrokeParameters._fields.index(name) for name in FACTORS)
CHANGES = Memory._fields.index("wheel_changes")
CYCLE_FIELDS, STROKE_FIELDS = len(Cycle._fields), len(Stroke._fields)

read_kind, read_row, read_shop = column_reader(KindRow), column_reader(TapeRow), column_reader(Shop)
read_parameters, write_parameters = column_reader(StrokeParameters), column_writer(StrokeParameters)
read_wheel, write_wheel = column_reader(WheelState), column_writer(WheelState)
read_part, write_part = column_reader(PartState), column_writer(PartState)
read_memory, write_memory = column_reader(Memory), column_writer(Memory)
read_result, write_cycle, write_outcome = (
    column_reader(CycleResult),
    column_writer(Cycle),
    column_writer(Outcome),
)


@inlined
def cycle_of(
    kind: KindRow, row: TapeRow, part: PartState, E: float, D: float, shop: Shop, pre_dress: float = 0.0
) -> Cycle:
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
        pre_dress,
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
def prepare(
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
    pre_dresses: Any,
    materials: int,
    active: Any,
    cycles: Any,
    parameters: Any,
) -> None:
    """Write the cycle of every block and its parameters, and load or gauge the parts; arguments as in `step_blocks`."""
    for i in active:
        row = read_row(tape[i], block[i])
        number = int(row.kind) * materials + int(row.material)
        kind = read_kind(kinds, number)
        cycle = cycle_of(kind, row, read_part(parts, i), speeds[i], executions[i], shop, pre_dresses[i])
        write_cycle(cycles, i, cycle)
        # a loop: with numba's copy of a slice, all of this function takes 40 % longer
        for k in range(base.shape[1]):
            parameters[i, k] = base[number, k]
        changed = memory[i, CHANGES] > 0.0
        for k in range(len(FACTOR_COLUMNS)):
            column = SPARE_COLUMNS[k] if changed else FACTOR_COLUMNS[k]
            parameters[i, PARAMETER_COLUMNS[k]] *= tape[i, block[i], column]
        # the part is touched off or gauged before every block: wear of the wheel up to now is known
        wheels[i, WEAR] = 0.0
        if kind.starts_part > 0.0:
            write_part(parts, i, PartState(0.0, 0.0, INITIAL_ROUGHNESS))


@entry
def settle(
    kinds: Any,
    shop: Any,
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
    cycles: Any,
    parameters: Any,
    results: Any,
    outcomes: Any,
) -> None:
    """Write what the blocks that were run have cost and shown; arguments as in `step_blocks`."""
    rates = Rates(shop.hourly, shop.wheel_price, shop.dress_price)
    for i in active:
        row = read_row(tape[i], block[i])
        kind = read_kind(kinds, int(row.kind) * materials + int(row.material))
        wheel, part, p = read_wheel(wheels, i), read_part(parts, i), read_parameters(parameters, i)
        result, old = read_result(results, i), read_memory(memory, i)
        ends = kind.ends_part > 0.0

        rise = result.plunge_rise if kind.counts_all > 0.0 else result.finish_rise
        size_error = 1000.0 * (cycles[i, TARGET] - part.S)
        limits = Limits(kind.rise, kind.power, kind.roughness, kind.size)
        alive = (1.0 if kind.starts_part > 0.0 else old.survival) * survival(
            rise, result.peak_power, part.Rs, size_error, limits
        )
        lead = dress_lead(wheel, shop.dress_feed, p)
        change = 1.0 if wheel.ds < shop.least_diameter else 0.0
        if change > 0.0:
            wheel = dressed_wheel(shop.new_diameter, wheel.wd, lead, shop.dress_depth, p)
            write_wheel(wheels, i, wheel)
        seconds = result.seconds + kind.load + change * shop.change_seconds
        clock = old.clock + seconds
        time_cost = running_cost(seconds, 0.0, 0.0, rates)
        wheel_cost = running_cost(0.0, result.worn + result.dressed_off, 0.0, rates)
        dress_cost = running_cost(0.0, 0.0, result.dresses, rates)
        finished = 1.0 if ends else 0.0
        scrap_cost = finished * kind.scrap * (1.0 - alive)
        late_cost = row.is_due * shop.late_price * max(clock - row.due, 0.0) / 3600.0
        change_cost = change * shop.change_price
        handover = 0.0
        if block[i] + 1 == tape.shape[1]:
            handover = handover_cost(wheel, shop.dress_passes, lead, shop.dress_depth, shop.dress_seconds, p, rates)
        cost = time_cost + wheel_cost + dress_cost + scrap_cost + handover + late_cost + change_cost
        outcome = Outcome(
            time_cost=time_cost,
            wheel_cost=wheel_cost,
            dress_cost=dress_cost,
            scrap_cost=scrap_cost,
            handover_cost=handover,
            late_cost=late_cost,
            change_cost=change_cost,
            cost=cost,
            reward=-cost / shop.reference_cost,
            good=finished * alive,
            finished=finished,
            seconds=seconds,
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
        # the executions stand evenly in the depth: an equal share of it is ground after the last one
        volume = row.stock * kind.length / (result.dresses - pre_dresses[i] + 1.0)
        volume = (0.0 if change > 0.0 else volume) + (0.0 if result.dresses + change > 0.0 else old.volume)
        since_dress = 0.0 if result.dresses + change > 0.0 else old.blocks_since_dress + 1.0
        # by position: numba compiles no call with so many keywords and conditions
        write_memory(
            memory,
            i,
            Memory(
                speeds[i] / 1000.0,
                executions[i],
                kind.pick,
                kind.width,
                # of a new wheel nothing is known yet
                measured(mean, row.mean_noise) if result.last_count > 0.0 and change == 0.0 else 0.0,
                measured(first, row.first_noise) if result.first_count > 0.0 else 0.0,
                measured(result.peak_power, row.peak_noise),
                size_error + SIZE_NOISE * row.size_noise if ends else old.size_error,
                old.gauged if known else old.roughness,
                ratio * (1.0 + ROUGHNESS_NOISE * row.roughness_noise) if gauge_now else (-1.0 if ends else old.gauged),
                1.0 if known else old.since_gauged + (1.0 if ends else 0.0),
                volume,
                since_dress,
                old.dresses + result.dresses,
                old.parts + (1.0 if ends else 0.0),
                alive,
                pre_dresses[i],
                clock,
                old.wheel_changes + change,
            ),
        )
        block[i] += 1


@entry
def step_blocks(
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
    """Grind the next block of the episodes in `active`.

    Args:
        kinds: of `rows.kind_table`.
        base: of `rows.parameter_table`.
        shops: numbers of the task, shape (1, fields of `Shop`): a named tuple takes Python long to hand over.
        tape: shape (N, blocks, fields of `TapeRow`).
        block: number of the coming block, shape (N,), int64; updated.
        wheels: shape (N, fields of `WheelState`); updated, like the next two.
        parts: shape (N, fields of `PartState`).
        memory: shape (N, fields of `Memory`).
        speeds: E, mm/min, shape (N,).
        executions: D, shape (N,).
        pre_dresses: 1 for a dress before the first plunge, shape (N,).
        materials: number of materials in the two tables.
        active: indices of the episodes to step, int64.
        results: shape (N, fields of `CycleResult`); written in the rows of `active`.
        outcomes: shape (N, fields of `Outcome`); written likewise.
    """
    n, shop = block.size, read_shop(shops, 0)
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
    order = np.empty(active.size, np.int64)
    longest_first(cycles, active, order)
    run_blocks(cycles, parameters, wheels, parts, results, np.empty((n, 0, STROKE_FIELDS)), order, 0, 1)
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

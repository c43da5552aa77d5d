"""The compiled step of `grind/Reciprocation-v0`: the block, its cost, and what is remembered of it.

Cost and memory are those of `envs.step`.
"""

from typing import Any

import numpy as np

from grind_env.envs.episode import FACTORS, TapeRow
from grind_env.envs.observations import GAUGE_EVERY, ROUGHNESS_NOISE, SIZE_NOISE
from grind_env.envs.rows import KindRow, Memory, Outcome, Shop
from grind_env.envs.step import measured
from grind_env.kernel import entry
from grind_env.kernel.rows import column_reader, column_writer
from grind_env.machine.cycle import CycleResult, PartState, dress_lead
from grind_env.machine.reciprocation import Feeding, feed_blocks
from grind_env.machine.rules import motion_time
from grind_env.process.cost import Limits, Rates, handover_cost, running_cost, survival
from grind_env.process.equations import INITIAL_ROUGHNESS
from grind_env.process.state import Stroke, StrokeParameters, WheelState

WEAR = WheelState._fields.index("W")
FACTOR_COLUMNS = tuple(TapeRow._fields.index(name) for name in FACTORS)
PARAMETER_COLUMNS = tuple(StrokeParameters._fields.index(name) for name in FACTORS)
STROKE_FIELDS, FEEDING_FIELDS = len(Stroke._fields), len(Feeding._fields)

read_kind, read_row = column_reader(KindRow), column_reader(TapeRow)
read_parameters, read_wheel = column_reader(StrokeParameters), column_reader(WheelState)
read_part, write_part = column_reader(PartState), column_writer(PartState)
read_memory, write_memory = column_reader(Memory), column_writer(Memory)
read_result, write_feeding, write_outcome = column_reader(CycleResult), column_writer(Feeding), column_writer(Outcome)


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
    parameters = np.empty((n, base.shape[1]))
    for i in active:
        row = read_row(tape[i], block[i])
        number = int(row.kind) * materials + int(row.material)
        kind = read_kind(kinds, number)
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
        parameters[i] = base[number]
        for k in range(len(FACTOR_COLUMNS)):
            parameters[i, PARAMETER_COLUMNS[k]] *= tape[i, block[i], FACTOR_COLUMNS[k]]
        wheels[i, WEAR] = 0.0
        write_part(parts, i, PartState(0.0, 0.0, INITIAL_ROUGHNESS))
    feed_blocks(feedings, parameters, wheels, parts, results, np.empty((n, 0, STROKE_FIELDS)), active)

    rates = Rates(shop.hourly, shop.wheel_price, shop.dress_price)
    for i in active:
        row = read_row(tape[i], block[i])
        kind = read_kind(kinds, int(row.kind) * materials + int(row.material))
        wheel, part, p = read_wheel(wheels, i), read_part(parts, i), read_parameters(parameters, i)
        result, old = read_result(results, i), read_memory(memory, i)
        rise = result.plunge_rise if kind.counts_all > 0.0 else result.finish_rise
        size_error = 1000.0 * (row.stock - part.S)
        limits = Limits(kind.rise, kind.power, kind.roughness, kind.size)
        alive = survival(rise, result.peak_power, part.Rs, size_error, limits)
        seconds = result.seconds + kind.load
        clock = old.clock + seconds
        time_cost = running_cost(seconds, 0.0, 0.0, rates)
        wheel_cost = running_cost(0.0, result.worn + result.dressed_off, 0.0, rates)
        dress_cost = running_cost(0.0, 0.0, result.dresses, rates)
        scrap_cost = kind.scrap * (1.0 - alive)
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
            late_cost=0.0,
            change_cost=0.0,
            cost=cost,
            reward=-cost / shop.reference_cost,
            good=alive,
            finished=1.0,
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
        gauge_now = int(old.parts) % GAUGE_EVERY == 0
        ratio = part.Rs / kind.roughness if kind.roughness > 0.0 else 0.0
        known = old.gauged >= 0.0
        volume = row.stock * kind.length / (executions[i] + 1.0)
        # by position: numba compiles no call with so many keywords and conditions
        write_memory(
            memory,
            i,
            Memory(
                speeds[i] / 1000.0,
                executions[i],
                infeed * (motion_time(kind.stroke, speeds[i] / 60.0, shop.acceleration) + shop.dwell),
                kind.width,
                measured(mean, row.mean_noise) if result.last_count > 0.0 else 0.0,
                measured(first, row.first_noise) if result.first_count > 0.0 else 0.0,
                measured(result.peak_power, row.peak_noise),
                size_error + SIZE_NOISE * row.size_noise,
                old.gauged if known else old.roughness,
                ratio * (1.0 + ROUGHNESS_NOISE * row.roughness_noise) if gauge_now else -1.0,
                1.0 if known else old.since_gauged + 1.0,
                volume + (0.0 if result.dresses > 0.0 else old.volume),
                0.0 if result.dresses > 0.0 else old.blocks_since_dress + 1.0,
                old.dresses + result.dresses,
                old.parts + 1.0,
                alive,
                pre_dresses[i],
                clock,
                old.wheel_changes,
            ),
        )
        block[i] += 1

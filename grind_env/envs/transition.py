"""The compiled step of every environment: load the part, run the cycle block, price it, read the gauges.

A row of the noise tape names the coming block: its row in the script (in a task, a kind of block in a material) and its
stock. Arrays are passed in plain tuples: a call with three tuples takes 1.8 us, with all arrays one by one 1.2 us, and
with named tuples 6 us.
"""

import functools
from collections.abc import Callable
from typing import Any

import numpy as np

from grind_env.belief.filter_quantities import FACTORS
from grind_env.envs.block_placement import place_block
from grind_env.envs.block_settling import price_of_handover, settle_of
from grind_env.envs.cost import Found, Shop, read_shop
from grind_env.envs.noise_tape import BLOCKS, SPARE_FACTORS, TapeRow, draw_rows, place_of
from grind_env.envs.part_surfaces import COVERED, IN_ZONES
from grind_env.envs.past_readings import FOUND, History
from grind_env.envs.step_arrays import (
    STOCK,
    Choices,
    EpisodeArrays,
    StageSoFar,
    Tables,
    gone_on,
    read_stage,
    row_of,
    with_stage,
    write_stage,
)
from grind_env.kernel import entry, inlined
from grind_env.kernel.row_accessors import column_writer, replacer
from grind_env.machine.dress.mounted_wheel import USUAL_DEPTH, USUAL_LEAD
from grind_env.machine.loops.block_change import shift_of
from grind_env.machine.loops.cycle import PartState, dress_lead
from grind_env.machine.loops.row_io import read_parameters, read_part, read_tally, read_wheel, write_part, write_wheel
from grind_env.machine.loops.stroke_totals import Tally
from grind_env.machine.script.block_settings import BlockSettings, E, read_settings
from grind_env.machine.script.replay import BlockPlace, read_block
from grind_env.machine.script.script_block import RestTimes
from grind_env.machine.script.script_tables import BlockRow
from grind_env.process.cost import STALL, Limits, survival
from grind_env.process.gauge_readings import Gauge
from grind_env.process.process_interface import Moment, Process
from grind_env.process.stroke_and_dress import dressed_wheel
from grind_env.process.stroke_types import FORCES, StrokeParameters, WheelState

#: number of episodes that are prepared, ground and settled together; their rows fit into the processor's cache
TOGETHER = 1024
DIAMETER, WEAR = WheelState._fields.index("ds"), WheelState._fields.index("W")
FACTOR_COLUMNS = tuple(TapeRow._fields.index(name) for name in FACTORS)
SPARE_COLUMNS = tuple(TapeRow._fields.index(name) for name in SPARE_FACTORS)
PARAMETER_COLUMNS = tuple(StrokeParameters._fields.index(name) for name in FACTORS)
FORCE_COLUMNS = tuple(StrokeParameters._fields.index(name) for name in FORCES)
CHANGES, SURVIVAL, STALLED, CLOCK = (
    History._fields.index(name) for name in ("wheel_changes", "survival", "stalled", "clock")
)
SECONDS, TORQUE = Tally._fields.index("seconds"), Tally._fields.index("peak_torque")
BEFORE, AFTER = RestTimes._fields.index("before"), RestTimes._fields.index("after")
FINISH, DEEPEST, ACROSS = (BlockPlace._fields.index(name) for name in ("finish", "pick", "across"))
with_seconds = replacer(Tally, "seconds")
with_words, write_row = replacer(BlockSettings, "E", "D"), column_writer(BlockSettings)


@inlined
def write_factored(parameters: Any, i: int, base: Any, number: int, tape: Any, place: int, changed: bool) -> None:
    """Write row `number` of the nominal parameters to episode i, with the factors in a row of its tape.

    The factors are those of the spare wheel if the wheel has been `changed`.
    """
    # a loop: with numba's copy of a slice, all of `prepare` takes 40 % longer
    for k in range(base.shape[1]):
        parameters[i, k] = base[number, k]
    for k in range(len(FACTOR_COLUMNS)):
        column = SPARE_COLUMNS[k] if changed else FACTOR_COLUMNS[k]
        parameters[i, PARAMETER_COLUMNS[k]] *= tape[i, place, column]


@inlined
def write_settings(tables: Any, choices: Any, i: int, number: int) -> None:
    """Write the settings of the block of episode i: all chosen settings, or E, D and the other words of the script."""
    if choices.settings.shape[0] > 0:
        write_row(tables.settings, i, read_settings(choices.settings, i))
    else:
        own = read_settings(tables.own_settings, number)
        write_row(tables.settings, i, with_words(own, (choices.speeds[i], choices.executions[i])))


@inlined
def judged(
    row: BlockRow, part: PartState, tally: Tally, stage: StageSoFar, size_error: float, before: float, cooler: float
) -> tuple[float, StageSoFar]:
    """Return the probability that the part is good so far, and the results of its stage.

    `before` is this probability before the block; `size_error` is um. The limit of temperature is that of the row plus
    `cooler`, K.
    """
    torque = max(stage.torque, tally.peak_torque)
    rise = max(stage.rise, tally.plunge_rise if row.counts_all > 0.0 else tally.finish_rise)
    good = before
    if row.judged > 0.0:
        limits = Limits(rise=row.rise + cooler, power=row.power, roughness=row.roughness, size=row.size)
        good = before * survival(rise, torque, part.Rs, size_error, limits)
        torque, rise = 0.0, 0.0
    if row.ends_part > 0.0 and part.Z <= 0.0:  # no stroke has reached some place on the part
        good = 0.0
    return good, with_stage(stage, (torque, rise, row.gauged))


@inlined
def new_wheel(settings: BlockSettings, shop: Shop, worn: WheelState, p: StrokeParameters) -> WheelState:
    """Return the wheel that replaces a worn one, which the operator dresses by the dress program of the block."""
    wheel = dressed_wheel(shop.new_diameter, worn.wd, USUAL_LEAD, USUAL_DEPTH, p)
    if settings.dress_passes > 0.0:
        lead = dress_lead(wheel, settings.dress_feed, p)
        wheel = dressed_wheel(shop.new_diameter, worn.wd, lead, settings.dress_depth, p)
    return wheel


@functools.cache
def stages_of(process: Process, gauge: Gauge, covered: bool) -> tuple[Callable[..., None], ...]:
    """Return the compiled parts of `step_of`: `prepare`, `grind` and `settle`."""
    surfaces, blocks_of, lay, gauge_part, error_of = COVERED if covered else IN_ZONES
    surface_array, grind_blocks = EpisodeArrays._fields.index(surfaces), blocks_of(process)
    (pass_time, before), (settle_one, _) = shift_of(process), settle_of(process, gauge)

    @inlined
    def came_and_waited(tables: Any, number: int, row: BlockRow, stage: StageSoFar) -> tuple[float, float]:
        """Return the time on the way to the first block, and the waiting time until the part is ready, s."""
        came = tables.approach if number == 0 else 0.0
        gone = tables.approach if number == 0 else stage.gone
        return came, max(row.wait - gone, 0.0)

    @entry
    def prepare(tables: Tables, episodes: EpisodeArrays, choices: Choices, active: Any, results: Any) -> None:
        """Write places, parameters and loaded parts, and into the results whether the spindle has stalled before."""
        shop = read_shop(tables.shops, 0)
        for i in active:
            place = place_of(episodes.block[i], episodes.tape.shape[1])
            number = row_of(episodes, i, place, shop)
            tables.rows[i] = number
            row, stage = read_block(tables.blocks, number), read_stage(episodes.stages, i)
            changed, base = episodes.memory[i, CHANGES] > 0.0, tables.base[episodes.machine[i]]
            write_factored(tables.parameters, i, base, min(number, base.shape[0] - 1), episodes.tape, place, changed)
            factor = episodes.forces[i, min(number, episodes.forces.shape[1] - 1)]
            if factor != 1.0:
                for column in FORCE_COLUMNS:
                    tables.parameters[i, column] *= factor
            write_settings(tables, choices, i, number)
            came, waited = came_and_waited(tables, number, row, stage)
            starts, rested = row.starts_part > 0.0, stage.rested + came + waited
            pass_time(episodes.wheels, tables.parameters, i, rested, starts)
            if starts or stage.gauged > 0.0:  # touched off or gauged: the wear of the wheel is known and compensated
                episodes.wheels[i, WEAR] = 0.0
            if starts:
                lay(episodes[surface_array], i, tables.zones[:, min(number, tables.zones.shape[1] - 1)])
                write_stage(episodes.stages, i, with_stage(stage, (0.0, 0.0, 0.0)))
            episodes.memory[i, FOUND] = episodes.wheels[i, DIAMETER]
            results[i, TORQUE] = 0.0 if starts else episodes.memory[i, STALLED] * STALL
            seconds, speed = episodes.memory[i, CLOCK] + came + waited, tables.settings[i, E]
            moment = Moment(number=float(episodes.block[i]), seconds=seconds, place=row.place, E=speed)
            drive = before(episodes.wheels, tables.parameters, i, row.dwell, moment)
            surface, stock = 0.0 if starts else read_part(episodes.parts, i).Z, episodes.tape[i, place, STOCK]
            place_block(tables, i, row, number, surface, stock, choices.pre_dresses[i], drive)

    @entry
    def grind(tables: Tables, episodes: EpisodeArrays, choices: Choices, active: Any, results: Any) -> None:
        """Run the cycles."""
        grind_blocks(tables, episodes.wheels, episodes[surface_array], results, active)

    @entry
    def settle(
        tables: Tables, episodes: EpisodeArrays, choices: Choices, active: Any, results: Any, outcomes: Any
    ) -> None:
        """Write costs and readings, and advance to the next blocks."""
        shop = read_shop(tables.shops, 0)
        for i in active:
            number, p = tables.rows[i], read_parameters(tables.parameters, i)
            row, tally = read_block(tables.blocks, number), read_tally(results, i)
            wheel, stage = read_wheel(episodes.wheels, i), read_stage(episodes.stages, i)
            place, by_tape = place_of(episodes.block[i], episodes.tape.shape[1]), tables.lead[number] >= 0.0
            stock = row.stock if row.stock > 0.0 else episodes.tape[i, place, STOCK]
            stock = tables.places[i, FINISH] if by_tape else stock
            part, taper = gauge_part(episodes[surface_array], i, stock)
            write_part(episodes.parts, i, part)
            good = 1.0 if row.starts_part > 0.0 else episodes.memory[i, SURVIVAL]
            size_error = 1000.0 * (stock - part.S)
            cooler = tables.cooler[episodes.machine[i], min(number, tables.cooler.shape[1] - 1)]
            good, stage = judged(row, part, tally, stage, size_error, good, cooler)
            even = tally.strokes == 2.0 * np.floor(0.5 * tally.strokes)
            corner = (0 if even else 1) + (2 if tables.places[i, ACROSS] > 0.0 else 0)
            on_the_way, afterwards = tables.rest_times[number, corner, BEFORE], tables.rest_times[number, corner, AFTER]
            came, waited = came_and_waited(tables, number, row, stage)
            tally = with_seconds(tally, (came + waited + tally.seconds + on_the_way + afterwards,))
            results[i, SECONDS] = tally.seconds
            chosen = read_settings(tables.settings, i)
            change = 1.0 if row.gauged > 0.0 and wheel.ds < shop.least_diameter else 0.0
            rested = on_the_way
            if change > 0.0:
                pass_time(episodes.wheels, tables.parameters, i, rested, False)
                pass_time(episodes.wheels, tables.parameters, i, shop.change_seconds, False)
                rested = 0.0
                wheel = new_wheel(chosen, shop, wheel, p)
                write_wheel(episodes.wheels, i, wheel)
            last = episodes.block[i] + 1 == episodes.source[i, BLOCKS]
            handover = price_of_handover(read_settings(tables.own_settings, number), shop, wheel, p) if last else 0.0
            write_stage(episodes.stages, i, gone_on(stage, (afterwards, rested + afterwards)))
            taper, pre_dress = taper + error_of(episodes, i, tables.spreads), choices.pre_dresses[i]
            seen = Found(good, size_error, change, handover, tables.places[i, DEEPEST], taper)
            settle_one(i, tables.kinds, number, shop, episodes, chosen, pre_dress, by_tape, tally, seen, outcomes)
        draw_rows(
            episodes.tape, episodes.block, episodes.source, episodes.schedule, tables.drawn, tables.spreads, active
        )

    return prepare, grind, settle


@functools.cache
def step_of(process: Process, gauge: Gauge, covered: bool) -> Callable[..., None]:
    """Return the compiled step of scripts on parts that the wheel covers as a whole (`covered`), or in zones."""
    prepare, grind, settle = stages_of(process, gauge, covered)

    @entry
    def step(tables: Any, episodes: Any, choices: Any, active: Any, results: Any, outcomes: Any) -> None:
        """Grind the next block of the episodes in `active`.

        Args:
            tables: fields of `Tables`, as a tuple.
            episodes: fields of `EpisodeArrays`, as a tuple; updated.
            choices: fields of `Choices`, as a tuple.
            active: indices of the episodes to step, int64.
            results: shape (N, fields of `Tally`), all 0; written in the rows of `active`.
            outcomes: shape (N, fields of `Outcome`); written in the rows of `active`.
        """
        numbers, state, chosen = Tables(*tables), EpisodeArrays(*episodes), Choices(*choices)
        for first in range(0, active.size, TOGETHER):
            some = active[first : first + TOGETHER]
            prepare(numbers, state, chosen, some, results)
            grind(numbers, state, chosen, some, results)
            settle(numbers, state, chosen, some, results, outcomes)

    return step

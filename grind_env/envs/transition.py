"""The compiled step of every environment: load the part, run the cycle block, price it, read the gauges.

A row of the noise tape names the coming block: its row in the script (in a task, a kind of block in a material) and its
stock. Arrays are passed in plain tuples: a call with three tuples takes 1.8 us, with all arrays one by one 1.2 us, and
with named tuples 6 us.
"""

import functools
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from grind_env.belief.filter_quantities import FACTORS
from grind_env.envs.block_kind_rows import read_kind
from grind_env.envs.block_placement import place_block
from grind_env.envs.cost import Found, Shop, outcome_of, rates_of, read_found, read_shop, write_outcome
from grind_env.envs.noise_tape import (
    BLOCKS,
    KEY_0,
    KEY_1,
    NOISE_FACTOR,
    SPARE_FACTORS,
    TapeRow,
    draw_rows,
    place_of,
    read_row,
    read_sigmas,
)
from grind_env.envs.past_readings import (
    FOUND,
    History,
    booked_diameter,
    legible,
    noise_of,
    read_memory,
    remembered,
    truth_of,
    write_memory,
)
from grind_env.envs.random_numbers import TAPER, spread, words_of
from grind_env.envs.task_gauges import TAPER_NOISE
from grind_env.kernel import entry, inlined
from grind_env.kernel.random import normal, uniform
from grind_env.kernel.row_accessors import column_reader, column_writer, replacer
from grind_env.machine.dress.mounted_wheel import USUAL_DEPTH, USUAL_LEAD
from grind_env.machine.loops.block_change import shift_of
from grind_env.machine.loops.concurrent_strokes import FeedMotion
from grind_env.machine.loops.cycle import PartState, dress_lead
from grind_env.machine.loops.machine_lanes import CYCLE_FIELDS
from grind_env.machine.loops.row_io import (
    OWN_FROM,
    read_parameters,
    read_part,
    read_tally,
    read_wheel,
    read_zone,
    write_part,
    write_wheel,
    write_zone,
)
from grind_env.machine.loops.stroke_totals import Tally
from grind_env.machine.part.gauging import gauge_zones
from grind_env.machine.script.block_settings import BlockSettings, E, read_settings
from grind_env.machine.script.replay import BlockPlace, covered_blocks_of, read_block, zoned_blocks_of
from grind_env.machine.script.script_block import RestTimes
from grind_env.machine.script.script_tables import BlockRow
from grind_env.process.cost import STALL, Limits, handover_cost, survival
from grind_env.process.equations import INITIAL_ROUGHNESS
from grind_env.process.gauge_readings import Gauge
from grind_env.process.process_interface import Moment, Process, joined
from grind_env.process.stroke_and_dress import dressed_wheel
from grind_env.process.stroke_types import FORCES, StrokeParameters, WheelState

TOGETHER = 1024
"""Number of episodes that are prepared, ground and settled together; their rows fit into the processor's cache."""
DIAMETER, WEAR = WheelState._fields.index("ds"), WheelState._fields.index("W")
FACTOR_COLUMNS = tuple(TapeRow._fields.index(name) for name in FACTORS)
SPARE_COLUMNS = tuple(TapeRow._fields.index(name) for name in SPARE_FACTORS)
PARAMETER_COLUMNS = tuple(StrokeParameters._fields.index(name) for name in FACTORS)
FORCE_COLUMNS = tuple(StrokeParameters._fields.index(name) for name in FORCES)
KIND, MATERIAL, STOCK = (TapeRow._fields.index(name) for name in ("kind", "material", "stock"))
CHANGES, SURVIVAL, STALLED, CLOCK = (
    History._fields.index(name) for name in ("wheel_changes", "survival", "stalled", "clock")
)
SECONDS, TORQUE = Tally._fields.index("seconds"), Tally._fields.index("peak_torque")
BEFORE, AFTER = RestTimes._fields.index("before"), RestTimes._fields.index("after")
FINISH, DEEPEST, ACROSS = (BlockPlace._fields.index(name) for name in ("finish", "pick", "across"))
NEW_PART = PartState(Z=0.0, S=0.0, Rs=INITIAL_ROUGHNESS)


class StageSoFar(NamedTuple):
    """Results of a part since its last judgement, and times of the machine."""

    torque: float
    """Ratio of the highest torque of a stroke to the torque at which the spindle stalls."""
    rise: float
    """Highest temperature rise that counts, K."""
    gone: float
    """Time of the program since the last part was taken off, s."""
    gauged: float
    """1 if the wear of the wheel is known, else 0."""
    rested: float
    """Time since the last stroke, or since a wheel change after this stroke, s."""


read_stage, write_stage = column_reader(StageSoFar), column_writer(StageSoFar)
with_stage, gone_on = replacer(StageSoFar, "torque", "rise", "gauged"), replacer(StageSoFar, "gone", "rested")
with_seconds = replacer(Tally, "seconds")
with_words, write_row = replacer(BlockSettings, "E", "D"), column_writer(BlockSettings)
STAGE_FIELDS = len(StageSoFar._fields)


class Tables(NamedTuple):
    """A script, the numbers of its task or job, and room for N machines. The first six are those of `ScriptTables`."""

    blocks: Any
    plans: Any
    own_settings: Any
    rest_times: Any
    motions: Any
    zones: Any
    kinds: Any
    """Numbers of the kind of each row, shape (rows, fields of `KindRow`)."""
    base: Any
    """Parameters of each possible machine, shape (machines, 1 or rows, fields of `StrokeParameters`)."""
    cooler: Any
    """Limits of temperature of each machine less those of the rows, K, shape (machines, 1 or rows)."""
    shops: Any
    """Numbers of the task or job, shape (1, fields of `Shop`)."""
    drawn: Any
    """Numbers of the kinds for draws of tape rows, shape (kinds, fields of `DrawnKind`)."""
    spreads: Any
    """Spreads for draws of tape rows, shape (1, fields of `Sigmas`)."""
    lead: Any
    """Depth below the surface at which the cycle of a row begins that grinds the stock on the tape, mm, shape (rows,);
    negative for a row with depths in the script."""
    infeed: float
    """F of a G81 that grinds the stock on the tape, mm/s; else 0."""
    approach: float
    """Time of the program up to its first block, s."""
    parameters: Any
    """Room for the parameters of the machines, shape (N, fields of `StrokeParameters`)."""
    places: Any
    """Room for the places of the blocks, shape (N, fields of `BlockPlace`)."""
    rows: Any
    """Room for the script rows of the blocks, shape (N,), int64."""
    settings: Any
    """Room for the settings of the blocks, shape (N, fields of `BlockSettings`)."""
    cycles: Any
    """Room for the cycles of the blocks, shape (N, `CYCLE_FIELDS`)."""


class EpisodeArrays(NamedTuple):
    """The state of N episodes, as in `Episodes`; all but schedule, machine and forces are updated."""

    tape: Any
    """Shape (N, rows, fields of `TapeRow`)."""
    block: Any
    """Number of the coming block, shape (N,), int64."""
    wheels: Any
    """Shape (N, fields of `WheelState`, of `own` of the process, and of `own` of the gauge)."""
    parts: Any
    """Parts as gauged, shape (N, fields of `PartState`)."""
    memory: Any
    """Shape (N, fields of `History`)."""
    source: Any
    """Shape (N, SOURCE)."""
    schedule: Any
    """Shape (N, blocks), int16."""
    stages: Any
    """Shape (N, fields of `StageSoFar`)."""
    surfaces: Any
    """Surfaces of parts in zones, shape (N, zones, fields of `Zone`)."""
    machine: Any
    """Number of the machine of each episode, shape (N,), int64."""
    forces: Any
    """Factor on the forces in each row of the script, shape (N, 1 or rows)."""


class Choices(NamedTuple):
    """Choices for the coming block of N episodes; each of shape (N,) but for the settings."""

    speeds: Any
    """E, mm/min."""
    executions: Any
    """D."""
    pre_dresses: Any
    """1 for a dress before the first plunge, else 0."""
    settings: Any
    """All settings, shape (N, fields of `BlockSettings`); no rows if the other words are those of the script."""


class Scratch:
    """Reusable arrays of steps, because the system maps tens of MB slowly; each running step has its own arrays.

    Each machine has room for `motions` motions of a G81, which the step writes.
    """

    def __init__(self, motions: int = 0) -> None:
        self.motions = motions
        self._free: list[tuple[Any, ...]] = []

    def __reduce__(self) -> tuple[type["Scratch"], tuple[int]]:
        return Scratch, (self.motions,)

    def take(self, n: int) -> tuple[Any, ...]:
        """Return arrays of N rows or more: the fields of `Tables` from `parameters` on, and the motions."""
        try:  # two threads may take the last arrays at the same time
            room = self._free.pop()
        except IndexError:
            room = ()
        if room and len(room[0]) >= n:
            return room
        records = StrokeParameters, BlockPlace, BlockSettings
        parameters, places, settings = (np.empty((n, len(record._fields))) for record in records)
        motions = np.empty((n * self.motions, len(FeedMotion._fields)))
        return parameters, places, np.empty(n, np.int64), settings, np.empty((n, CYCLE_FIELDS)), motions

    def give_back(self, room: tuple[Any, ...]) -> None:
        """Free arrays for another step."""
        self._free.append(room)


class StepStages(NamedTuple):
    """The compiled parts of a step."""

    prepare: Callable[..., None]
    """`prepare(tables, episodes, choices, active, results)`: writes places of blocks, parameters and loaded parts, and
    into the results whether the spindle has stalled on the part before."""
    grind: Callable[..., None]
    """`grind(tables, episodes, choices, active, results)`: runs the cycles."""
    settle: Callable[..., None]
    """`settle(tables, episodes, choices, active, results, outcomes)`: writes costs and readings, and advances to the
    next blocks."""


class SurfaceStore(NamedTuple):
    """Functions for one way to store the surfaces of parts."""

    surfaces: str
    """Field of `EpisodeArrays` with the surfaces."""
    blocks_of: Callable[[Process], Callable[..., None]]
    """Function of `machine.script.replay` that returns the compiled grinding of blocks."""
    lay: Callable[..., None]
    """`lay(surfaces, i, zones)`: puts a new part on machine i."""
    gauge: Callable[..., tuple[PartState, float]]
    """`gauge(surfaces, i, stock)`: returns the part on machine i, with its size where it is farthest from `stock`, mm,
    and its taper, um."""
    error: Callable[..., float]
    """`error(episodes, i, spreads)`: returns the gauging error of the taper after the coming block of episode i, um."""


@inlined
def row_of(episodes: Any, i: int, place: int, shop: Shop) -> int:
    """Return the row of the script for the coming block of episode i."""
    return int(episodes.tape[i, place, KIND]) * int(shop.materials) + int(episodes.tape[i, place, MATERIAL])


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


@inlined
def price_of_handover(own: BlockSettings, shop: Shop, wheel: WheelState, p: StrokeParameters) -> float:
    """Return the price of the dull wheel that the last block leaves, $; 0 without a dress program to sharpen it with.

    `own` are the program's settings of the block, by which the next user dresses the wheel. Chosen dress settings do
    not count: they could make the handover cheaper in a block without a dress.
    """
    if own.dress_passes <= 0.0:
        return 0.0
    lead = dress_lead(wheel, own.dress_feed, p)
    return handover_cost(wheel, own.dress_passes, lead, own.dress_depth, own.dress_seconds, p, rates_of(shop))


@functools.cache
def settle_of(process: Process, gauge: Gauge) -> tuple[Callable[..., None], Callable[..., None]]:
    """Return the compiled settling of finished blocks, `settle_one` and `settle_blocks`."""
    read, own = gauge.read, joined(process.own, gauge.own)
    read_own, write_own = column_reader(own, OWN_FROM), column_writer(own, OWN_FROM)

    @inlined
    def settle_one(
        i: int,
        kinds: Any,
        number: int,
        shop: Shop,
        episodes: Any,
        chosen: BlockSettings,
        pre_dress: float,
        by_tape: bool,
        tally: Tally,
        seen: Found,
        outcomes: Any,
    ) -> None:
        place = place_of(episodes.block[i], episodes.tape.shape[1])
        kind, row = read_kind(kinds, number), read_row(episodes.tape[i], place)
        part, old = read_part(episodes.parts, i), read_memory(episodes.memory, i)
        outcome = outcome_of(kind, row, shop, part, tally, old.clock, old.found_diameter, seen)
        write_outcome(outcomes, i, outcome)
        # the wheel is touched off on the next part
        truth = truth_of(tally, outcome, episodes.wheels[i, DIAMETER])
        shown, own = read(truth, read_own(episodes.wheels, i), old.clock + outcome.seconds, noise_of(row))
        write_own(episodes.wheels, i, own)
        shown = legible(shown, tally, seen.change)
        # executions are at equal intervals of depth: an equal share of the stock on the tape follows the last one
        share = row.gauged * kind.length / (tally.dresses - pre_dress + 1.0)
        volume = share if by_tape else tally.deepened * kind.length
        off = 2.0 * tally.dresses * chosen.dress_passes * chosen.dress_depth
        # in a task every block is gauged; in a program the wheel diameter is entered in the book between parts
        diameter = booked_diameter(shown, shop, old, off, by_tape or kind.ends_part > 0.0, seen.change)
        new = remembered(kind, tally, old, shown, outcome, seen, chosen, pre_dress, volume, diameter)
        write_memory(episodes.memory, i, new)
        episodes.block[i] += 1

    @entry
    def settle_blocks(
        kinds: Any,
        shops: Any,
        episodes: EpisodeArrays,
        settings: Any,
        active: Any,
        tallies: Any,
        found: Any,
        outcomes: Any,
    ) -> None:
        """Write costs and readings of blocks that were run elsewhere, and advance to the next blocks.

        `settings` of the blocks have shape (N, fields of `BlockSettings`), `found` has (N, fields of `Found`). Tallies
        have all the time of their blocks; the other arguments are as for a step.
        """
        shop = read_shop(shops, 0)
        for i in active:
            number = row_of(episodes, i, place_of(episodes.block[i], episodes.tape.shape[1]), shop)
            chosen, tally, seen = read_settings(settings, i), read_tally(tallies, i), read_found(found, i)
            settle_one(i, kinds, number, shop, episodes, chosen, 0.0, False, tally, seen, outcomes)

    return settle_one, settle_blocks


@functools.cache
def stages_of(process: Process, gauge: Gauge, covered: bool) -> StepStages:
    """Return the parts of the step of scripts on parts that the wheel covers as a whole (`covered`), or in zones."""
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
        grind_blocks(tables, episodes.wheels, episodes[surface_array], results, active)

    @entry
    def settle(
        tables: Tables, episodes: EpisodeArrays, choices: Choices, active: Any, results: Any, outcomes: Any
    ) -> None:
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

    return StepStages(prepare, grind, settle)


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


@inlined
def _lay_covered(surfaces: Any, i: int, zones: Any) -> None:
    write_part(surfaces, i, NEW_PART)


@inlined
def _gauge_covered(surfaces: Any, i: int, stock: float) -> tuple[PartState, float]:
    return read_part(surfaces, i), 0.0


@inlined
def _none(episodes: Any, i: int, spreads: Any) -> float:
    return 0.0


@inlined
def _lay_zones(surfaces: Any, i: int, zones: Any) -> None:
    for number in range(zones.shape[0]):
        write_zone(surfaces[i], number, read_zone(zones, number))


@inlined
def _gauge_zones(surfaces: Any, i: int, stock: float) -> tuple[PartState, float]:
    found = gauge_zones(surfaces[i], stock)
    # if no stroke has reached one zone, the whole part counts as not reached
    reached = read_zone(surfaces[i], 0).reached
    for number in range(surfaces.shape[1]):
        reached = min(reached, read_zone(surfaces[i], number).reached)
    S = stock - 0.001 * found.worst_error
    return PartState(Z=reached, S=S, Rs=found.Ra, S_step=0.0, Rs_step=0.0), found.taper


@inlined
def _taper_error(episodes: Any, i: int, spreads: Any) -> float:
    sigma = episodes.source[i, NOISE_FACTOR] * read_sigmas(spreads, 0).measurement * TAPER_NOISE
    word, _, _, _ = words_of(episodes.source[i, KEY_0], episodes.source[i, KEY_1], TAPER, episodes.block[i])
    return spread(sigma, normal(uniform(word)))


COVERED = SurfaceStore("parts", covered_blocks_of, _lay_covered, _gauge_covered, _none)
IN_ZONES = SurfaceStore("surfaces", zoned_blocks_of, _lay_zones, _gauge_zones, _taper_error)

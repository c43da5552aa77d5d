"""The step of `grind/Job-v0`: a block of a script, and what has come of it."""

import functools
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from grind_env.envs.blocks.settling import (
    booked_diameter,
    counted_rise,
    legible,
    noise_of,
    outcome_of,
    remembered,
    truth_of,
)
from grind_env.envs.blocks.step import CHANGES, DIAMETER, NEW_PART, write_factored
from grind_env.envs.step import Work, step_of
from grind_env.envs.tables import (
    FOUND,
    Shop,
    ShopMemory,
    read_kind,
    read_memory,
    read_shop,
    write_memory,
    write_outcome,
)
from grind_env.envs.tape import TapeRow, read_row
from grind_env.kernel import entry, inlined
from grind_env.kernel.columns import column_reader, column_writer, replacer
from grind_env.machine.dress.mounting import USUAL_DEPTH, USUAL_LEAD
from grind_env.machine.loops.cycle import PartState, dress_lead, measured
from grind_env.machine.loops.rows import (
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
from grind_env.machine.loops.shift import shift_of
from grind_env.machine.loops.tally import Tally
from grind_env.machine.part.gauging import gauge_zones
from grind_env.machine.script.block import RestTimes
from grind_env.machine.script.replay import read_block, whole_blocks_of, zoned_blocks_of
from grind_env.machine.script.settings import BlockSettings, read_settings
from grind_env.machine.script.tables import BlockRow
from grind_env.process.cost import STALL, Limits, Rates, handover_cost, survival
from grind_env.process.gauge import Gauge
from grind_env.process.process import Drive, Moment, Process, joined
from grind_env.process.state import FORCES, StrokeParameters, WheelState
from grind_env.process.stroke import dressed_wheel


class StageSoFar(NamedTuple):
    """What a part has come to since the operator last judged it, and where the machine stands."""

    torque: float
    """Highest torque of a stroke over that at which the spindle stalls."""
    rise: float
    """Highest temperature rise that counts, K."""
    gone: float
    """Time of the program since the last part was taken off, s."""
    gauged: float
    """1 if the wear of the wheel is known, else 0."""
    rested: float
    """Time since the last stroke, or since the wheel was changed after it, s."""


class Found(NamedTuple):
    """What is found after a block."""

    good: float
    """Probability that the part is good so far; of several parts finished in one block their mean."""
    size_error: float
    """Stock left where the part is farthest from its size, um."""
    change: float
    """1 if the wheel is changed, else 0."""
    handover: float
    """Price of handing over the wheel, $."""
    pick: float
    """By how much a stroke has gone deeper at most, mm."""


read_stage, write_stage = column_reader(StageSoFar), column_writer(StageSoFar)
with_stage, gone_on = replacer(StageSoFar, "torque", "rise", "gauged"), replacer(StageSoFar, "gone", "rested")
write_drive = column_writer(Drive)
read_found, write_found = column_reader(Found), column_writer(Found)
STAGE_FIELDS, FOUND_FIELDS = len(StageSoFar._fields), len(Found._fields)
STOCK, SURVIVAL = TapeRow._fields.index("stock"), ShopMemory._fields.index("survival")
BEFORE, AFTER = RestTimes._fields.index("before"), RestTimes._fields.index("after")
PICK = ShopMemory._fields.index("pick")
FORCE_COLUMNS = tuple(StrokeParameters._fields.index(name) for name in FORCES)
CLOCK = ShopMemory._fields.index("clock")
SECONDS, TORQUE = Tally._fields.index("seconds"), Tally._fields.index("peak_torque")


@inlined
def place_of(episodes: Any, i: int) -> int:
    """Row of the block of episode i on its tape, which begins with block `first`."""
    place: int = min(episodes.block[i] - episodes.first[i], episodes.tape.shape[1] - 1)
    return place


@inlined
def on_the_part(row: BlockRow, stage: StageSoFar, wheel: WheelState) -> tuple[StageSoFar, WheelState]:
    """Stage and wheel as a block finds them; of a wheel that has been touched off or gauged the wear is compensated."""
    starts = row.starts_part > 0.0
    if starts or stage.gauged > 0.0:
        wheel = measured(wheel)
    if starts:
        stage = with_stage(stage, (0.0, 0.0, 0.0))
    return stage, wheel


@inlined
def write_forces(parameters: Any, i: int, factor: float) -> None:
    """Scale all forces of episode i."""
    for column in FORCE_COLUMNS:
        parameters[i, column] *= factor


@inlined
def judged(
    row: BlockRow, part: PartState, tally: Tally, stage: StageSoFar, size_error: float, before: float, cooler: float
) -> tuple[float, StageSoFar]:
    """Probability that the part is good so far, and what its stage has come to.

    Args:
        row: of the block.
        part: after it.
        tally: of the block.
        stage: before it.
        size_error: um.
        before: probability that the part was good before the block.
        cooler: by how much the limit of temperature lies above that of the block, K.
    """
    torque = max(stage.torque, tally.peak_torque)
    rise = max(stage.rise, tally.plunge_rise if row.counts_all > 0.0 else tally.finish_rise)
    good = before
    if row.judged > 0.0:
        limits = Limits(rise=row.rise + cooler, power=row.power, roughness=row.roughness, size=row.size)
        good = before * survival(rise, torque, part.Rs, size_error, limits)
        torque, rise = (torque if torque >= STALL else 0.0), 0.0
    if row.ends_part > 0.0 and part.Z <= 0.0:  # no stroke has reached some of it
        good = 0.0
    return good, with_stage(stage, (torque, rise, row.gauged))


@inlined
def new_wheel(settings: BlockSettings, shop: Shop, worn: WheelState, p: StrokeParameters) -> WheelState:
    """The wheel that comes in place of a worn one, dressed as the block is: the operator runs its dress program."""
    wheel = dressed_wheel(shop.new_diameter, worn.wd, USUAL_LEAD, USUAL_DEPTH, p)
    if settings.dress_passes > 0.0:
        lead = dress_lead(wheel, settings.dress_feed, p)
        wheel = dressed_wheel(shop.new_diameter, worn.wd, lead, settings.dress_depth, p)
    return wheel


@inlined
def price_of_handover(own: BlockSettings, shop: Shop, wheel: WheelState, p: StrokeParameters) -> float:
    """Price of the dull wheel that the last block leaves, $; 0 without a dress program to sharpen it with.

    `own` are the program's settings of that block: who gets the wheel sharpens it as the program says, and no choice in
    a block that perhaps dresses nothing makes that cheaper.
    """
    if own.dress_passes <= 0.0:
        return 0.0
    rates = Rates(shop.hourly, shop.wheel_price, shop.dress_price)
    lead = dress_lead(wheel, own.dress_feed, p)
    return handover_cost(wheel, own.dress_passes, lead, own.dress_depth, own.dress_seconds, p, rates)


class JobTables(NamedTuple):
    """A program, the numbers of its job, and room for N machines. The first six are those of `ScriptTables`."""

    blocks: Any
    plans: Any
    own: Any
    ways: Any
    motions: Any
    zones: Any
    kinds: Any
    """Of each block, shape (blocks, fields of `KindRow`)."""
    base: Any
    """Parameters of each machine that this may be, shape (machines, 1 or blocks, fields of `StrokeParameters`)."""
    cooler: Any
    """By how much the limits of temperature of each lie above those of the blocks, K, shape (machines, 1 or blocks)."""
    shops: Any
    """Numbers of the job, shape (1, fields of `Shop`)."""
    approach: float
    """Time of the program up to its first block, s."""
    parameters: Any
    """Room for those of the machines, shape (N, fields of `StrokeParameters`)."""
    picks: Any
    """Room for the deepest picks, mm, shape (N,)."""
    across: Any
    """Room for whether the wheel stands where a crossover ends, shape (N,)."""
    drives: Any
    """Room for what the tables make of their commands, shape (N, fields of `Drive`)."""


class JobArrays(NamedTuple):
    """The state of N episodes, as in `simulation.JobEpisodes`; all but the tape and `first` are updated.

    The first five are as in `EpisodeArrays`, but the last row of a tape holds for all blocks after it.
    """

    tape: Any
    block: Any
    wheels: Any
    parts: Any
    """As they are gauged."""
    memory: Any
    stages: Any
    """Shape (N, fields of `StageSoFar`)."""
    surfaces: Any
    """Of parts in zones, shape (N, zones, fields of `Zone`)."""
    first: Any
    """Number of the block that each tape begins with, shape (N,), int64."""
    machine: Any
    """Number of the machine on which each runs, shape (N,), int64."""
    forces: Any
    """Factor on the forces in each block, shape (N, 1 or blocks)."""


class JobChoices(NamedTuple):
    """What is chosen for the coming blocks."""

    settings: Any
    """Shape (N, fields of `BlockSettings`)."""


@functools.cache
def settle_of(process: Process, gauge: Gauge) -> Callable[..., None]:
    """What is compiled of blocks that have been run, `settle_jobs`, with what grinds and what is measured."""
    read, own = gauge.read, joined(process.own, gauge.own)
    read_own, write_own = column_reader(own, OWN_FROM), column_writer(own, OWN_FROM)

    @entry
    def settle_jobs(
        kinds: Any,
        shops: Any,
        episodes: JobArrays,
        settings: Any,
        active: Any,
        tallies: Any,
        found: Any,
        outcomes: Any,
    ) -> None:
        """Write what the blocks that were run have cost and shown, and go on to the next ones.

        Args:
            kinds: of `JobTables`, like the next one.
            shops: numbers of the job.
            episodes: their memory and block numbers are updated.
            settings: of the blocks, shape (N, fields of `BlockSettings`).
            active: indices of the episodes.
            tallies: of the blocks, with all their time.
            found: shape (N, fields of `Found`).
            outcomes: written.
        """
        shop, block = read_shop(shops, 0), episodes.block
        for i in active:
            kind, row = read_kind(kinds, block[i]), read_row(episodes.tape[i], place_of(episodes, i))
            part, tally, old = read_part(episodes.parts, i), read_tally(tallies, i), read_memory(episodes.memory, i)
            chosen, seen = read_settings(settings, i), read_found(found, i)
            rise = counted_rise(kind, tally)
            outcome = outcome_of(
                kind, row, shop, part, tally, old, seen.size_error, rise, seen.good, seen.change, seen.handover
            )
            write_outcome(outcomes, i, outcome)
            # the wheel is touched off on the next part
            truth = truth_of(tally, outcome, episodes.wheels[i, DIAMETER])
            shown, own = read(truth, read_own(episodes.wheels, i), old.clock + outcome.seconds, noise_of(row))
            write_own(episodes.wheels, i, own)
            shown = legible(shown, tally, seen.change)
            volume = tally.deepened * kind.length
            off = 2.0 * tally.dresses * chosen.dress_passes * chosen.dress_depth
            diameter = booked_diameter(shown, shop, old, off, kind.ends_part > 0.0, seen.change)
            good, change, E, D = seen.good, seen.change, chosen.E, chosen.D
            new = remembered(kind, tally, old, shown, outcome, good, change, E, D, 0.0, volume, diameter)
            write_memory(episodes.memory, i, new)
            episodes.memory[i, PICK] = seen.pick
            block[i] += 1

    return settle_jobs


class Kept(NamedTuple):
    """A way to keep the surfaces of parts."""

    surfaces: str
    """What of `JobArrays` holds them."""
    blocks_of: Callable[[Process], Callable[..., None]]
    """Of `machine.script.replay`."""
    lay: Callable[..., None]
    """`lay(surfaces, i, zones)`: puts a new part on machine i."""
    gauge: Callable[..., PartState]
    """`gauge(surfaces, i, stock)`: the part on machine i, with its size where it is farthest from a stock, mm."""


@functools.cache
def jobs_step(process: Process, gauge: Gauge, whole: bool) -> Callable[..., None]:
    """The compiled step of a script on parts that the wheel covers in the `whole`, or in zones."""
    surfaces, blocks_of, lay, gauge_part = KEPT_WHOLE if whole else KEPT_IN_ZONES
    kept, grind_blocks = JobArrays._fields.index(surfaces), blocks_of(process)
    (pass_time, before), settle_jobs = shift_of(process), settle_of(process, gauge)

    @inlined
    def came_and_waited(tables: JobTables, number: int, row: BlockRow, stage: StageSoFar) -> tuple[float, float]:
        """Time on the way to the first block, and that for which the machine waits for a part to be ready, s."""
        came = tables.approach if number == 0 else 0.0
        gone = tables.approach if number == 0 else stage.gone
        return came, max(row.wait - gone, 0.0)

    @entry
    def prepare(tables: JobTables, episodes: JobArrays, choices: JobChoices, active: Any, results: Any) -> None:
        for i in active:
            number = episodes.block[i]
            row, stage = read_block(tables.blocks, number), read_stage(episodes.stages, i)
            changed = episodes.memory[i, CHANGES] > 0.0
            base, place = tables.base[episodes.machine[i]], place_of(episodes, i)
            write_factored(tables.parameters, i, base, min(number, base.shape[0] - 1), episodes.tape, place, changed)
            write_forces(tables.parameters, i, episodes.forces[i, min(number, episodes.forces.shape[1] - 1)])
            came, waited = came_and_waited(tables, number, row, stage)
            starts, rested = row.starts_part > 0.0, stage.rested + came + waited
            pass_time(episodes.wheels, tables.parameters, i, rested, starts)
            stage, wheel = on_the_part(row, stage, read_wheel(episodes.wheels, i))
            if starts:
                lay(episodes[kept], i, tables.zones[:, min(number, tables.zones.shape[1] - 1)])
            write_stage(episodes.stages, i, stage)
            write_wheel(episodes.wheels, i, wheel)
            episodes.memory[i, FOUND] = wheel.ds
            results[i, TORQUE] = stage.torque if stage.torque >= STALL else 0.0
            seconds, E = episodes.memory[i, CLOCK] + came + waited, read_settings(choices.settings, i).E
            moment = Moment(number=float(number), seconds=seconds, place=row.place, E=E)
            write_drive(tables.drives, i, before(episodes.wheels, tables.parameters, i, row.dwell, moment))

    @entry
    def grind(tables: JobTables, episodes: JobArrays, choices: JobChoices, active: Any, results: Any) -> None:
        grind_blocks(
            tables,
            episodes.block,
            choices.settings,
            tables.drives,
            tables.parameters,
            episodes.wheels,
            episodes[kept],
            results,
            tables.picks,
            tables.across,
            active,
        )

    @entry
    def settle(
        tables: JobTables, episodes: JobArrays, choices: JobChoices, active: Any, results: Any, outcomes: Any
    ) -> None:
        shop, found = read_shop(tables.shops, 0), np.empty((episodes.block.size, FOUND_FIELDS))
        for i in active:
            number, p = episodes.block[i], read_parameters(tables.parameters, i)
            row, tally = read_block(tables.blocks, number), read_tally(results, i)
            wheel, stage = read_wheel(episodes.wheels, i), read_stage(episodes.stages, i)
            stock = row.stock if row.stock > 0.0 else episodes.tape[i, place_of(episodes, i), STOCK]
            part = gauge_part(episodes[kept], i, stock)
            write_part(episodes.parts, i, part)
            before = 1.0 if row.starts_part > 0.0 else episodes.memory[i, SURVIVAL]
            size_error = 1000.0 * (stock - part.S)
            cooler = tables.cooler[episodes.machine[i], min(number, tables.cooler.shape[1] - 1)]
            good, stage = judged(row, part, tally, stage, size_error, before, cooler)
            even = tally.strokes == 2.0 * np.floor(0.5 * tally.strokes)
            corner = (0 if even else 1) + (2 if tables.across[i] > 0.0 else 0)
            on_the_way, afterwards = tables.ways[number, corner, BEFORE], tables.ways[number, corner, AFTER]
            came, waited = came_and_waited(tables, number, row, stage)
            results[i, SECONDS] = came + waited + tally.seconds + on_the_way + afterwards
            change = 1.0 if row.gauged > 0.0 and wheel.ds < shop.least_diameter else 0.0
            rested = on_the_way
            if change > 0.0:
                pass_time(episodes.wheels, tables.parameters, i, rested, False)
                pass_time(episodes.wheels, tables.parameters, i, shop.change_seconds, False)
                rested = 0.0
                wheel = new_wheel(read_settings(choices.settings, i), shop, wheel, p)
                write_wheel(episodes.wheels, i, wheel)
            last = number + 1 == len(tables.blocks)
            handover = price_of_handover(read_settings(tables.own, number), shop, wheel, p) if last else 0.0
            write_stage(episodes.stages, i, gone_on(stage, (afterwards, rested + afterwards)))
            seen = Found(good=good, size_error=size_error, change=change, handover=handover, pick=tables.picks[i])
            write_found(found, i, seen)
        settle_jobs(tables.kinds, tables.shops, episodes, choices.settings, active, results, found, outcomes)

    return step_of(Work(JobTables, JobArrays, JobChoices, prepare, grind, settle))


@inlined
def _lay_whole(surfaces: Any, i: int, zones: Any) -> None:
    write_part(surfaces, i, NEW_PART)


@inlined
def _gauge_whole(surfaces: Any, i: int, stock: float) -> PartState:
    part: PartState = read_part(surfaces, i)
    return part


@inlined
def _lay_zones(surfaces: Any, i: int, zones: Any) -> None:
    for number in range(zones.shape[0]):
        write_zone(surfaces[i], number, read_zone(zones, number))


@inlined
def _gauge_zones(surfaces: Any, i: int, stock: float) -> PartState:
    found = gauge_zones(surfaces[i], stock)
    # a zone that no stroke has reached counts as all of them
    reached = read_zone(surfaces[i], 0).reached
    for number in range(surfaces.shape[1]):
        reached = min(reached, read_zone(surfaces[i], number).reached)
    return PartState(Z=reached, S=stock - 0.001 * found.worst_error, Rs=found.Ra)


KEPT_WHOLE = Kept("parts", whole_blocks_of, _lay_whole, _gauge_whole)
KEPT_IN_ZONES = Kept("surfaces", zoned_blocks_of, _lay_zones, _gauge_zones)

"""Memory of the shop floor from block to block, and the readings that enter it."""

from typing import NamedTuple

from grind_env.envs.block_kind_rows import KindRow
from grind_env.envs.cost import Found, Outcome, Shop
from grind_env.envs.noise_tape import TapeRow
from grind_env.kernel import inlined
from grind_env.kernel.row_accessors import column_reader, column_writer, replacer
from grind_env.machine.loops.stroke_totals import Tally, has_stalled, mean_first_power, mean_last_power
from grind_env.machine.script.block_settings import BlockSettings
from grind_env.process.gauge_readings import GaugeReadings

GAUGE_EVERY = 3  #: parts from one roughness gauging to the next


class History(NamedTuple):
    """Memory of the shop floor from block to block.

    `speed` is E in mm/min, `pick` and `width` are mm, of the last block. The readings `mean_power`, `first_power` and
    `peak_power` are W, `size_error` is um. `roughness` is a ratio to its limit. `executions` (of the last block),
    `since_gauged`, `blocks_since_dress`, `dresses`, `parts` and `wheel_changes` are numbers of executions, parts,
    blocks or changes.
    """

    speed: float
    executions: float
    pick: float
    width: float
    mean_power: float
    first_power: float
    peak_power: float
    size_error: float
    roughness: float
    #: ratio to its limit of a gauged roughness that the shop does not know yet; negative if there is none
    gauged: float
    since_gauged: float
    volume: float  #: volume ground since the last dress, mm3/mm: depth from the pre-gauge times length
    blocks_since_dress: float
    dresses: float
    parts: float
    survival: float  #: probability that the part in work is still good
    stalled: float  #: 1 if the spindle has stalled on the part in work
    pre_dress: float  #: 1 if the last block began with a dress
    clock: float  #: time since the start of the episode, s
    wheel_changes: float
    diameter: float  #: wheel diameter in the shop's book, mm: dresses are subtracted at once, wear when it is gauged
    #: True wheel diameter before the block, mm; not observed, but it limits how much wear and dresses can remove
    found_diameter: float
    taper: float  #: gauged taper of the last finished part, um; 0 for a part that the wheel covers


read_memory, write_memory = column_reader(History), column_writer(History)
FOUND = History._fields.index("found_diameter")
with_powers = replacer(GaugeReadings, "mean_power", "first_power", "peak_power")


@inlined
def booked_diameter(shown: GaugeReadings, shop: Shop, old: History, off: float, gauged: bool, change: float) -> float:
    """Return the wheel diameter in the shop's book after a block, mm, whose dresses have removed `off` mm.

    If `gauged`, the wear is gauged before the next block; `change` is 1 if the wheel is changed after this block.
    """
    known = shown.diameter if gauged else old.diameter - off
    return shop.new_diameter if change > 0.0 else known


@inlined
def truth_of(result: Tally, outcome: Outcome, diameter: float) -> GaugeReadings:
    """Return the true values that meter and gauges would read after a block; the wheel's diameter in mm."""
    return GaugeReadings(
        mean_power=mean_last_power(result),
        first_power=mean_first_power(result),
        peak_power=result.peak_load,
        size_error=outcome.size_error,
        roughness=outcome.roughness_ratio,
        diameter=diameter,
    )


@inlined
def noise_of(row: TapeRow) -> GaugeReadings:
    """Return the noise of the readings of meter and gauges after a block."""
    return GaugeReadings(
        mean_power=row.mean_noise,
        first_power=row.first_noise,
        peak_power=row.peak_noise,
        size_error=row.size_noise,
        roughness=row.roughness_noise,
        diameter=row.wheel_noise,
    )


@inlined
def legible(shown: GaugeReadings, result: Tally, change: float) -> GaugeReadings:
    """Return readings with 0 for each power that was not read; `change` is 1 for a wheel change after the block."""
    # nothing is known of a new wheel yet
    mean = shown.mean_power if result.last_count > 0.0 and change == 0.0 else 0.0
    first = shown.first_power if result.first_count > 0.0 else 0.0
    # there is no peak if the wheel has only passed above a part on which the spindle had stalled
    peak = shown.peak_power if result.peak_load > 0.0 else 0.0
    return with_powers(shown, (mean, first, peak))


@inlined
def remembered(
    kind: KindRow,
    result: Tally,
    old: History,
    shown: GaugeReadings,
    outcome: Outcome,
    found: Found,
    chosen: BlockSettings,
    pre_dress: float,
    volume: float,
    diameter: float,
) -> History:
    """Return the memory after a block; `pre_dress` is 1 if the block began with a dress.

    `shown` are the readings of the block, `chosen` its settings. `volume` since its last dress, mm3/mm, and `diameter`
    of the wheel after it, mm, come from book-keeping. `outcome` is the result of `outcome_of`, which explains the other
    arguments.
    """
    ends = kind.ends_part > 0.0
    size_error = shown.size_error if ends else old.size_error
    known = ends and old.gauged >= 0.0
    roughness = old.gauged if known else old.roughness
    since_gauged = 1.0 if known else old.since_gauged + outcome.finished
    gauged = -1.0 if ends else old.gauged
    if ends and int(old.parts) % GAUGE_EVERY == 0:
        gauged = shown.roughness
    taper = found.taper if ends else old.taper
    sharpened = result.dresses + found.change > 0.0
    stalled = 1.0 if has_stalled(result) else 0.0
    volume = (0.0 if found.change > 0.0 else volume) + (0.0 if sharpened else old.volume)
    blocks_since_dress = 0.0 if sharpened else old.blocks_since_dress + 1.0
    return History(
        speed=chosen.E,
        executions=chosen.D,
        pick=found.pick,
        width=kind.width,
        mean_power=shown.mean_power,
        first_power=shown.first_power,
        peak_power=shown.peak_power,
        size_error=size_error,
        roughness=roughness,
        gauged=gauged,
        since_gauged=since_gauged,
        volume=volume,
        blocks_since_dress=blocks_since_dress,
        dresses=old.dresses + result.dresses,
        parts=old.parts + outcome.finished,
        survival=found.good,
        stalled=stalled,
        pre_dress=pre_dress,
        clock=old.clock + outcome.seconds,
        wheel_changes=old.wheel_changes + found.change,
        diameter=diameter,
        found_diameter=old.found_diameter,
        taper=taper,
    )

"""Settling of a finished block: its costs, the readings of the gauges, and the price of the wheel handed over."""

import functools
from collections.abc import Callable
from typing import Any

from grind_env.envs.block_kind_rows import read_kind
from grind_env.envs.cost import Found, Shop, outcome_of, rates_of, read_found, read_shop, write_outcome
from grind_env.envs.noise_tape import place_of, read_row
from grind_env.envs.past_readings import (
    booked_diameter,
    legible,
    noise_of,
    read_memory,
    remembered,
    truth_of,
    write_memory,
)
from grind_env.envs.step_arrays import EpisodeArrays, row_of
from grind_env.kernel import entry, inlined
from grind_env.kernel.row_accessors import column_reader, column_writer
from grind_env.machine.loops.cycle import dress_lead
from grind_env.machine.loops.row_io import OWN_FROM, read_part, read_tally
from grind_env.machine.loops.stroke_totals import Tally
from grind_env.machine.script.block_settings import BlockSettings, read_settings
from grind_env.process.cost import handover_cost
from grind_env.process.gauge_readings import Gauge
from grind_env.process.process_interface import Process, joined
from grind_env.process.stroke_types import StrokeParameters, WheelState

DIAMETER = WheelState._fields.index("ds")


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

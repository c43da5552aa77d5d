"""The place of a cycle block on its part: from the script, or from the stock on the noise tape."""

from typing import Any

from grind_env.envs.block_kind_rows import read_kind
from grind_env.envs.programmed_infeed import infeed_of, write_motions
from grind_env.kernel import inlined
from grind_env.machine.script.block_settings import D, E, J
from grind_env.machine.script.replay import BlockPlace, place_as_programmed, read_plan, write_place
from grind_env.machine.script.script_tables import BlockRow
from grind_env.process.process_interface import Drive


@inlined
def place_block(
    tables: Any, i: int, row: BlockRow, number: int, surface: float, stock: float, pre_dress: float, drive: Drive
) -> None:
    """Write the place of the block of machine i, which is row `number` of the script.

    A block of a task grinds `stock`, mm, below `surface`, mm; `pre_dress` is 1 if it begins with a dress.
    """
    if tables.infeed > 0.0:
        _place_infeed(tables, i, row, number, stock, pre_dress, drive)
    elif tables.lead[number] >= 0.0:
        pick, target = tables.settings[i, J], surface + stock
        first = min(surface + pick, target)
        start = min(surface + tables.lead[number], target)
        here = start, first + (target - first), target, target, target - start
        # the rest times after a block of a task are equal at all ends of its strokes
        write_place(tables.places, i, BlockPlace(*here, pre_dress, row.motion, pick, drive.share, drive.dwell, -1.0))
    else:
        place_as_programmed(tables.places, i, row, read_plan(tables.plans, number), drive)


@inlined
def _place_infeed(
    tables: Any, i: int, row: BlockRow, number: int, stock: float, pre_dress: float, drive: Drive
) -> None:
    """Write place and motions of a G81 that grinds `stock`, mm; the dwells depend on E and D."""
    speed, requests = drive.share * tables.settings[i, E], tables.settings[i, D]
    table = drive.dwell, requests, row.acceleration, tables.infeed
    infeed = infeed_of(row.stroke_length, read_kind(tables.kinds, number).sparkout, stock, speed, *table)
    motion = i * (tables.motions.shape[0] // tables.rows.size)
    write_motions(tables.motions, motion, infeed)
    pick = infeed.rate * (infeed.travel + infeed.dwell)
    here = 0.0, stock, stock, stock, stock
    write_place(tables.places, i, BlockPlace(*here, pre_dress, float(motion), pick, drive.share, drive.dwell, 0.0))

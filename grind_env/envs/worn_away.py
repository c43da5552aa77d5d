"""What a block comes to that wears the whole wheel away, as contexts can make it: a soft wheel in a hard material.

A wheel has no size, force or power once nothing is left of it, so the block has no numbers to be judged by. It costs
the time of its motions and all the volume that a new wheel could have given up, its part is scrap, and the next block
begins with a new, dressed wheel of the same lot. A wheel that is only thinner than its least diameter grinds on, as on
the machine. Narrower ranges of the factors would not do: in inconel_718 the widest slot wears a nominal wheel away.
"""

import math
from typing import Any

import numpy as np

from grind_env.envs.rows import Shop
from grind_env.kernel import entry
from grind_env.kernel.rows import column_reader, column_writer
from grind_env.machine.cycle import CycleResult, PartState, dress_lead
from grind_env.process.equations import INITIAL_ROUGHNESS
from grind_env.process.state import StrokeParameters, WheelState
from grind_env.process.stroke import dressed_wheel

DIAMETER = WheelState._fields.index("ds")

read_result, write_result = column_reader(CycleResult), column_writer(CycleResult)
write_wheel, write_part = column_writer(WheelState), column_writer(PartState)


@entry
def renew_lost_wheel(
    i: int, shop: Shop, p: StrokeParameters, width: float, target: float, wheels: Any, parts: Any, results: Any
) -> bool:
    """Write a new wheel, and what has become of the block, if nothing is left of the wheel of episode i.

    Args:
        i: the episode.
        shop: numbers of the task.
        p: parameters of the block.
        width: of the block, mm.
        target: depth of the block, mm.
        wheels: shape (N, fields of `WheelState`); row i is updated, like in the next two.
        parts: shape (N, fields of `PartState`).
        results: shape (N, fields of `CycleResult`).

    Returns:
        Whether the wheel was lost.
    """
    total = wheels[i].sum() + parts[i].sum() + results[i].sum()
    if wheels[i, DIAMETER] > 0.0 and np.isfinite(total):
        return False
    bare = WheelState(shop.new_diameter, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    lead = dress_lead(bare, shop.dress_feed, p)
    write_wheel(wheels, i, dressed_wheel(shop.new_diameter, 0.0, lead, shop.dress_depth, p))
    write_part(parts, i, PartState(target, target, INITIAL_ROUGHNESS))
    result = read_result(results, i)
    ring = 0.25 * math.pi * (shop.new_diameter**2 - shop.spent_diameter**2) * width
    write_result(
        results,
        i,
        CycleResult(result.seconds, result.strokes, result.dresses, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, ring, 0.0),
    )
    return True

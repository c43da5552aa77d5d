"""The numbers of a task and of an episode that the compiled step works on, as named tuples of floats.

`kind_table` and `parameter_table` have a row for every pair of kind and material, kind by kind.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grind_env.envs.tasks import Kind, Task
from grind_env.kernel.columns import column_reader, column_writer

COST_TERMS = ("time", "wheel", "dress", "scrap", "handover")
"""Terms of the cost of a step that every task has."""


class KindRow(NamedTuple):
    """The numbers of a block kind that a step needs; see `tasks.Kind`.

    `stock`, `pick`, `width` and `length` are mm, `scrap` is $, `wait` is s, the time to load the part or to gauge it.
    `sparkout` is the number of strokes. `starts_part` and `ends_part` are 1 if so, else 0. The limits are `rise` in K,
    `power` in W, `roughness` and `size` in um.
    """

    stock: float
    pick: float
    sparkout: float
    width: float
    length: float
    stroke: float
    """Distance between the reversal points, mm."""
    scrap: float
    starts_part: float
    ends_part: float
    counts_all: float
    """1 if heat counts over all plunges, because a rise allowance is given."""
    wait: float
    rise: float
    power: float
    roughness: float
    size: float


class Shop(NamedTuple):
    """The numbers of a task that are the same for all its blocks.

    `acceleration` is mm/s2, `dwell`, `dress_seconds` and `change_seconds` are s. `dress_passes` is the number of passes
    of an execution, `dress_feed` is mm/s. `dress_depth`, of a pass, and `new_diameter` are mm. `hourly` is $/h,
    `wheel_price` $/mm3, `dress_price` $ per execution; `reference_cost`, of a block, and `change_price` are $.
    """

    acceleration: float
    dwell: float
    dress_passes: float
    dress_feed: float
    dress_depth: float
    dress_seconds: float
    hourly: float
    wheel_price: float
    dress_price: float
    reference_cost: float
    late_price: float
    """Of lateness, $/h."""
    least_diameter: float
    """Below it the wheel is changed, mm; 0 for never."""
    wheel_width: float
    """Of the whole wheel, mm."""
    new_diameter: float
    change_price: float
    change_seconds: float
    materials: float
    """Number of materials: each kind of blocks stands in a table once for each of them."""


class ShopMemory(NamedTuple):
    """What the shop floor remembers from block to block.

    `speed` is E in m/min, `pick` and `width` are mm, of the last block. The readings `mean_power`, `first_power` and
    `peak_power` are W, `size_error` is um. `roughness` is a ratio to its limit. `executions`, of the last block,
    `since_gauged`, `blocks_since_dress`, `dresses`, `parts` and `wheel_changes` are numbers of them.
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
    gauged: float
    """Ratio to its limit of the roughness gauged on the last gauged part, not yet known; negative if none."""
    since_gauged: float
    volume: float
    """Depth by the pre-gauge times length ground since the last dress, mm3/mm."""
    blocks_since_dress: float
    dresses: float
    parts: float
    survival: float
    """Probability that the part in work is still good."""
    stalled: float
    """1 if the spindle has stalled on it."""
    pre_dress: float
    """1 if the last block began with a dress."""
    clock: float
    """Time since the start of the episode, s."""
    wheel_changes: float
    diameter: float
    """Of the wheel as the shop's book says, mm: what dresses take off is compensated, wear when it is gauged."""
    found_diameter: float
    """True one of the wheel before the block, mm; nobody reads it, but no more can be lost than is left of it."""


class Outcome(NamedTuple):
    """What one step gives back.

    `time_cost`, `wheel_cost`, `dress_cost`, `scrap_cost`, `handover_cost` and `late_cost` are $.
    `roughness` and `size_error` are um.
    """

    time_cost: float
    wheel_cost: float
    dress_cost: float
    scrap_cost: float
    handover_cost: float
    late_cost: float
    change_cost: float
    """Price of a new wheel, $."""
    cost: float
    """Sum of the terms above, $."""
    reward: float
    """Ratio of minus that sum to the reference cost of a block."""
    good: float
    """Probability that the part that this block finished is good; 0 if it finished none."""
    finished: float
    """1 if the block finished a part."""
    seconds: float
    """Time of the block, with loading and wheel change, s."""
    burn_ratio: float
    """Burn ratio of the plunge that comes nearest to burning or is farthest beyond: 1 at the threshold."""
    rise: float
    """Highest temperature rise that counts, K."""
    peak_power: float
    """Highest power that the spindle gave, W: at most its limit, however high its load."""
    peak_torque: float
    """Ratio to that at which the spindle stalls."""
    roughness: float
    size_error: float
    power_ratio: float
    """Ratio of the highest load to the power limit."""
    roughness_ratio: float
    """Ratio of Ra of the surface to its limit; 0 where there is none."""


read_kind, read_shop = column_reader(KindRow), column_reader(Shop)
read_memory, write_memory = column_reader(ShopMemory), column_writer(ShopMemory)
write_outcome = column_writer(Outcome)
FOUND = ShopMemory._fields.index("found_diameter")


def kind_row(task: Task, kind: Kind) -> KindRow:
    """The numbers of a block kind."""
    limits = task.limits(kind)
    return KindRow(
        stock=kind.stock,
        pick=kind.pick,
        sparkout=float(kind.sparkout),
        width=kind.width,
        length=kind.length,
        stroke=task.stroke_length(kind),
        scrap=kind.scrap,
        starts_part=float(kind.starts_part),
        ends_part=float(kind.ends_part),
        counts_all=float(kind.rise_allowance > 0.0),
        wait=task.wait_seconds(kind),
        rise=limits.rise,
        power=limits.power,
        roughness=limits.roughness,
        size=limits.size,
    )


def kind_table(task: Task) -> NDArray[np.float64]:
    """Numbers of every kind in every material, shape (kinds x materials, fields of `KindRow`)."""
    return np.array([kind_row(task, kind) for kind in _variants(task)])


def parameter_table(task: Task) -> NDArray[np.float64]:
    """Nominal parameters of every kind in every material, shape (kinds x materials, fields of `StrokeParameters`)."""
    return np.array([task.parameters(kind) for kind in _variants(task)])


def _variants(task: Task) -> list[Kind]:
    return [replace(kind, material=name) for kind in task.kinds for name in task.materials]


def shop_row(task: Task) -> Shop:
    """The numbers that are the same for all blocks of a task."""
    rates = task.rates
    return Shop(
        acceleration=task.machine.acceleration,
        dwell=task.machine.reversal_dwell,
        dress_passes=float(task.dress.passes),
        dress_feed=task.dress_feed,
        dress_depth=task.dress.depth,
        dress_seconds=task.dress_seconds,
        hourly=rates.hourly,
        wheel_price=rates.wheel,
        dress_price=rates.dress,
        reference_cost=task.reference_cost,
        late_price=task.due.late if task.due else 0.0,
        least_diameter=task.wheel.minimum_diameter if task.wheel_change else 0.0,
        wheel_width=task.wheel.width,
        new_diameter=task.wheel.diameter,
        change_price=task.wheel_change.price if task.wheel_change else 0.0,
        change_seconds=task.wheel_change.seconds if task.wheel_change else 0.0,
        materials=float(len(task.materials)),
    )


def reward_terms(task: Task) -> dict[str, int]:
    """The terms of the reward of a task by name, and the column of `Outcome` that holds the cost of each."""
    names = [*COST_TERMS]
    if task.due is not None:
        names.append("late")
    if task.wheel_change is not None:
        names.append("change")
    return {name: Outcome._fields.index(f"{name}_cost") for name in names}

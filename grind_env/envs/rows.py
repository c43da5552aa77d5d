"""The numbers of a task and of an episode that the compiled step works on, as named tuples of floats."""

from typing import NamedTuple

from grind_env.envs.tasks import Kind, Task


class KindRow(NamedTuple):
    """The numbers of a block kind that a step needs; see `tasks.Kind`."""

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
    load: float
    rise: float
    power: float
    roughness: float
    size: float


class Shop(NamedTuple):
    """The numbers of a task that are the same for all its blocks."""

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


class Memory(NamedTuple):
    """What the shop floor remembers from block to block."""

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
    """Roughness gauged on the last gauged part, not yet known; negative if none."""
    since_gauged: float
    volume: float
    """Programmed depth times length ground since the last dress, mm3/mm."""
    blocks_since_dress: float
    dresses: float
    parts: float
    survival: float
    """Probability that the part in work is still good."""


class Outcome(NamedTuple):
    """What one step gives back. Costs in $."""

    time_cost: float
    wheel_cost: float
    dress_cost: float
    scrap_cost: float
    handover_cost: float
    cost: float
    """Sum of the five terms, $."""
    reward: float
    """Minus that sum over the reference cost of a block."""
    good: float
    """Probability that the part that this block finished is good; 0 if it finished none."""
    finished: float
    """1 if the block finished a part."""
    seconds: float
    burn_ratio: float
    rise: float
    peak_power: float
    roughness: float
    size_error: float


def kind_row(task: Task, kind: Kind) -> KindRow:
    """The numbers of a block kind."""
    limits = task.limits(kind)
    return KindRow(
        stock=kind.stock,
        pick=kind.pick,
        sparkout=float(kind.sparkout),
        width=kind.width,
        length=kind.length,
        stroke=kind.length + 2.0 * task.setup.overrun,
        scrap=kind.scrap,
        starts_part=float(kind.starts_part),
        ends_part=float(kind.ends_part),
        counts_all=float(kind.rise_allowance > 0.0),
        load=task.setup.load if kind.starts_part else 0.0,
        rise=limits.rise,
        power=limits.power,
        roughness=limits.roughness,
        size=limits.size,
    )


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
    )

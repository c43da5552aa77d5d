"""Cost terms of a block, which are the terms of the reward."""

from typing import NamedTuple

from grind_env.envs.block_kind_rows import KindRow
from grind_env.envs.noise_tape import TapeRow
from grind_env.envs.tasks import Task
from grind_env.kernel import inlined
from grind_env.kernel.row_accessors import column_reader, column_writer
from grind_env.machine.loops.cycle import PartState
from grind_env.machine.loops.stroke_totals import Tally
from grind_env.process.cost import NO_LIMIT, Rates, expenses, volume_left

COST_TERMS = ("time", "wheel", "dress", "scrap", "handover")  #: terms of the cost of a step that every task has


class Shop(NamedTuple):
    """The numbers of a task that are the same for all its blocks.

    `hourly` is $/h, `wheel_price` $/mm3, `dress_price` $ per execution; `reference_cost`, of a block, and
    `change_price` are $; `new_diameter` is mm, `change_seconds` are s. For jobs, fields with a default keep it.
    """

    hourly: float
    wheel_price: float
    dress_price: float
    reference_cost: float
    least_diameter: float  #: diameter below which the wheel is changed, mm; 0 for never
    wheel_width: float  #: width of the whole wheel, mm
    new_diameter: float
    change_seconds: float
    #: decrease of the diameter by a dress execution, mm; 0 if each block has its own dress program
    execution_depth: float = 0.0
    late_price: float = 0.0  #: price of lateness, $/h
    change_price: float = 0.0
    materials: float = 1.0  #: number of materials: tables have a row for each kind in each material


class Outcome(NamedTuple):
    """Costs, quality and readings of one step.

    `time_cost`, `wheel_cost`, `dress_cost`, `scrap_cost`, `handover_cost` and `late_cost` are $.
    `roughness` and `size_error` are um.
    """

    time_cost: float
    wheel_cost: float
    dress_cost: float
    scrap_cost: float
    handover_cost: float
    late_cost: float
    change_cost: float  #: price of a new wheel, $
    cost: float  #: sum of the terms above, $
    reward: float  #: ratio of minus `cost` to the reference cost of a block
    good: float  #: probability that the part that this block finished is good; 0 if it finished none
    finished: float  #: 1 if the block finished a part
    seconds: float  #: time of the block, with loading and wheel change, s
    burn_ratio: float  #: highest burn ratio of a plunge: 1 at the threshold of burning
    rise: float  #: highest temperature rise that counts, K
    peak_power: float  #: highest power of the spindle, W: at most the power limit, even under a higher load
    peak_torque: float  #: ratio of the highest torque to the torque at which the spindle stalls
    roughness: float
    size_error: float
    power_ratio: float  #: ratio of the highest load to the power limit
    roughness_ratio: float  #: ratio of Ra of the surface to its limit; 0 without a limit


class Found(NamedTuple):
    """Results of a block that its `Tally` does not have."""

    good: float  #: probability that the part is good so far; the mean of several parts that one block finished
    size_error: float  #: stock left where the part is farthest from its size, um
    change: float  #: 1 if the wheel is changed, else 0
    handover: float  #: price of handing over the wheel, $
    pick: float  #: largest depth that a stroke added, mm
    taper: float = 0.0  #: taper of the part as gauged, um


read_shop, write_outcome, read_found = column_reader(Shop), column_writer(Outcome), column_reader(Found)


def shop_row(task: Task) -> Shop:
    """Return the numbers that are the same for all blocks of a task."""
    rates = task.rates
    return Shop(
        execution_depth=task.execution_depth,
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
    """Return the terms of the reward of a task by name, and the column of `Outcome` that holds the cost of each."""
    names = [*COST_TERMS]
    if task.due is not None:
        names.append("late")
    if task.wheel_change is not None:
        names.append("change")
    return {name: Outcome._fields.index(f"{name}_cost") for name in names}


@inlined
def rates_of(shop: Shop) -> Rates:
    """Return the prices of a task."""
    return Rates(shop.hourly, shop.wheel_price, shop.dress_price)


@inlined
def outcome_of(
    kind: KindRow, row: TapeRow, shop: Shop, part: PartState, result: Tally, clock: float, diameter: float, found: Found
) -> Outcome:
    """Return the costs of a block and the state of its part.

    Args:
        kind: numbers of the block kind.
        row: row of the block on the tape.
        shop: numbers of the task.
        part: state of the part after the block.
        result: results of the cycle, with all its time except that of a wheel change.
        clock: time before the block, s.
        diameter: true diameter of the wheel before the block, mm.
        found: further results of the block.

    Wear and dressing remove at most the volume that is left of the wheel.
    """
    change, handover = found.change, found.handover
    seconds = result.seconds + change * shop.change_seconds
    clock += seconds
    finished = kind.ends_part
    removed = min(result.worn + result.dressed_off, volume_left(diameter, shop.wheel_width))
    rates = rates_of(shop)
    time_cost, wheel_cost, dress_cost = expenses(seconds, removed, result.dresses, rates)
    scrap_cost = finished * kind.scrap * (1.0 - found.good)
    late_cost = row.is_due * shop.late_price * max(clock - row.due, 0.0) / 3600.0
    change_cost = change * shop.change_price
    rise = result.plunge_rise if kind.counts_all > 0.0 else result.finish_rise
    roughness_ratio = part.Rs / kind.roughness if kind.roughness > NO_LIMIT else 0.0
    cost = time_cost + wheel_cost + dress_cost + scrap_cost + handover + late_cost + change_cost
    return Outcome(
        time_cost=time_cost,
        wheel_cost=wheel_cost,
        dress_cost=dress_cost,
        scrap_cost=scrap_cost,
        handover_cost=handover,
        late_cost=late_cost,
        change_cost=change_cost,
        cost=cost,
        reward=-cost / shop.reference_cost,
        good=finished * found.good,
        finished=finished,
        seconds=seconds,
        burn_ratio=result.burn_ratio,
        rise=rise,
        peak_power=min(result.peak_load, kind.power),
        peak_torque=result.peak_torque,
        roughness=part.Rs,
        size_error=found.size_error,
        power_ratio=result.peak_load / kind.power,
        roughness_ratio=roughness_ratio,
    )

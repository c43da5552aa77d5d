"""What a block that was run has cost, and what the shop floor remembers of it."""

from grind_env.envs.observations import GAUGE_EVERY
from grind_env.envs.tables import KindRow, Outcome, Shop, ShopMemory
from grind_env.envs.tape import TapeRow
from grind_env.kernel import inlined
from grind_env.kernel.columns import replacer
from grind_env.machine.loops.cycle import PartState
from grind_env.machine.loops.tally import Tally, has_stalled, mean_first_power, mean_last_power
from grind_env.process.cost import NO_LIMIT, Limits, Rates, expenses, handover_cost, survival, volume_left
from grind_env.process.gauge import Shown
from grind_env.process.state import StrokeParameters, WheelState

with_powers = replacer(Shown, "mean_power", "first_power", "peak_power")


@inlined
def counted_rise(kind: KindRow, result: Tally) -> float:
    """Highest temperature rise that counts, K: of all plunges, or of those that no later one grinds off."""
    return result.plunge_rise if kind.counts_all > 0.0 else result.finish_rise


@inlined
def chance(kind: KindRow, rise: float, torque: float, roughness: float, size_error: float) -> float:
    """Probability that a part of that kind is good; arguments as for `survival`."""
    return survival(rise, torque, roughness, size_error, Limits(kind.rise, kind.power, kind.roughness, kind.size))


@inlined
def good_so_far(kind: KindRow, part: PartState, result: Tally, size_error: float, old: ShopMemory) -> float:
    """Probability that the part is still good after a block; `size_error` in um."""
    before = 1.0 if kind.starts_part > 0.0 else old.survival
    return before * chance(kind, counted_rise(kind, result), result.peak_torque, part.Rs, size_error)


@inlined
def rates_of(shop: Shop) -> Rates:
    """The prices of a task."""
    return Rates(shop.hourly, shop.wheel_price, shop.dress_price)


@inlined
def handover_of(wheel: WheelState, lead: float, shop: Shop, p: StrokeParameters) -> float:
    """Price of handing over the wheel of a task, $; `lead` is that of a dress, mm per wheel revolution."""
    return handover_cost(wheel, shop.dress_passes, lead, shop.dress_depth, shop.dress_seconds, p, rates_of(shop))


@inlined
def booked_diameter(shown: Shown, shop: Shop, old: ShopMemory, off: float, gauged: bool, change: float) -> float:
    """The diameter in the shop's book after a block, mm.

    Args:
        shown: after it.
        shop: numbers of the task.
        old: what was remembered before it.
        off: what its dresses have taken off the diameter, mm.
        gauged: whether the wear is known before the next block.
        change: 1 if the wheel is changed after the block.
    """
    known = shown.diameter if gauged else old.diameter - off
    return shop.new_diameter if change > 0.0 else known


@inlined
def outcome_of(
    kind: KindRow,
    row: TapeRow,
    shop: Shop,
    part: PartState,
    result: Tally,
    old: ShopMemory,
    size_error: float,
    rise: float,
    good: float,
    change: float,
    handover: float,
) -> Outcome:
    """What a block has cost and made.

    Args:
        kind: of the block.
        row: of the tape.
        shop: numbers of the task.
        part: after the block.
        result: of its cycle.
        old: what was remembered before it.
        size_error: stock left on the part, um.
        rise: highest temperature rise that counts, K.
        good: probability that the part is still good.
        change: 1 if the wheel is changed after the block.
        handover: price of handing over the wheel, $.

    No more of a wheel can be worn and dressed off than is left of it.
    """
    seconds = result.seconds + kind.wait + change * shop.change_seconds
    clock = old.clock + seconds
    finished = kind.ends_part
    removed = min(result.worn + result.dressed_off, volume_left(old.found_diameter, shop.wheel_width))
    rates = rates_of(shop)
    time_cost, wheel_cost, dress_cost = expenses(seconds, removed, result.dresses, rates)
    scrap_cost = finished * kind.scrap * (1.0 - good)
    late_cost = row.is_due * shop.late_price * max(clock - row.due, 0.0) / 3600.0
    change_cost = change * shop.change_price
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
        good=finished * good,
        finished=finished,
        seconds=seconds,
        burn_ratio=result.burn_ratio,
        rise=rise,
        peak_power=min(result.peak_load, kind.power),
        peak_torque=result.peak_torque,
        roughness=part.Rs,
        size_error=size_error,
        power_ratio=result.peak_load / kind.power,
        roughness_ratio=roughness_ratio,
    )


@inlined
def truth_of(result: Tally, outcome: Outcome, diameter: float) -> Shown:
    """What meter and gauges ought to show after a block, of the wheel its diameter, mm."""
    return Shown(
        mean_power=mean_last_power(result),
        first_power=mean_first_power(result),
        peak_power=result.peak_load,
        size_error=outcome.size_error,
        roughness=outcome.roughness_ratio,
        diameter=diameter,
    )


@inlined
def noise_of(row: TapeRow) -> Shown:
    """The noise of what they show after a block."""
    return Shown(
        mean_power=row.mean_noise,
        first_power=row.first_noise,
        peak_power=row.peak_noise,
        size_error=row.size_noise,
        roughness=row.roughness_noise,
        diameter=row.wheel_noise,
    )


@inlined
def legible(shown: Shown, result: Tally, change: float) -> Shown:
    """What of it is read: no power where there is none to be read, or the wheel is changed (1) after the block."""
    # of a new wheel nothing is known yet
    mean = shown.mean_power if result.last_count > 0.0 and change == 0.0 else 0.0
    first = shown.first_power if result.first_count > 0.0 else 0.0
    # nor is there a peak where the wheel has only passed above a part on which the spindle had stalled
    peak = shown.peak_power if result.peak_load > 0.0 else 0.0
    return with_powers(shown, (mean, first, peak))


@inlined
def remembered(
    kind: KindRow,
    result: Tally,
    old: ShopMemory,
    shown: Shown,
    outcome: Outcome,
    good: float,
    change: float,
    E: float,
    D: float,
    pre_dress: float,
    volume: float,
    diameter: float,
) -> ShopMemory:
    """What the shop floor remembers after a block that was run with E (mm/min), D and perhaps a pre-dress (1).

    `shown` is what was read of it, `volume` what has been ground since the last dress of the block, mm3/mm, and
    `diameter` that of the wheel after it, mm, both by book-keeping. The other arguments are those of `outcome_of`, and
    what came of it.
    """
    ends = kind.ends_part > 0.0
    size_error = shown.size_error if ends else old.size_error
    known = ends and old.gauged >= 0.0
    roughness = old.gauged if known else old.roughness
    since_gauged = 1.0 if known else old.since_gauged + outcome.finished
    gauged = -1.0 if ends else old.gauged
    if ends and int(old.parts) % GAUGE_EVERY == 0:
        gauged = shown.roughness
    sharpened = result.dresses + change > 0.0
    stalled = 1.0 if has_stalled(result) else 0.0
    volume = (0.0 if change > 0.0 else volume) + (0.0 if sharpened else old.volume)
    blocks_since_dress = 0.0 if sharpened else old.blocks_since_dress + 1.0
    return ShopMemory(
        speed=E / 1000.0,
        executions=D,
        pick=kind.pick,
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
        survival=good,
        stalled=stalled,
        pre_dress=pre_dress,
        clock=old.clock + outcome.seconds,
        wheel_changes=old.wheel_changes + change,
        diameter=diameter,
        found_diameter=old.found_diameter,
    )

"""The compiled loop of the ensemble filter in `wheel_belief.py`: update, new wheel, new lot, summary."""

from typing import Any

import numpy as np

from grind_env.belief.filter_quantities import (
    LOT,
    WHEEL,
    Belief,
    Hidden,
    Judged,
    Signals,
    factors,
    log_growth,
    log_pressure,
    read_hidden,
    read_judged,
    read_signals,
    write_belief,
)
from grind_env.belief.power_sensor import POWER_NOISE, POWER_NOISE_FLOOR, POWER_RANGE
from grind_env.kernel import entry, exp, inlined, log
from grind_env.machine.loops.cycle import dress_lead
from grind_env.machine.loops.row_io import read_parameters, read_tally, read_wheel, write_wheel
from grind_env.machine.loops.stroke_totals import mean_first_power, mean_last_power
from grind_env.process.cost import Limits, survival
from grind_env.process.stroke_and_dress import dressed_wheel
from grind_env.process.stroke_types import StrokeParameters, WheelState

SMALLEST_POWER = 1.0  #: power that is added before a logarithm is taken, because a power may be 0, W
LEAST_VARIANCE = 1e-18  #: variance of the predicted readings up to which an ensemble learns nothing from a reading
NEW_WHEEL = 1.0  #: growth of the diameter from block to block above which the wheel counts as a new one, mm
AREA, DIAMETER = WheelState._fields.index("A"), WheelState._fields.index("ds")
FLAT_LIMIT = StrokeParameters._fields.index("Amax")


@inlined
def mean(values: Any) -> float:
    """Return the mean of members, summed in order: NumPy sums in another order than compiled code."""
    total = 0.0
    for value in values:
        total += value
    return float(total / values.size)


@inlined
def deviation(values: Any) -> float:
    """Return the standard deviation of members, summed in the order of `mean`."""
    middle, squares = mean(values), 0.0
    for value in values:
        squares += (value - middle) * (value - middle)
    return float(np.sqrt(squares / values.size))


@entry
def adjust(states: Any, row: int, reading: float, sigma: float) -> None:
    """Adjust an ensemble to one reading with normal noise (ensemble adjustment Kalman filter, Anderson 2001).

    The members keep their order: the predicted readings get the mean and the spread of their posterior, and every
    other quantity moves with them along its regression line.

    Args:
        states: one quantity a row, one member a column; updated.
        row: index of the row with the predicted readings of the members.
        reading: the measured reading, in the unit of that row.
        sigma: standard deviation of the noise of the reading, in the unit of that row.
    """
    members = states.shape[1]
    predicted = states[row].copy()
    middle = mean(predicted)
    squares = 0.0
    for m in range(members):
        predicted[m] -= middle
        squares += predicted[m] * predicted[m]
    variance = squares / (members - 1.0)
    if variance <= LEAST_VARIANCE:
        return
    gain = variance / (variance + sigma * sigma)
    shift, shrink = gain * (reading - middle), np.sqrt(1.0 - gain) - 1.0
    for k in range(states.shape[0]):
        products = 0.0
        for m in range(members):
            products += predicted[m] * states[k, m]
        slope = products / squares
        for m in range(members):
            states[k, m] += slope * (shift + shrink * predicted[m])


@entry
def learn(
    kind: Judged,
    seen: Signals,
    noise: float,
    highest: float,
    results: Any,
    wheels: Any,
    hidden: Any,
) -> float:
    """Adjust the members of an episode to the readings; return the probability that the block burnt the part."""
    members, columns = hidden.shape
    area, rise, power = columns, columns + 1, columns + 2
    states = np.empty((columns + 5, members))
    for m in range(members):
        result = read_tally(results, m)
        states[:columns, m] = hidden[m]
        states[area, m] = log(wheels[m, AREA])
        states[rise, m] = result.plunge_rise if kind.counts_all > 0.0 else result.finish_rise
        states[power, m] = log(mean_last_power(result) + SMALLEST_POWER)
        states[power + 1, m] = log(mean_first_power(result) + SMALLEST_POWER)
        states[power + 2, m] = log(result.peak_load + SMALLEST_POWER)
    readings = (seen.mean_power, seen.first_power, seen.peak_power)
    for k in range(3):
        # a reading of 0 means that nothing was read; at the end of its range the sensor reads too low
        if (readings[k] > 0.0) & (readings[k] < POWER_RANGE * kind.power):
            expected = exp(mean(states[power + k]))
            sigma = noise * (POWER_NOISE + POWER_NOISE_FLOOR / expected)
            adjust(states, power + k, log(readings[k] + SMALLEST_POWER), sigma)
    burnt = 0.0
    limits = Limits(kind.rise, kind.power, 0.0, 0.0)
    for m in range(members):
        hidden[m] = states[:columns, m]
        wheels[m, AREA] = min(exp(states[area, m]), highest)
        burnt += (1.0 - survival(states[rise, m], 0.0, 0.0, 0.0, limits)) / members
    return burnt


@entry
def mount(diameter: float, feed: float, depth: float, p: StrokeParameters, wheels: Any) -> None:
    """Mount a new wheel of `diameter` (mm) in every member, dressed with `feed` (mm/s); the diamond stays."""
    for m in range(wheels.shape[0]):
        old = read_wheel(wheels, m)
        write_wheel(wheels, m, dressed_wheel(diameter, old.wd, dress_lead(old, feed, p), depth, p))


@entry
def summarise(wheels: Any, hidden: Any, sigmas: Hidden, burnt: float) -> Belief:
    """Return means and standard deviations over the members of an episode."""
    members = hidden.shape[0]
    growth, pressure = np.empty(members), np.empty(members)
    for m in range(members):
        z = read_hidden(hidden, m)
        growth[m] = log_growth(z, sigmas)
        pressure[m] = log_pressure(z, sigmas)
    area = wheels[:, AREA]
    return Belief(
        mean(area), deviation(area), mean(growth), deviation(growth), mean(pressure), deviation(pressure), burnt
    )


@entry
def write_factors(hidden: Any, sigmas: Hidden, ageing: float, ground: Any, chosen: Any, drawn: Any) -> None:
    """Write the factors of the members of the episodes in `chosen`, in the order of `FACTORS`.

    Args:
        hidden: shape (N, M, fields of `Hidden`).
        sigmas: scales of the hidden numbers.
        ageing: nominal log convection that the coolant loses with every part.
        ground: parts ground so far, shape (N,).
        chosen: indices of the episodes.
        drawn: shape (N, M, factors); written.
    """
    for i in chosen:
        for m in range(hidden.shape[1]):
            values = factors(read_hidden(hidden[i], m), sigmas, ageing, ground[i])
            for k in range(len(values)):
                drawn[i, m, k] = values[k]


@entry
def follow(
    judged: Any,
    signals: Any,
    noise: float,
    base: Any,
    rows: Any,
    feed: float,
    depth: float,
    sigmas: Hidden,
    draws: Any,
    chosen: Any,
    fresh: Any,
    updates: Any,
    ground: Any,
    results: Any,
    wheels: Any,
    hidden: Any,
    beliefs: Any,
) -> None:
    """Update the beliefs of the episodes in `chosen` with the readings of the block that the members have just ground.

    Args:
        judged: judgements of the last blocks, shape (N, fields of `Judged`).
        signals: readings of the last blocks, shape (N, fields of `Signals`).
        noise: factor on the noise of the sensors.
        base: nominal parameters, shape (any, fields of `StrokeParameters`).
        rows: rows in `base` of the last blocks, shape (N,).
        feed: traverse feed of the diamond in the dress of a new wheel, mm/s.
        depth: depth of a pass in that dress, mm.
        sigmas: scales of the hidden numbers.
        draws: standard normal numbers, shape (any, M, fields of `Hidden`).
        chosen: indices of the episodes to update.
        fresh: whether each episode begins and has ground nothing yet, shape (N,).
        updates: number of updates so far, shape (N,); counted up.
        ground: number of parts ground so far, shape (N,), float64; counted up.
        results: results of the members in the last blocks, shape (N, M, fields of `Tally`).
        wheels: wheels of the members, shape (N, M, fields of `WheelState`); updated.
        hidden: hidden numbers of the members, shape (N, M, fields of `Hidden`); updated.
        beliefs: shape (N, fields of `Belief`); written.
    """
    highest = base[0, FLAT_LIMIT]
    for i in chosen:
        seen, block, burnt = read_signals(signals, i), read_judged(judged, i), 0.0
        if not fresh[i]:
            burnt = learn(block, seen, noise, highest, results[i], wheels[i], hidden[i])
            sample = draws[(updates[i] + 1) % draws.shape[0]]
            if seen.diameter > wheels[i, 0, DIAMETER] + NEW_WHEEL:
                mount(seen.diameter, feed, depth, read_parameters(base, rows[i]), wheels[i])
                hidden[i, :, WHEEL] = sample[:, WHEEL]
            if seen.new_lot > 0.5:
                hidden[i, :, LOT:] = sample[:, LOT:]
            ground[i] += block.ends_part
        wheels[i, :, DIAMETER] = seen.diameter
        write_belief(beliefs, i, summarise(wheels[i], hidden[i], sigmas, burnt))
        updates[i] += 1

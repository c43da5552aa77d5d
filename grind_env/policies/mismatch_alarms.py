"""Comparison of readings with forecasts: surprises, and alarms that surprises raise.

Forecasts come from the ensemble that follows the wheel on the model (`grind_env.belief`): each member grinds every
block with its E and D. Without an ensemble (steps that are no blocks, programs that the control executes), the
empirical law of the machine forecasts.
"""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from grind_env.array_types import Array
from grind_env.belief.power_sensor import POWER_NOISE, POWER_NOISE_FLOOR
from grind_env.belief.wheel_belief import WheelBelief
from grind_env.envs.block_kind_rows import KindRow
from grind_env.envs.filter_members import MemberModel
from grind_env.envs.simulation import Simulation
from grind_env.envs.task_gauges import ROUGHNESS_NOISE, SIZE_NOISE
from grind_env.policies.scripted.learned_laws import AIM, PowerLaw

#: running sum of surprises (CUSUM: Page, Biometrika 41 (1954) 100), in standard deviations: amount subtracted at each
#: reading, limit of the sum, and largest amount added by one reading. With normal errors the sum passes the limit once
#: in some 100,000 readings; with the ensemble's errors, a few of which are larger, once in 3,000 blocks of PowerLimited
SLACK, BEARABLE, MOST = 1.0, 6.0, 4.0
#: running sum of squared surprises of either sign: limit of the sum, largest sum, and the amount subtracted and largest
#: square at each reading. Beyond the limit the machine is not the model, even if it is a better one
DOUBTFUL, MOST_DOUBT, USUAL_SQUARE, LARGE_SQUARE = 15.0, 30.0, 2.0, 9.0
#: standard deviations from forecast to limit at which one reading in twenty is beyond the limit; more is unexpected
UNLIKELY = 1.645
HOLDS = 2.0  #: standard deviations within which a forecast holds
ROUNDING = 0.5  #: rounding of a size, um; no forecast is more precise
#: Ra over its limit and the standard deviation of its logarithm, where no model forecasts Ra
USUAL_RATIO, RATIO_SPREAD = 0.5, 0.35
#: number of readings in the running mean of the forecast errors of size and Ra. The power forecast learns by itself
MEMORY = 8.0


class WatchedReading(NamedTuple):
    """Reading of the last block and its forecast, each shape (N,); powers and Ra as logarithms, sizes times `sign`."""

    read: Any
    forecast: Any
    spread: Any
    limit: Any  #: limit that the reading must not exceed
    near: Any  #: value above which a surprise counts
    sign: Any  #: -1 where the size error is negative, else 1
    new: Any  #: whether the reading belongs to this block


NAMES = ("peak power", "mean power", "size error", "Ra")
UNITS = ("kW", "kW", "um", "of its limit")
#: whether a forecast is corrected by its mean error, in the order of `NAMES`
LEARNED = np.array([False, False, True, True])
#: whether the model leaves a reading's scale open, in the order of `NAMES`; a learned scale raises no doubt
OPEN = np.array([False, False, False, True])
PEAK, MEAN, SIZE, ROUGHNESS = range(len(NAMES))


class Watch:
    """Comparison of readings and forecasts block by block, for N machines.

    Args:
        simulation: simulation of the model.
        machines: number N of machines.
        residual: standard deviation of the logarithm of forces that the model does not explain, from a calibration.
    """

    alarm: NDArray[np.bool_]  #: whether the last block is an alarm, shape (N,)
    doubt: NDArray[np.bool_]  #: whether the machine probably differs from the model, shape (N,)
    holds: NDArray[np.bool_]  #: whether the forecasts of a machine hold, shape (N,)

    def __init__(self, simulation: Simulation, machines: int, residual: float = 0.0) -> None:
        task, shape = simulation.task, (machines, len(NAMES))
        self.simulation, self.noise, spread = simulation, task.spread.measurement, task.spread
        self.residual = residual
        self.belief = WheelBelief(MemberModel(simulation)) if simulation.compiled else None
        if self.belief is not None:
            self.belief.begin(machines)
        scatter = spread.wheel_roughness, spread.part_roughness, self.noise * ROUGHNESS_NOISE
        self.scatter = float(np.linalg.norm(scatter))
        self.alarm, self.doubt = np.zeros((2, machines), bool)
        # burn ratio of the last block over its peak power, as forecast, 1/W, shape (N,)
        self.burn_per_watt = np.zeros(machines)
        self.holds = np.ones(machines, bool)
        self._off, self._count, self._sum = np.zeros(shape), np.ones(shape), np.zeros(shape)
        self._beyond, self._run, self._squares = np.zeros(shape, bool), np.zeros(shape, bool), np.zeros(machines)
        self._gauged, self._sized = np.zeros((2, machines))
        self._part = np.full((machines, 1), USUAL_RATIO)
        self._row: KindRow | None = None
        # readings of the last block beside their forecasts, each of shape (N, readings)
        self.seen = WatchedReading(*np.zeros((len(WatchedReading._fields), *shape)))

    def update(self, observation: NDArray[np.float32], law: PowerLaw) -> None:
        """Compare the readings before a block; `law` has learned from them, but its forecast is from before."""
        read = self.simulation.read(observation)
        if self.belief is not None:
            self.belief.update(observation)
        if self._row is not None:
            self._judge(self._compare(read, self._row, law))
        rows = self.simulation.branches.coming_rows(read)
        self._row = KindRow(*self.simulation.kinds[rows].T)

    def said(self, machine: int) -> list[str]:
        """Return the alarm of a machine as sentences; no sentence without an alarm."""
        found = []
        for k, (name, unit) in enumerate(zip(NAMES, UNITS, strict=True)):
            if not (self._beyond | self._run)[machine, k]:
                continue
            seen = WatchedReading(*(values[machine, k] for values in self.seen))
            numbers = np.array([seen.read, seen.forecast - seen.spread, seen.forecast + seen.spread, seen.limit])
            numbers = seen.sign * numbers if k == SIZE else np.exp(numbers) / (1.0 if k == ROUGHNESS else 1000.0)
            read, (low, high), limit = numbers[0], sorted(numbers[1:3]), numbers[3]
            why = f"the limit is {limit:.2f}" if self._beyond[machine, k] else "it has been above its forecast before"
            found.append(f"{name} {read:.2f} {unit}, where {low:.2f} to {high:.2f} was forecast; {why}")
        return found

    def _judge(self, seen: WatchedReading) -> None:
        z = np.where(seen.new, (seen.read - seen.forecast) / seen.spread, 0.0)
        beyond = seen.new & (seen.read > seen.limit)
        self._beyond = beyond & (seen.limit - seen.forecast > UNLIKELY * seen.spread)
        # without the correction: a more compliant machine is another machine even when its size error is forecast
        unlearned = np.where(seen.new, z + seen.sign * np.where(OPEN, 0.0, self._off) / seen.spread, 0.0)
        squares = np.where(seen.new, np.minimum(unlearned**2, LARGE_SQUARE) - USUAL_SQUARE, 0.0).sum(axis=1)
        self._squares = np.clip(self._squares + squares, 0.0, MOST_DOUBT)
        self.doubt = self._squares > DOUBTFUL
        surprise = np.where(seen.read > seen.near, np.minimum(z, MOST), 0.0) - SLACK
        total = np.maximum(self._sum + np.where(seen.new, surprise, 0.0), 0.0)
        self._run, self.holds = total > BEARABLE, np.asarray((np.abs(z) < HOLDS).all(axis=1))
        self.alarm = np.asarray((self._beyond | self._run).any(axis=1))
        self._sum = np.where(self.alarm[:, None], 0.0, total)
        learned = seen.new & LEARNED
        self._count = np.where(learned, np.minimum(self._count + 1.0, MEMORY), self._count)
        self._off = self._off + np.where(learned, seen.sign * (seen.read - seen.forecast) / self._count, 0.0)
        self.seen = seen

    def _compare(self, read: Mapping[str, Array], row: KindRow, law: PowerLaw) -> WatchedReading:
        limit, tolerance, ends = np.asarray(row.power), np.asarray(row.size), np.asarray(row.ends_part) > 0.0
        told = (read["roughness"] != self._gauged) & (read["roughness"] > 0.0)
        outward, ratio = np.where(read["size_error"] < 0.0, -1.0, 1.0), np.log(np.maximum(read["roughness"], 1e-3))
        # a repeated size is the last size, of a part not gauged, or the end of the gauge's range
        gauged = (read["size_error"] != self._sized) | (np.abs(read["size_error"]) > tolerance)
        self._sized = read["size_error"]
        size, zero, one = outward * read["size_error"], np.zeros(len(outward)), np.ones(len(outward))
        if self.belief is None:
            peak = law.expected, law.spread, read["peak_power"] > 0.0
            mean = zero, one, zero > 0.0
            expected = zero, 0.5 * np.maximum(tolerance, ROUNDING)
            rough = zero + np.log(USUAL_RATIO), zero + RATIO_SPREAD
        else:
            made = self.belief.forecast
            peak = self._power(read["peak_power"], made.peak_power)
            mean = self._power(read["mean_power"], made.mean_power)
            self.burn_per_watt = (made.burn_ratio / np.maximum(made.peak_power, 1.0)).mean(axis=1)
            known = np.hypot(self.noise * SIZE_NOISE, ROUNDING)
            expected = outward * made.size_error.mean(axis=1), np.hypot(made.size_error.std(axis=1), known)
            # Ra is read when the next part has been ground
            before = np.log(np.maximum(self._part, 1e-3))
            rough = before.mean(axis=1), np.hypot(before.std(axis=1), self.scatter)
            self._part = np.where(ends[:, None], made.roughness, self._part)
        self._gauged = read["roughness"]
        powers = [np.log(np.maximum(read[name], 1.0)) for name in ("peak_power", "mean_power")]
        columns = (
            WatchedReading(powers[0], *peak[:2], np.log(limit), np.log(limit), one, peak[2]),
            WatchedReading(powers[1], *mean[:2], np.log(limit), np.log(limit), one, mean[2]),
            WatchedReading(size, *expected, tolerance, AIM * tolerance, outward, ends & gauged & (tolerance > 0.0)),
            WatchedReading(ratio, *rough, zero, zero + np.log(AIM), one, told),
        )
        seen = WatchedReading(*(np.stack(each, axis=1) for each in zip(*columns, strict=True)))
        return seen._replace(forecast=seen.forecast + seen.sign * self._off)

    def _power(self, read: Array, members: Array) -> tuple[Array, Array, NDArray[np.bool_]]:
        forecast = np.log(np.maximum(members, 1.0))
        mean = forecast.mean(axis=1)
        noise = self.noise * (POWER_NOISE + POWER_NOISE_FLOOR / np.exp(mean))
        noise = np.hypot(noise, self.residual)
        return mean, np.hypot(forecast.std(axis=1), noise), (read > 0.0) & (members > 0.0).all(axis=1)

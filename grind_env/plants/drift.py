"""Dulling, wear-flat pressure and idle power that wander from block to block."""

import math
from typing import Any, NamedTuple

from grind_env.kernel import exp, inlined
from grind_env.kernel.row_accessors import replacer
from grind_env.plants.event_random import deviate, words_of
from grind_env.plants.family import Family, ranges_of
from grind_env.process.gauge_readings import Gauge, GaugeReadings
from grind_env.process.process_interface import Drive, Hook, Moment
from grind_env.process.stroke_types import StrokeParameters, WheelState

#: bounds of the random walks: logarithms of the factors on kA and pm, and the change of idle power, W
MOST_DULLING, MOST_PRESSURE, MOST_IDLE = math.log(2.5), 0.2, 300.0


class DriftOwn(NamedTuple):
    """Memory of the hook; the gauge adds `drift_idle` to the shown powers. `ranges.toml` describes the drawn fields."""

    drift_seed: float = 0.0
    drift_dulls: float = 0.0
    drift_presses: float = 0.0
    drift_idles: float = 0.0
    drift_dulling: float = 0.0  #: logarithm of the factor on kA
    drift_pressure: float = 0.0  #: logarithm of the factor on pm
    drift_idle: float = 0.0  #: idle power above its value at the start of the shift, W


wandered = replacer(None, "drift_dulling", "drift_pressure", "drift_idle")
driven = replacer(StrokeParameters, "kA", "pm", "power")
shown_as = replacer(GaugeReadings, "mean_power", "first_power", "peak_power")


@inlined
def step(at: float, by: float, most: float) -> float:
    """Return the next value of a random walk, limited to `-most` to `most`."""
    return min(max(at + by, -most), most)


@inlined
def _before(
    wheel: WheelState, own: Any, p: StrokeParameters, drive: Drive, moment: Moment
) -> tuple[WheelState, Any, StrokeParameters, Drive]:
    """Step the walks; a higher idle power leaves less spindle power for grinding."""
    words = words_of(own.drift_seed, moment)
    dulling = step(own.drift_dulling, own.drift_dulls * deviate(words[0]), MOST_DULLING)
    pressure = step(own.drift_pressure, own.drift_presses * deviate(words[1]), MOST_PRESSURE)
    idle = step(own.drift_idle, own.drift_idles * deviate(words[2]), MOST_IDLE)
    p = driven(p, (p.kA * exp(dulling), p.pm * exp(pressure), p.power - idle))
    return wheel, wandered(own, (dulling, pressure, idle)), p, drive


@inlined
def _read(truth: GaugeReadings, own: Any, seconds: float, noise: GaugeReadings) -> tuple[GaugeReadings, Any]:
    """Power is shown above the idle power that was zeroed at the start of the shift."""
    idle = own.drift_idle
    return shown_as(truth, (truth.mean_power + idle, truth.first_power + idle, truth.peak_power + idle)), own


DRIFT = Family(
    name="drift",
    what="dulling rate, wear-flat pressure and idle power wander from block to block",
    ranges=ranges_of("drift"),
    chances=True,
    hook=Hook(_before, DriftOwn),
    gauge=Gauge(_read),
    anew=("drift_idle",),
)

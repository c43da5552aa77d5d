"""The gauges of the tasks, with their noise."""

from typing import Any

import numpy as np

from grind_env.belief.power_sensor import POWER_NOISE, POWER_NOISE_FLOOR
from grind_env.kernel import inlined
from grind_env.process.gauge_readings import TRUTH, Gauge, GaugeReadings, chain_gauges

SIZE_NOISE = 0.7  #: standard deviation of the size gauge, um
TAPER_NOISE = SIZE_NOISE * 2.0**0.5  #: standard deviation of a gauged taper, the difference of two sizes, um
ROUGHNESS_NOISE = 0.06  #: relative standard deviation of the roughness gauge


@inlined
def measured_power(power: float, z: float) -> float:
    """Return a power reading, W; `z` is standard normal times the noise factor of the task, as for all readings."""
    return max(power * (1.0 + POWER_NOISE * z) + POWER_NOISE_FLOOR * z, 0.0)


@inlined
def gauged_diameter(diameter: float, z: float) -> float:
    """Return the wheel diameter that the shop enters after touching off or gauging, mm, to the 0.001 mm of an offset.

    The error is twice that of the size gauge, because the size shows the position of the wheel's edge: the radius.
    """
    micrometres: float = np.floor(1000.0 * diameter + 2.0 * SIZE_NOISE * z + 0.5)
    return micrometres / 1000.0


class Noisy(Gauge):
    """A gauge with the noise of the tasks."""

    def __reduce__(self) -> Any:
        return "GAUGE" if self is GAUGE else (Gauge, tuple(self))


@inlined
def _read(truth: GaugeReadings, own: Any, seconds: float, noise: GaugeReadings) -> tuple[GaugeReadings, Any]:
    shown = GaugeReadings(
        mean_power=measured_power(truth.mean_power, noise.mean_power),
        first_power=measured_power(truth.first_power, noise.first_power),
        peak_power=measured_power(truth.peak_power, noise.peak_power),
        size_error=truth.size_error + SIZE_NOISE * noise.size_error,
        roughness=truth.roughness * (1.0 + ROUGHNESS_NOISE * noise.roughness),
        diameter=gauged_diameter(truth.diameter, noise.diameter),
    )
    return shown, own


GAUGE = Noisy(_read)  #: gauges of the tasks


def noisy(gauge: Gauge) -> Gauge:
    """Return a gauge with the noise of the tasks on what it shows."""
    return GAUGE if gauge is TRUTH else chain_gauges(gauge, GAUGE)

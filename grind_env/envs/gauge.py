"""The gauges of the tasks, with their noise."""

from typing import Any

from grind_env.envs.observations import gauged_diameter, measured_power, measured_roughness, measured_size
from grind_env.kernel import inlined
from grind_env.process.gauge import TRUTH, Gauge, Shown, beside


class Noisy(Gauge):
    """A gauge with the noise of the tasks."""

    def __reduce__(self) -> Any:
        return "GAUGE" if self is GAUGE else (Gauge, tuple(self))


@inlined
def _read(truth: Shown, own: Any, seconds: float, noise: Shown) -> tuple[Shown, Any]:
    shown = Shown(
        mean_power=measured_power(truth.mean_power, noise.mean_power),
        first_power=measured_power(truth.first_power, noise.first_power),
        peak_power=measured_power(truth.peak_power, noise.peak_power),
        size_error=measured_size(truth.size_error, noise.size_error),
        roughness=measured_roughness(truth.roughness, noise.roughness),
        diameter=gauged_diameter(truth.diameter, noise.diameter),
    )
    return shown, own


GAUGE = Noisy(_read)
"""Those of the tasks (scenarios, section 3)."""


def noisy(gauge: Gauge) -> Gauge:
    """A gauge with the noise of the tasks on what it shows."""
    return GAUGE if gauge is TRUTH else beside(gauge, GAUGE)

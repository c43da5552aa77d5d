"""What meter and gauges of the shop show after a block: a `Gauge`, handed to the steps as the `Process` is."""

from collections.abc import Callable
from typing import Any, NamedTuple

from grind_env.envs.observations import gauged_diameter, measured_power, measured_roughness, measured_size
from grind_env.kernel import inlined
from grind_env.process.process import Nothing


class Shown(NamedTuple):
    """What they show; as truth what they ought to, as noise standard normal numbers times the factor of the task.

    `mean_power`, `first_power` and `peak_power` are W, `size_error` is um, `diameter` mm. `roughness` is a ratio to its
    limit. Of a block that shows nothing of the kind they say nothing.
    """

    mean_power: float
    first_power: float
    peak_power: float
    size_error: float
    roughness: float
    diameter: float


class Gauge(NamedTuple):
    """Meter and gauges of a shop."""

    read: Callable[..., Any]
    """`read(truth, own, seconds, noise) -> shown, own`: after every block, at the s of the shift at which it is over;
    compiled. `own` has all that process and gauge remember."""
    own: type[Any] = Nothing
    """What they remember, as of `Process`; under other names than the process."""

    def __reduce__(self) -> Any:
        """As that of `Process`."""
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


GAUGE = Gauge(_read)
"""Those of the tasks (scenarios, section 3)."""

"""Readings of meter and gauges after a block: a `Gauge`, passed to the steps beside the `Process`."""

import functools
from collections.abc import Callable
from typing import Any, NamedTuple

from grind_env.kernel import inlined
from grind_env.process.process import Nothing, joined


class GaugeReadings(NamedTuple):
    """Readings of the gauges: as truth the exact values, as noise standard normal numbers times the factor of the task.

    `mean_power`, `first_power` and `peak_power` are W, `size_error` is um, `diameter` mm. `roughness` is a ratio to its
    limit. Of a block that shows nothing of the kind they say nothing.
    """

    mean_power: float
    first_power: float
    peak_power: float
    size_error: float
    roughness: float
    diameter: float


QUIET = GaugeReadings(*[0.0] * len(GaugeReadings._fields))
"""No noise."""


class Gauge(NamedTuple):
    """Meter and gauges of a shop."""

    read: Callable[..., Any]
    """`read(truth, own, seconds, noise) -> shown, own`: after every block, at the s of the shift at which it is over;
    compiled. `own` has all that process and gauge remember."""
    own: type[Any] = Nothing
    """What they remember, as of `Process`; under other names than the process."""


@inlined
def _read(truth: GaugeReadings, own: Any, seconds: float, noise: GaugeReadings) -> tuple[GaugeReadings, Any]:
    return truth, own


TRUTH = Gauge(_read)
"""What there is, without noise."""


@functools.cache
def beside(*gauges: Gauge) -> Gauge:
    """Chain gauges: each reads what the one before shows. The noise is that of the last gauge."""
    if not gauges:
        return TRUTH
    *others, shown = gauges
    for gauge in reversed(others):
        shown = Gauge(_through(gauge.read, shown.read), joined(gauge.own, shown.own))
    return shown


def _through(first: Callable[..., Any], then: Callable[..., Any]) -> Callable[..., Any]:
    quiet = QUIET

    @inlined
    def read(truth: GaugeReadings, own: Any, seconds: float, noise: GaugeReadings) -> tuple[GaugeReadings, Any]:
        found, own = first(truth, own, seconds, quiet)
        shown, own = then(found, own, seconds, noise)
        return shown, own

    return read

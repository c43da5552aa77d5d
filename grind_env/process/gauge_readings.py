"""Readings of meter and gauges after a block: a `Gauge`, passed to the steps beside the `Process`."""

import functools
from collections.abc import Callable
from typing import Any, NamedTuple

from grind_env.kernel import inlined
from grind_env.process.process_interface import Nothing, joined


class GaugeReadings(NamedTuple):
    """Numbers of the gauges: true values, readings, or noise (standard normal numbers times the factor of the task).

    `mean_power`, `first_power` and `peak_power` are W, `size_error` is um, `diameter` mm. `roughness` is a ratio to its
    limit. A number has no meaning for a block without such a reading.
    """

    mean_power: float
    first_power: float
    peak_power: float
    size_error: float
    roughness: float
    diameter: float


QUIET = GaugeReadings(*[0.0] * len(GaugeReadings._fields))  #: noise of 0 in all gauges


class Gauge(NamedTuple):
    """Meter and gauges of a shop."""

    #: `read(truth, own, seconds, noise) -> shown, own`, compiled and called after every block; `seconds` is the time of
    #: the shift at the end of the block, `own` the memory of process and gauge
    read: Callable[..., Any]
    #: memory of the gauges, as `Process.own`; its field names must differ from those of the process
    own: type[Any] = Nothing


@inlined
def _read(truth: GaugeReadings, own: Any, seconds: float, noise: GaugeReadings) -> tuple[GaugeReadings, Any]:
    return truth, own


TRUTH = Gauge(_read)  #: gauge that shows the true values, without noise


@functools.cache
def chain_gauges(*gauges: Gauge) -> Gauge:
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

"""A power meter with a wrong scale, a lag, and an idle power that creeps with the bearings."""

from typing import Any, NamedTuple

from grind_env.kernel import exp, inlined
from grind_env.kernel.row_accessors import replacer
from grind_env.plants.family import Family, ranges_of
from grind_env.process.gauge_readings import Gauge, GaugeReadings


class MeterOwn(NamedTuple):
    """Memory of the meter; `ranges.toml` describes the fields."""

    meter_gain: float = 1.0
    meter_lag: float = 0.0
    meter_idle: float = 0.0
    meter_creeps: float = 0.0
    meter_warms: float = 3600.0


shown_as = replacer(GaugeReadings, "mean_power", "first_power", "peak_power")


@inlined
def _read(truth: GaugeReadings, own: Any, seconds: float, noise: GaugeReadings) -> tuple[GaugeReadings, Any]:
    """Power is shown above the idle power that was zeroed at the start of the shift and has crept since then.

    A lagging meter flattens peaks above the mean of a block, and its reading still rises in the first stroke.
    """
    kept = 1.0 / (1.0 + own.meter_lag)
    crept = own.meter_idle * own.meter_creeps * (1.0 - exp(-seconds / own.meter_warms))
    mean = own.meter_gain * (truth.mean_power + crept)
    first = own.meter_gain * (kept * truth.first_power + crept)
    peak = own.meter_gain * (kept * truth.peak_power + (1.0 - kept) * truth.mean_power + crept)
    return shown_as(truth, (mean, first, peak)), own


METER = Family(
    name="meter",
    what="the power meter has a wrong gain and a lag, and the idle power creeps as bearings warm up",
    ranges=ranges_of("meter"),
    gauge=Gauge(_read, MeterOwn),
)

"""A machine that grows with heat over the shift, and a size gauge whose zero drifts with it."""

from typing import Any, NamedTuple

from grind_env.kernel import exp, inlined
from grind_env.kernel.row_accessors import replacer
from grind_env.plants.family import Family, ranges_of
from grind_env.process.gauge_readings import Gauge, GaugeReadings
from grind_env.process.process_interface import Drive, Hook, Moment
from grind_env.process.stroke_types import StrokeParameters, WheelState


class ThermalOwn(NamedTuple):
    """Memory of hook and gauge; `ranges.toml` describes the drawn fields."""

    thermal_grows: float = 0.0
    thermal_drifts: float = 0.0
    thermal_warms: float = 3600.0
    thermal_grown: float = 0.0  #: growth up to the block before, um


nearer = replacer(WheelState, "W")
grown_to = replacer(None, "thermal_grown")
shown_as = replacer(GaugeReadings, "size_error")


@inlined
def _before(
    wheel: WheelState, own: Any, p: StrokeParameters, drive: Drive, moment: Moment
) -> tuple[WheelState, Any, StrokeParameters, Drive]:
    """Touching off cancels earlier growth; during this block the head grows about as much as during the last one."""
    grown = own.thermal_grows * (1.0 - exp(-moment.seconds / own.thermal_warms))
    W = wheel.W - 0.001 * (grown - own.thermal_grown)
    return nearer(wheel, (W,)), grown_to(own, (grown,)), p, drive


@inlined
def _read(truth: GaugeReadings, own: Any, seconds: float, noise: GaugeReadings) -> tuple[GaugeReadings, Any]:
    drifted = own.thermal_drifts * (1.0 - exp(-seconds / own.thermal_warms))
    return shown_as(truth, (truth.size_error + drifted,)), own


THERMAL = Family(
    name="thermal",
    what="as the machine warms up, its head grows towards the part or away, and the zero of the size gauge drifts",
    ranges=ranges_of("thermal"),
    hook=Hook(_before, ThermalOwn),
    gauge=Gauge(_read),
    anew=("thermal_grown",),
)

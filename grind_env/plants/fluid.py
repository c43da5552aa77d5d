"""A coolant that warms up through the shift, and a nozzle that clogs."""

from typing import Any, NamedTuple

from grind_env.kernel import exp, inlined
from grind_env.kernel.row_accessors import replacer
from grind_env.plants.family import Family, ranges_of
from grind_env.process.process_interface import Drive, Hook, Moment
from grind_env.process.stroke_types import StrokeParameters, WheelState

LEAST_FLOW = 0.2  #: smallest share of the convection when a nozzle clogs: the other nozzles still flood the contact


class FluidOwn(NamedTuple):
    """Memory of the hook; `ranges.toml` describes the fields."""

    fluid_hotter: float = 0.0
    fluid_warms: float = 3600.0
    fluid_clogs: float = 0.0
    fluid_clogs_at: float = 0.0


cooling = replacer(StrokeParameters, "Tb", "hf")


@inlined
def _before(
    wheel: WheelState, own: Any, p: StrokeParameters, drive: Drive, moment: Moment
) -> tuple[WheelState, Any, StrokeParameters, Drive]:
    """Rises count from the temperature of the hall, so warm coolant boils at a lower rise of the surface."""
    hotter = own.fluid_hotter * (1.0 - exp(-moment.seconds / own.fluid_warms))
    clogged = own.fluid_clogs * max(moment.seconds - own.fluid_clogs_at, 0.0) / 3600.0
    return wheel, own, cooling(p, (p.Tb - hotter, p.hf * max(exp(-clogged), LEAST_FLOW))), drive


FLUID = Family(
    name="fluid",
    what="the coolant warms up through the shift, and at some time a nozzle begins to clog",
    ranges=ranges_of("fluid"),
    hook=Hook(_before, FluidOwn),
)

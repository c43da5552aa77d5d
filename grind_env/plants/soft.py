"""A compliant loop of machine, wheel and work, softest at the end of the table."""

from typing import Any, NamedTuple

from grind_env.kernel import inlined
from grind_env.kernel.row_accessors import replacer
from grind_env.plants.family import Family, ranges_of
from grind_env.process.process_interface import Drive, Hook, Moment
from grind_env.process.stroke_types import StrokeParameters, WheelState

REACH = 300.0  #: distance from the middle of the table to its end, mm


class SoftOwn(NamedTuple):
    """Memory of the hook; `ranges.toml` describes the fields."""

    soft_gives: float = 1.0
    soft_end: float = 1.0


with_stiffness = replacer(StrokeParameters, "ke")


@inlined
def _before(
    wheel: WheelState, own: Any, p: StrokeParameters, drive: Drive, moment: Moment
) -> tuple[WheelState, Any, StrokeParameters, Drive]:
    out = min(abs(moment.place) / REACH, 1.0)
    gives = own.soft_gives * (1.0 + (own.soft_end - 1.0) * out)
    return wheel, own, with_stiffness(p, (p.ke / gives,)), drive


SOFT = Family(
    name="soft",
    what="machine, wheel and work yield more under the force, and most at the end of the table",
    ranges=ranges_of("soft"),
    hook=Hook(_before, SoftOwn),
)

"""A table that lags behind its command and loses time at the reversals."""

from typing import Any, NamedTuple

from grind_env.kernel import inlined
from grind_env.plants.family import Family, ranges_of
from grind_env.process.process_interface import Drive, Hook, Moment
from grind_env.process.stroke_types import StrokeParameters, WheelState

FAST = 30_000.0  #: table speed, mm/min, for which `ranges.toml` gives the losses


class TableOwn(NamedTuple):
    """Memory of the hook; `ranges.toml` describes the fields."""

    table_behind: float = 0.0
    table_rests: float = 0.0


@inlined
def _before(
    wheel: WheelState, own: Any, p: StrokeParameters, drive: Drive, moment: Moment
) -> tuple[WheelState, Any, StrokeParameters, Drive]:
    """Leakage and cushioning grow with speed, so the lost share of E and the time lost at reversals grow with E."""
    fast = moment.E / FAST
    share = drive.share * (1.0 - own.table_behind * fast)
    return wheel, own, p, Drive(share=share, dwell=drive.dwell + own.table_rests * fast)


TABLE = Family(
    name="table",
    what="the table falls short of a high E, and takes longer to reverse",
    ranges=ranges_of("table"),
    hook=Hook(_before, TableOwn),
)

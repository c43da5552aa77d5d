"""A stroke as a row of the record: place, results, and the wheel afterwards."""

from typing import NamedTuple

import numpy as np

from grind_env.array_types import Array
from grind_env.kernel.row_accessors import dtype_of
from grind_env.process.stroke_types import StrokeResult


class TableStroke(NamedTuple):
    """Place of a stroke of the table, or of an infeed; a record row has it before the results."""

    time: float  #: time of the job at its start, s
    seconds: float
    E: float  #: table speed, mm/min; F of an infeed
    Z: float  #: programmed depth below the touched-off surface at the middle of the stroke, end of the infeed, mm
    b: float  #: engaged width, mm
    Lw: float  #: ground length, mm; 0 where the wheel passes beside the part, then b is 0 as well
    grown: float  #: thermal growth of the part, mm


class PartVerdict(NamedTuple):
    """Cost of a part, $, and its probability of being good."""

    survival: float  #: probability that the part is good
    time_cost: float
    wheel_cost: float
    dress_cost: float
    scrap_cost: float  #: expected cost of scrap
    total_cost: float


class WheelSeen(NamedTuple):
    """Wheel after a stroke or infeed in a record; fields as in `WheelState`."""

    A: float
    lam: float
    V: float
    ds: float
    W: float


STROKE_ROW = np.dtype(
    [
        ("part", np.int64),  # 1, 2, ...
        ("line", np.int64),  # of the cycle block
        ("number", np.int64),  # within the cycle; 0 outside a G82 or G83
        ("groove", np.int64),  # of the G76 or G77 block, from 1; 0 for a stroke
        *dtype_of(TableStroke).descr,
        *dtype_of(StrokeResult).descr,
        *dtype_of(WheelSeen).descr,
    ]
)


#: first column of `TableStroke` in a table of strokes; `StrokeResult` and `WheelSeen` follow
NUMBERS_FROM = (STROKE_ROW.names or ()).index(TableStroke._fields[0])


def table_of(rows: Array) -> Array:
    """Return strokes as floats, a view of shape (strokes, fields); columns before `NUMBERS_FROM` hold integer bits."""
    return rows.view(np.float64).reshape(rows.size, -1)

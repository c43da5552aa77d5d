"""The strokes of a table over the strips of a part, one after the other."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grind_env.kernel import entry
from grind_env.kernel.rows import column_writer
from grind_env.machine.rows import Table
from grind_env.machine.strips import IDLE, Strips, grind_strips
from grind_env.machine.tally import Tally, count_stroke
from grind_env.process.state import Stroke, StrokeParameters, WheelState


class TableStrokes(NamedTuple):
    """Strokes at one table speed, an array with one value a stroke each."""

    Z: NDArray[np.float64]
    """Depth of the wheel below the touched-off surface, mm."""
    Lw: NDArray[np.float64]
    """Ground length, mm; 0 where the wheel passes beside the part."""
    first: NDArray[np.int64]
    """First strip under the wheel."""
    last: NDArray[np.int64]
    """The one after the last."""
    seconds: NDArray[np.float64]
    """Time."""


class WheelSeen(NamedTuple):
    """What a record shows of the wheel after a stroke or infeed; fields as in `WheelState`."""

    A: float
    lam: float
    V: float
    ds: float
    alw: float
    W: float


write_stroke, write_wheel_seen = column_writer(Stroke), column_writer(WheelSeen, len(Stroke._fields))


@entry
def grind_passes(
    wheel: WheelState,
    S: Strips,
    Rs: Strips,
    reached: Strips,
    strokes: TableStrokes,
    vw: float,
    width: float,
    p: StrokeParameters,
    tally: Tally,
    b: NDArray[np.float64],
    plunged: NDArray[np.bool_],
    results: Table,
) -> tuple[WheelState, Tally]:
    """Make strokes over a part.

    Args:
        wheel: before them.
        S: as for `grind_strips`, like the next two; updated.
        Rs: updated.
        reached: updated.
        strokes: where the strokes lie.
        vw: table speed, mm/s.
        width: of the part, mm.
        p: parameters.
        tally: before them.
        b: engaged width of each, mm; written, like all that follows. A stroke beside the part is `IDLE`, its b 0.
        plunged: whether the wheel went deeper into a strip than before.
        results: what each has done and the wheel after it, shape (strokes, fields of `Stroke` and `WheelSeen`).

    Returns:
        Wheel and tally after them.
    """
    for k in range(b.size):
        stroke, b[k], plunged[k] = IDLE, 0.0, False
        first, last = strokes.first[k], strokes.last[k]
        if strokes.Lw[k] > 0.0 and first < last:
            wheel, stroke, b[k], plunged[k] = grind_strips(
                wheel, S, Rs, reached, first, last, strokes.Z[k], vw, width, strokes.Lw[k], p
            )
        tally = count_stroke(tally, stroke, strokes.seconds[k], 0.0, plunged[k], False, False)
        write_stroke(results, k, stroke)
        seen = WheelSeen(A=wheel.A, lam=wheel.lam, V=wheel.V, ds=wheel.ds, alw=wheel.alw, W=wheel.W)
        write_wheel_seen(results, k, seen)
    return wheel, tally

"""Executions of blocks in a run, with the numbers that compare cycles."""

import numpy as np

from grind_env.array_types import Array
from grind_env.process import kinematic_numbers

EXECUTION_ROW = np.dtype(
    [
        ("part", np.int64),
        ("line", np.int64),  # of the block
        ("first", np.int64),  # index of its first stroke in the run, from 0
        ("strokes", np.int64),  # number of strokes and infeeds
        ("seconds", np.float64),  # time of the strokes, s
        ("ground", np.float64),  # volume ground, mm3
        ("energy", np.float64),  # of grinding, J
        ("V", np.float64),  # specific volume V'w, mm3/mm: of each stroke over its own width
        ("peak_Q", np.float64),  # highest specific removal rate Q'w, mm2/s
        ("speed_ratio", np.float64),  # mean of the strokes that cut; 0 if none does
        ("aggressiveness", np.float64),  # highest
        ("u_s", np.float64),  # specific energy, J/mm3: all energy over all volume; 0 if nothing is cut
    ]
)


def executions_of(strokes: Array) -> Array:
    """Return the executions of blocks in the strokes of a record, shape (executions,), dtype `EXECUTION_ROW`."""
    if not strokes.size:
        return np.zeros(0, EXECUTION_ROW)
    numbers = strokes["number"]  # 0 for a stroke between two cycles
    again = (numbers[1:] > 0) & ((np.diff(numbers) <= 0) | (numbers[1:] == 1))
    changes = (np.diff(strokes["line"]) != 0) | (np.diff(strokes["part"]) != 0) | again
    firsts = np.append(0, np.flatnonzero(changes) + 1)
    rows = np.zeros(firsts.size, EXECUTION_ROW)
    ae, Lw, Q, cuts = strokes["ae"], strokes["Lw"], strokes["Q"], strokes["ae"] > 0.0
    # the work speed is that of the process model: an infeed has the F of its block in E (`part.groove_cuts`)
    vw = np.divide(Q, ae, out=strokes["E"] / 60.0, where=cuts)
    ratio, aggressiveness = np.zeros(ae.size), np.zeros(ae.size)
    cutting, of_cutting = strokes[cuts], vw[cuts]
    ratio[cuts] = kinematic_numbers.speed_ratio(cutting["vs"], of_cutting)
    aggressiveness[cuts] = kinematic_numbers.aggressiveness(of_cutting, cutting["vs"], cutting["ae"], cutting["ds"])

    rows["part"], rows["line"], rows["first"] = strokes["part"][firsts], strokes["line"][firsts], firsts
    rows["strokes"] = np.diff(np.append(firsts, ae.size))
    sums = {
        "seconds": strokes["seconds"],
        "ground": ae * strokes["b"] * Lw,
        "energy": strokes["power"] * Lw / vw,  # over the part
        "V": ae * Lw,
    }
    for name, values in sums.items():
        rows[name] = np.add.reduceat(values, firsts)
    rows["speed_ratio"] = np.add.reduceat(ratio, firsts) / np.maximum(np.add.reduceat(cuts.astype(float), firsts), 1.0)
    rows["peak_Q"] = np.maximum.reduceat(Q, firsts)
    rows["aggressiveness"] = np.maximum.reduceat(aggressiveness, firsts)
    np.divide(rows["energy"], rows["ground"], out=rows["u_s"], where=rows["ground"] > 0.0)
    return rows

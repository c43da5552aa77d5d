"""Hand-written C version of G82 (`stroke.c`), the reference for the speed of the kernel; needs gcc.

The C code rounds as the kernel does: no fused multiply-add, no reordered sums. It skips only what changes no result:
errno of square roots and floating-point traps.
"""

import ctypes
import platform
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from grind_env.control.cycles.plunge import PlungeCycle, PlungeProgress
from grind_env.machine.loops.machine_lanes import longest_first_of
from grind_env.process.stroke_types import StrokeConstants
from tests.batches import CYCLE, PARAMETERS, PART, TALLY, WHEEL

SOURCE = Path(__file__).with_name("stroke.c")
LANES = (8, 16)  #: machines side by side: as many as in the kernel, and twice as many
STRICT = ("-O3", "-march=native", "-ffp-contract=off")
#: makes gcc use 512-bit vector registers
WIDEST = ("-mprefer-vector-width=512",) if platform.machine() in ("x86_64", "AMD64") else ()
PARALLEL = ("-fschedule-insns", "-fsched-pressure")  #: schedules instructions as the kernel does: 10 % faster
NO_SIDE_EFFECTS = ("-fno-math-errno", "-fno-trapping-math")  #: lets gcc vectorize square roots
#: fields of the C structures, one for each table of the kernel and for the constants and progress of a lane
RECORDS = {
    "Cycle": CYCLE.names,
    "Parameters": PARAMETERS.names,
    "Constants": StrokeConstants._fields,
    "Wheel": WHEEL.names,
    "Part": PART.names,
    "Progress": PlungeProgress._fields,
    "Tally": TALLY.names,
}

#: function that grinds; its arguments are the tables of cycles, parameters, wheels, parts and tallies
Loop = Callable[..., None]


def compiler() -> str | None:
    """Return the path of gcc, or None."""
    return shutil.which("gcc")


def records() -> str:
    """Return `records.h`, which lists the fields of the C structures."""
    lines = (
        f"#define {name}_FIELDS(X) {' '.join(f'X({field})' for field in fields or ())}\n"
        for name, fields in RECORDS.items()
    )
    return "".join(lines)


def compiled(folder: Path, lanes: int) -> Loop:
    """Compile the source for a number of lanes; the results equal those of the kernel bit by bit."""
    (folder / "records.h").write_text(records(), encoding="utf-8")
    library = folder / f"stroke_{lanes}.so"
    gcc = compiler()
    assert gcc is not None
    command = [gcc, *STRICT, *WIDEST, *PARALLEL, *NO_SIDE_EFFECTS, f"-DLANES={lanes}", f"-I{folder}", SOURCE]
    subprocess.run([*command, "-shared", "-fPIC", "-o", library, "-lm"], check=True)
    run = ctypes.CDLL(str(library)).run
    run.restype = None

    def plunges(*tables: Any) -> None:
        machines = len(tables[0])
        order = np.empty(machines, np.int64)
        longest_first_of(PlungeCycle)(tables[0], np.arange(machines), order)
        pointers = (table.ctypes.data_as(ctypes.c_void_p) for table in (*tables, order))
        run(*pointers, ctypes.c_int64(machines))

    return plunges

"""The record of a run: one row per stroke or infeed, per dress and per part."""

import csv
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from grind_env.array_types import Array
from grind_env.control import CyclePlan, Programs
from grind_env.errors import GrindError
from grind_env.files import write_atomically
from grind_env.kernel.row_accessors import dtype_of
from grind_env.machine.dress.dress_severity import Sharpening
from grind_env.machine.job import Job
from grind_env.machine.part.block_totals import executions_of
from grind_env.machine.part.stroke_record import STROKE_ROW, PartVerdict
from grind_env.machine.part.unsimulated_cuts import Unjudged
from grind_env.message_text import quoted
from grind_env.notebook_loader import html, presenter
from grind_env.optional_libraries import needing

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: units of the fields of `STROKE_ROW`, `EXECUTION_ROW`, `DRESS_ROW` and `PART_ROW`; other fields have no unit
UNITS = {
    name: unit
    for unit, names in {
        "s": "time seconds",
        "mm/min": "E",
        "mm": "Z b Lw grown ae lc dw ds W stock S lead",
        "mm2/s": "Q peak_Q",
        "um": "heq Rg Ra size_error taper worst_error size_wear size_growth size_deflection size_rest",
        "N": "fg",
        "N/mm": "Ft Fn",
        "W": "power load mean_load heat peak_power",
        "m/s": "vs",
        "J": "energy",
        "J/mm3": "u_s",
        "K": "T rise highest_rise",
        "mm3": "worn removed dressed_off ground",
        "mm3/mm": "V",
        "$": "time_cost wheel_cost dress_cost scrap_cost total_cost",
    }.items()
    for name in names.split()
}

#: number formats of fields in a CSV file; other fields have six digits
DIGITS = {"time": ".3f", "seconds": ".3f", "ds": ".5f"}

DRESS_ROW = np.dtype(
    [
        ("part", np.int64),
        ("after", np.int64),  # number of strokes and infeeds of the run before the dress
        ("time", np.float64),  # at the start of the dress, s
        ("cause", "U8"),  # pre, auto or operator
        ("program", np.int64),
        ("seconds", np.float64),
        ("ds", np.float64),  # wheel diameter after the dress, mm
        ("removed", np.float64),  # wheel volume, mm3
        *dtype_of(Sharpening).descr,
    ]
)

PART_ROW = np.dtype(
    [
        ("part", np.int64),
        ("seconds", np.float64),
        ("strokes", np.int64),
        ("infeeds", np.int64),  # of grooves
        ("dresses", np.int64),
        ("stock", np.float64),  # to be ground off, mm
        ("S", np.float64),  # ground off, mean over the width or, without strokes, over the grooves, mm
        ("size_error", np.float64),  # stock left, um
        ("taper", np.float64),  # range of S, um
        ("worst_error", np.float64),  # stock left where the part is farthest from its size, which decides, um
        ("size_wear", np.float64),  # of size_error: wear of the wheel since it was gauged, um
        ("size_growth", np.float64),  # of size_error: how far the part stood higher because it was hot, um
        ("size_deflection", np.float64),  # of size_error: how far wheel and machine have yielded, um
        ("size_rest", np.float64),  # of size_error: stock below the depth that was programmed, um
        ("unground", np.float64),  # share of the surface that no stroke has reached; such a part is not good
        ("Ra", np.float64),  # mean as for S, um
        ("peak_power", np.float64),  # above idle, W
        ("peak_torque", np.float64),  # ratio to the stall torque
        ("rise", np.float64),  # highest temperature rise that counts, in the last stage, K
        ("highest_rise", np.float64),  # highest temperature rise that counts, in all stages, K
        ("burn_ratio", np.float64),  # highest of the plunges
        ("worn", np.float64),  # wheel volume, mm3
        ("dressed_off", np.float64),  # wheel volume, mm3
        ("earlier", np.float64),  # probability that it was good in all stages before the last; 1 without these
        *dtype_of(PartVerdict).descr,
    ]
)


def heading(name: str) -> str:
    """Return the heading of a field in files and data frames: its name with its unit, as in `time [s]`."""
    return f"{name} [{UNITS[name]}]" if name in UNITS else name


class RowLog:
    """A table that grows by single rows or by arrays of rows."""

    def __init__(self, dtype: np.dtype[np.void]) -> None:
        self.dtype = dtype
        self._bytes = bytearray()  # bytes: copying field by field took ten times as long
        self._single: list[tuple[object, ...]] = []  # rows after those in `_bytes`

    def __len__(self) -> int:
        return len(self._bytes) // self.dtype.itemsize + len(self._single)

    def add(self, row: tuple[object, ...]) -> None:
        """Add one row, a value for each field."""
        self._single.append(row)

    def extend(self, rows: Array) -> None:
        """Add rows of the same dtype, shape (rows,)."""
        self._close()
        self._bytes += rows.tobytes()

    def table(self, first: int = 0) -> Array:
        """Return a copy of the rows from `first` on, shape (rows,)."""
        self._close()
        return np.frombuffer(self._bytes[first * self.dtype.itemsize :], self.dtype)

    def _close(self) -> None:
        if self._single:
            self._bytes += np.array(self._single, self.dtype).tobytes()
            self._single = []


class RecordError(GrindError):
    """A record that cannot be written or converted as asked."""


@dataclass(frozen=True, slots=True, eq=False)
class GrindingRecord:
    """Result of `machine.grind`."""

    strokes: Array  #: strokes and infeeds in their order, dtype `STROKE_ROW` in the units of `UNITS`
    dresses: Array  #: dresses in their order, dtype `DRESS_ROW` in the units of `UNITS`
    parts: Array  #: parts in their order, dtype `PART_ROW` in the units of `UNITS`
    #: for each part and each of its stages that a stop has ended, the exceeded limits (fields of `process.cost.Limits`)
    stages: tuple[tuple[tuple[str, ...], ...], ...]
    #: unsimulated grinding of each part, which is then neither judged nor good; empty for a judged part
    unjudged: tuple[tuple[Unjudged, ...], ...]
    warnings: tuple[str, ...]  #: sentences on parts of the program without the expected effect
    blocks: Mapping[int, int]  #: N word of the block of each line that has ground; the line number if there is no N
    cycles: Mapping[int, CyclePlan]  #: last executed cycle of each line
    programs: Programs  #: the programs
    job: Job  #: the job, with the parts of the run

    @property
    def executions(self) -> Array:
        """Return comparison numbers of each execution of a block (Q'w, V'w, q, Aggr, u_s).

        Shape (executions,), dtype `part.block_totals.EXECUTION_ROW` in the units of `UNITS`.
        """
        return executions_of(self.strokes)

    @property
    def seconds(self) -> float:
        """Time of the whole run, s."""
        return float(self.parts["seconds"].sum())

    @property
    def cost_per_good_part(self) -> float:
        """All costs over the expected number of good parts, $; infinite without good parts."""
        good = float(self.parts["survival"].sum())
        return float(self.parts["total_cost"].sum()) / good if good > 0.0 else float("inf")

    def to_dataframe(self, table: Literal["strokes", "executions", "dresses", "parts"] = "strokes") -> Any:
        """Return a table as a pandas data frame; its columns have their units, as in `frame["power [W]"]`.

        For a job with stations, `frame["station"]` has their names; on an out-of-model machine, `frame["plant"]` has
        the name of the machine.

        Raises:
            RecordError: there is no such table.
            MissingExtra: pandas is not installed.
        """
        tables = ("strokes", "executions", "dresses", "parts")
        if table not in tables:
            raise RecordError(f"a record has no table {quoted(table)}: its tables are {', '.join(tables)}")
        with needing("data", "data frames need"):
            import pandas
        rows = getattr(self, table)
        frame = pandas.DataFrame({heading(name): rows[name] for name in rows.dtype.names or ()})
        if self.job.plant:
            frame["plant"] = self.job.plant
        if self.job.stations:
            frame.insert(1, "station", [self.job.station_of(number) for number in rows["part"].tolist()])
        return frame

    def plot(self) -> "Figure":
        """Return a figure of depth, power, heat, wheel, roughness and size with the limits, as `grind run --plot`.

        Raises:
            MissingExtra: matplotlib is not installed.
        """
        figure: Figure = presenter("records").figure(self)
        return figure

    def _repr_html_(self) -> str:
        return html("records", self)

    def write(self, path: str | Path) -> None:
        """Write the strokes to a `.csv` or `.parquet` file, which appears only when it is complete.

        The numbers of a CSV file are rounded, and its header has the units, as in `time [s]`.

        Raises:
            RecordError: the path has another suffix.
            MissingExtra: pyarrow, which a parquet file needs, is not installed.
            FileError: the folder does not exist or cannot be written to.
        """
        path = Path(path)
        writers = {".csv": self._write_csv, ".parquet": self._write_parquet}
        if path.suffix not in writers:
            found = repr(path.suffix) if path.suffix else "no suffix"
            raise RecordError(f"{path}: a record is written as .csv or .parquet, not with {found}")
        write_atomically(path, writers[path.suffix])

    def _write_csv(self, path: Path) -> None:
        with path.open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            names = STROKE_ROW.names or ()
            plant = [self.job.plant] if self.job.plant else []
            writer.writerow([*(heading(name) for name in names), *(["plant"] if plant else [])])
            forms = [DIGITS.get(name, ".6g" if STROKE_ROW[name] == np.float64 else "d") for name in names]
            for row in self.strokes.tolist():
                writer.writerow([*(format(value, form) for value, form in zip(row, forms, strict=True)), *plant])

    def _write_parquet(self, path: Path) -> None:
        with needing("data", "parquet files need"):
            import pyarrow
            import pyarrow.parquet
        columns = {name: self.strokes[name] for name in STROKE_ROW.names or ()}
        if self.job.plant:
            columns["plant"] = np.full(len(self.strokes), self.job.plant)
        pyarrow.parquet.write_table(pyarrow.table(columns), path)

"""A grinding record as a table for the terminal, and as plain data for JSON."""

from typing import TYPE_CHECKING, Any

from grind_env.machine.job import Job
from grind_env.machine.record import GrindingRecord

if TYPE_CHECKING:
    from rich.console import Console

COLUMNS = {
    "part": ("part", "{:d}"),
    "seconds": ("time\ns", "{:.1f}"),
    "strokes": ("strokes", "{:d}"),
    "dresses": ("dresses", "{:d}"),
    "size_error": ("size\nerr. µm", "{:.1f}"),
    "Ra": ("Ra\nµm", "{:.2f}"),
    "peak_power": ("power\nkW", "{:.2f}"),
    "rise": ("temp.\nrise K", "{:.0f}"),
    "survival": ("good\n%", "{:.1f}"),
    "total_cost": ("cost\n$", "{:.2f}"),
}
"""Heading and format of each column, by the field of `record.PART_ROW`."""

SCALES = {"peak_power": 0.001, "survival": 100.0}
"""What a field is multiplied by to have the unit of its heading."""


def print_record(record: GrindingRecord, job: Job, title: str, console: "Console") -> None:
    """Print a row per part, values beyond a limit in red, then totals and warnings."""
    from rich import box
    from rich.table import Table
    from rich.text import Text

    table = Table(title=Text(title), title_justify="left", box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0))
    for heading, _ in COLUMNS.values():
        table.add_column(heading, justify="right")
    for part in record.parts:
        beyond = _beyond(part, job)
        table.add_row(
            *(
                Text(form.format(part[name] * SCALES.get(name, 1)), "red" if name in beyond else "")
                for name, (_, form) in COLUMNS.items()
            )
        )
    console.print(table)
    cost, good = record.parts["total_cost"].sum(), record.parts["survival"].sum()
    infeeds = record.parts["infeeds"].sum()
    console.print(
        f"{len(record.parts)} {'part' if len(record.parts) == 1 else 'parts'}, {good:.2f} of them good; "
        f"{record.seconds:.1f} s, {cost:.2f} $, {record.cost_per_good_part:.2f} $ per good part"
        + (f"; {infeeds} infeeds of grooves" if infeeds else ""),
        highlight=False,
    )
    for warning in record.warnings:
        console.print(Text(f"warning: {warning}", "yellow"), soft_wrap=True)


def as_data(record: GrindingRecord, title: str) -> dict[str, Any]:
    """The record without its strokes, in JSON types; names and units of `record.PART_ROW` and `DRESS_ROW`."""
    return {
        "program": title,
        "seconds": record.seconds,
        "cost": float(record.parts["total_cost"].sum()),
        "good_parts": float(record.parts["survival"].sum()),
        "parts": [dict(zip(record.parts.dtype.names or (), row, strict=True)) for row in record.parts.tolist()],
        "dresses": [dict(zip(record.dresses.dtype.names or (), row, strict=True)) for row in record.dresses.tolist()],
        "warnings": list(record.warnings),
    }


def _beyond(part: Any, job: Job) -> set[str]:
    """The fields of a part row that are beyond the limits of the job."""
    limits = job.limits
    failed = {"survival"} if part["survival"] < 0.5 else set()
    if part["rise"] > limits.rise:
        failed.add("rise")
    if part["peak_power"] > limits.power:
        failed.add("peak_power")
    if 0.0 < limits.roughness < part["Ra"]:
        failed.add("Ra")
    if 0.0 < limits.size < abs(part["worst_error"]):
        failed.add("size_error")
    return failed

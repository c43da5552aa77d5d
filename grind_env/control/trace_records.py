"""Records of events for `grind trace`, in the units that the program has in force."""

from typing import Any

from grind_env.control import numbers
from grind_env.control.errors import ControlError
from grind_env.control.events import Arc, Dwell, Event, Infeed, Line, Motion, Pick, Position, Rapid, Stroke

DECIMALS = 9  #: decimals that hide the rounding of sums and unit conversions, far below the control's resolution

KINDS: dict[type[Motion], str] = {
    Rapid: "rapid",
    Line: "line",
    Arc: "arc",
    Dwell: "dwell",
    Stroke: "line",
    Pick: "line",
    Infeed: "line",
}


def record(event: Event) -> dict[str, Any] | None:
    """Return the record of a motion; None for an event that moves nothing."""
    if not isinstance(event, Motion):
        return None
    unit = float(numbers.MILLIMETRES_PER_INCH) if event.inch else 1.0
    fields: dict[str, Any] = {"kind": KINDS[type(event)], "end": _point(event.end, unit)}
    if isinstance(event, Arc):
        fields.update(center=_point(event.centre, unit), rotation=event.rotation, plane=event.plane)
    if isinstance(event, Line | Arc | Stroke | Pick | Infeed):
        fields["feed"] = _number(event.feed / unit)
    fields.update(
        start=_number(event.begin),
        seconds=_number(event.seconds),
        block=event.block,
        line=event.line,
        source=event.source.value,
    )
    return fields


def error_record(error: ControlError, file: str = "") -> dict[str, Any]:
    """Return the record of an error; the message names the file of the error if this is not `file`."""
    elsewhere = f"{error.file}: " if error.file and error.file != file else ""
    return {
        "kind": "error",
        "error": error.name,
        "block": error.block,
        "line": error.line,
        "column": error.column,
        "message": elsewhere + error.message,
    }


def _point(position: Position, unit: float) -> list[float]:
    return [_number(coordinate / unit) for coordinate in position]


def _number(value: float) -> float:
    return round(value, DECIMALS) + 0.0

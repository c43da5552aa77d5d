"""Behaviour of part programs: the events of the control, and all that `grind run` prints and writes.

The programs are the examples of the package and the files in `programs/`. Some are also recorded with other settings
of the control or with actions of the operator; `grind run` has no option for most of them.
"""

import io
import json
from collections.abc import Callable, Mapping
from contextlib import redirect_stdout
from dataclasses import dataclass, field, fields, is_dataclass, replace
from enum import Enum
from pathlib import Path
from typing import Any

from grind_env.cli import BAD_INPUT, main
from grind_env.control import Control, CyclePlan, CycleStart, Event, Interrupt, execute, read_file
from grind_env.control.block_words import Block
from grind_env.control.control_settings import WHEEL_RADIUS
from grind_env.machine.grind import grind
from grind_env.machine.job.job_file import load_job
from grind_env.render.record_tables import as_data
from tests.behaviour.tables import Tables, flat, table

FOLDERS = (Path(__file__).parents[2] / "grind_env" / "examples", Path(__file__).with_name("programs"))

Panel = Mapping[int, Callable[[Control], None]]  #: actions of the operator, by the number of events before them


@dataclass(frozen=True)
class Variant:
    """Settings of the control and actions of the operator; with actions, only the events are recorded."""

    settings: Mapping[str, Any] = field(default_factory=dict)
    panel: Panel = field(default_factory=dict)


PLAIN = "as it is"

#: variants that are recorded of a program besides `PLAIN`, or in its place
VARIANTS: dict[str, dict[str, Variant]] = {
    "contour": {
        "type A": Variant({"compensation_type": "A", "radii": {1: 2.0}, "dress_amount": 0.04}),
        "type B": Variant({"compensation_type": "B", "radii": {1: 2.0}}),
    },
    "coordinates": {
        "with tables": Variant(
            {
                "work_offsets": {"G55": (1.0, 0.0, 2.0), "G59.3": (-1.0, 0.0, 0.0)},
                "external_offset": (0.5, 0.0, 0.25),
                "lengths": {3: (0.0, 0.125, 0.0)},
                "reference_points": ((-60.0, 30.0, 0.0), (-70.0, 35.0, 1.0), (-80.0, 40.0, 2.0), (-90.0, 45.0, 3.0)),
            }
        )
    },
    "feeds": {"feeds announced": Variant({"announce_cycles": True, "announce_feeds": True})},
    "grooves": {"short retract": Variant({"groove_retract": 0.05})},
    "grooving_wheel": {PLAIN: Variant({"groove_retract": 0.01})},
    "interrupts": {
        "type 1": Variant({"interrupts": (Interrupt(7, 1, True, 0.4), Interrupt(7, 1, False, 0.9))}),
        "type 2": Variant({"interrupts": (Interrupt(7, 2, True, 0.4), Interrupt(7, 2, False, 6.0))}),
        "at the panel": Variant(
            panel={
                3: Control.feedhold,
                4: Control.resume,
                8: lambda control: control.override(0.0),
                9: lambda control: control.override(150.0),
                12: Control.request_dress,
                16: lambda control: control.interrupt(7),
                40: lambda control: control.interrupt(7, 1),
                50: lambda control: control.override(100.0),
            }
        ),
        "block by block": Variant(panel={0: Control.single_block}),
    },
    "lots": {"deletable blocks skipped": Variant({"block_delete": True})},
    "plunge": {
        "no pass before spark-out": Variant({"coverage_pass": False}),
        "cycles announced": Variant({"announce_cycles": True}),
        "control follows the wheel": Variant(
            {"dress_amount": 0.04, "minimum_radius": 149.9, "radii": {WHEEL_RADIUS: 150.0}}
        ),
        "whole cycles, slower": Variant({"whole_cycles": True}, {0: lambda control: control.override(80.0)}),
    },
    "reciprocation": {"dresses asked for": Variant({"operator_dress_at": (1.0, 12.0)})},
    "traverse": {"dresses asked for": Variant({"operator_dress_at": (9.0, 25.0, 25.5, 60.0)})},
}

#: fields of the start of a cycle that are not recorded: their effects show in the strokes
SHOWN_ELSEWHERE = ("modes", "origins", "reciprocating")

#: tolerances (mm, s and relative) of programs with arcs, which use sines of the C library. All others are exact
TOLERANCES = {"contour": 1e-9}


def programs() -> dict[str, Path]:
    """Return the paths of the programs by name."""
    return {path.stem: path for folder in FOLDERS for path in sorted(folder.glob("*.nc"))}


def recorded(name: str) -> Tables:
    """Run every variant of a program; return its events and, without operator actions, its results and strokes."""
    tables: Tables = {}
    path = programs()[name]
    for title, variant in ({PLAIN: Variant()} | VARIANTS.get(name, {})).items():
        tables[f"{title}: events"] = table(map(described, events(path, variant)))
        if not variant.panel:
            ground = ground_with(path, variant.settings) if variant.settings else commanded(path)
            tables |= {f"{title}: {part}": rows for part, rows in ground.items()}
    return tables


def events(path: Path, variant: Variant) -> list[Event]:
    """Return the events of a program with the control of the job's machine."""
    job = load_job(path.with_suffix(".toml"))
    control = replace(job.control, **variant.settings)
    execution, found = execute(read_file(path), control), []
    execution.set_wheel_radius(0.5 * job.setup.wheel.diameter)
    while True:
        variant.panel.get(len(found), lambda _: None)(control)
        try:
            found.append(next(execution))
        except StopIteration:
            return found


def described(event: Event) -> dict[str, Any]:
    """Return an event as a row; only the start of a cycle includes its plan."""
    row: dict[str, Any] = {"event": type(event).__name__}
    for item in fields(event):
        value = getattr(event, item.name)
        if isinstance(value, Block):
            value = value.source.text
        if isinstance(value, CyclePlan) and not isinstance(event, CycleStart):
            continue
        if item.name in SHOWN_ELSEWHERE:
            continue
        if is_dataclass(value):
            value = {each.name: getattr(value, each.name) for each in fields(value)}
        row |= flat(item.name, value.value if isinstance(value, Enum) else value)
    return row


def commanded(path: Path) -> Tables:
    """Return the output of `grind run --json`, its exit status, and the strokes of the same run."""
    out, status = io.StringIO(), 0
    with redirect_stdout(out):
        try:
            main(["run", str(path), "--json"])
        except SystemExit as exit_:
            status = int(exit_.code or 0)
    assert status < BAD_INPUT, f"grind run refuses {path.name}"
    result = {"exit status": status, **dict(flat("", json.loads(out.getvalue())))}
    return {"result": table([result]), "strokes": ground_with(path, {})["strokes"]}


def ground_with(path: Path, settings: Mapping[str, Any]) -> Tables:
    """Return the result and strokes of `machine.grind` with settings of the control."""
    job = load_job(path.with_suffix(".toml"))
    record = grind(read_file(path), job, control=replace(job.control, **settings))
    names = record.strokes.dtype.names or ()
    strokes = [dict(zip(names, row, strict=True)) for row in record.strokes.tolist()]
    return {"result": table([dict(flat("", as_data(record, path.name)))]), "strokes": table(strokes)}

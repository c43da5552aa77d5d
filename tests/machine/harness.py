"""Helpers that describe a job and run a program text on it."""

from dataclasses import replace
from typing import Any

from grind_env.control import Control, Programs, execute, read
from grind_env.control.cycle_formulas import motion_time
from grind_env.machine.grind import grind
from grind_env.machine.job import Job, Part, PartConditions, Setup, Times, WheelStart
from grind_env.machine.job.drawn_machines import draw_machine
from grind_env.machine.job.uncertainty import Uncertainty
from grind_env.machine.loops.cycle import Stroking, dress_lead
from grind_env.machine.loops.table_speed import pace_of
from grind_env.machine.program_run import GrindingRun
from grind_env.machine.record import GrindingRecord
from grind_env.process.catalogue import load_catalogue
from grind_env.process.stroke_and_dress import dressed_wheel
from grind_env.process.stroke_types import StrokeParameters, WheelState

CATALOGUE = load_catalogue()

#: X reciprocates, Y plunges; the wheel stands 30 mm beside the part and at its surface
HEAD = "G71 G94 G90 G19\nG00 X-30. Y0 Z0\n"

CYCLE = "G82 X230. I-30. Y-.05 J-.01 L2 F60. E12000. P9100\n"
STROKE = 260.0 / 200.0 + 200.0 / 1000.0 + 0.15  #: time of a stroke of this cycle, s

#: two passes of 0.02 mm at 191 mm/min
DRESS = """
O9100
N1 G71 G90 G94
N2 G00 Y20.
N3 G00 X-120. Z-40.
N4 G00 Y10.
N5 G91 G01 Y-.02 F60.
N6 Z35. F191.
N7 Y-.02 F60.
N8 Z-35. F191.
N9 G90 G00 Y20.
N10 M99
"""

LONG_AFTER = (1e12,)  #: time of a dress request, s; such a request makes the machine step every stroke

#: numbers of this dress for the compiled loops
DRESS_NUMBERS = {"dress_passes": 2.0, "dress_feed": 191.0 / 60.0, "dress_depth": 0.02}


def stroking(speed: float, bottom: float, **changes: float) -> Stroking:
    """Return strokes of 260 mm over a covered part down to a depth, mm, at a table speed, mm/s."""
    seconds = motion_time(260.0, speed, 1000.0) + 0.15
    times = dict.fromkeys(("first_seconds", "stroke_seconds", "set_out"), seconds)
    none = dict.fromkeys(("start", "surface", "cross_start", "cross_end"), 0.0)
    part = {"bottom": bottom, "finish": bottom, "width": 20.0, "length": 200.0}
    pace = pace_of(speed, 260.0, 200.0, 0.0, 1000.0)._asdict()
    return Stroking(**{**pace, **times, **none, **part, **DRESS_NUMBERS, **changes})


def start_wheel(p: StrokeParameters, diamond_flat: float = 0.0) -> WheelState:
    """Return the dressed wheel with which a job begins."""
    wheel = dressed_wheel(300.0, diamond_flat, 0.1, 0.02, p)
    return dressed_wheel(300.0, diamond_flat, dress_lead(wheel, 191.0 / 60.0, p), 0.02, p)


def job(
    *,
    material: str = "aisi_52100",
    wheel: str = "a60j",
    setup: dict[str, Any] | None = None,
    load: float = 20.0,
    dress_setup: float = 8.0,
    wheel_start: WheelStart | None = None,
    **part: Any,
) -> Job:
    """Return the job of model.md, 200 mm x 20 mm of hardened 52100, with changes."""
    values = {"length": 200.0, "width": 20.0, "height": 20.0, "stock": 0.1, "scrap_cost": 40.0, **part}
    return Job(
        part=Part(material=CATALOGUE.material(material), **values),
        setup=Setup(
            **{
                "wheel": CATALOGUE.wheel(wheel),
                "dresser": CATALOGUE.dresser("single_point"),
                "fluid": CATALOGUE.fluid("emulsion"),
                "machine": CATALOGUE.machine("default"),
                "spindle": "always on",
                "coolant": "always on",
                **(setup or {}),
            }
        ),
        times=Times(load=load, dress_setup=dress_setup),
        wheel=wheel_start or WheelStart(),
    )


#: material without thermal growth: its strokes do not depend on time
STILL = replace(CATALOGUE.material("aisi_52100"), thermal_expansion=0.0)
#: set-up without cooling: a waiting part keeps its heat
TIMELESS = {
    "fluid": replace(CATALOGUE.fluid("emulsion"), part_cooling=0.0),
    "machine": replace(CATALOGUE.machine("default"), chuck_conductance=0.0),
}


def run(
    text: str, job: Job, *, control: Control | None = None, parts: tuple[PartConditions, ...] = ()
) -> GrindingRecord:
    return grind(read(text + DRESS, "test.nc"), replace(job, parts=parts or job.parts), control=control)


def machine_after(programs: Programs, job: Job, control: Control | None = None) -> GrindingRun:
    """Return the machine after a program; the control passes strokes or whole cycles."""
    control = control or job.control
    machine, execution = GrindingRun(programs, job, control), execute(programs, control)
    machine.tell(execution)
    for event in execution:
        machine.take(event)
        machine.tell(execution)
    return machine


def drawn_machines(job: Job, uncertainty: Uncertainty, seed: int, count: int) -> tuple[Job, ...]:
    return tuple(draw_machine(job, uncertainty, uncertainty.root, seed, k) for k in range(count))


def warnings_when_stepped(record: GrindingRecord) -> tuple[str, ...]:
    """Return the warnings of a stepped record, without the one on the late dress request."""
    late = [warning for warning in record.warnings if f"asked for at {LONG_AFTER[0]:g} s is not made" in warning]
    assert len(late) == 1
    return tuple(warning for warning in record.warnings if warning not in late)

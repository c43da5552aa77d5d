"""Log that a shop records of a batch: metered spindle power over time, and gauged parts."""

import math
import re
import shutil
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from agents.plants.program_variants import batch, write
from agents.plants.study_machines import StudyMachine
from grind_env.array_types import Array
from grind_env.control import read_file
from grind_env.control.program_reader import called_files
from grind_env.machine.grind import grind
from grind_env.machine.job import Job
from grind_env.machine.record import GrindingRecord
from grind_env.plants import Plant, find_plant

INTERVAL, MARGIN = 0.1, 15.0  #: time between samples, and time before and after the batch, s
#: idle power, W, amplitude, W, and period, s, of its slow swing, and noise of a sample, W
IDLE, SWING, SWINGS, NOISE = 600.0, 20.0, 700.0, 15.0
#: time that the operator takes at a stop, s, and pattern of the codes of a stop
PAUSE, STOP = 8.0, re.compile(r"\bM0[01]\b")
FEEDS = (1.0, 1.0, 0.8, 1.2, 1.0, 0.9, 1.1, 1.0)
#: factor on the E of the program, and whether the wheel is dressed, part by part
DRESSED = (True, False, False, True, False, False, True, False)
SIZE_NOISE, ROUGHNESS_NOISE = 1.0, 0.05  #: standard deviations of a gauged size, um, and of a gauged Ra, relative


@dataclass(frozen=True, slots=True, kw_only=True)
class Logged:
    """Files of a shop: program, job, log of a run and gauged parts; `gain` is the ratio of metered to true power."""

    program: Path
    job: Path
    log: Path
    gauge: Path
    gain: float


def logged(machine: StudyMachine, folder: Path) -> Logged:
    """Grind the program on a machine, with another E for each part, and write the files."""
    job, plant = machine.job(), find_plant(machine.plant)
    text = batch(machine.program, FEEDS, DRESSED)
    program = write(folder / "batch.nc", text)
    for called in called_files(machine.program.path):
        shutil.copy(called, folder)
    record = grind(read_file(program), job)
    files = folder / "log.csv", folder / "gauge.csv"
    write_log(files[0], record, text, plant, 1)
    write_gauge(files[1], record, job, 2)
    gain = dict(zip(plant.remembers._fields, plant.own, strict=True)).get("meter_gain", 1.0)
    return Logged(program=program, job=machine.program.job, log=files[0], gauge=files[1], gain=gain)


def write_log(path: Path, record: GrindingRecord, text: str, plant: Plant, seed: int) -> None:
    """Write the log of a run of a program, in s and W, as a meter of the family `meter` shows it."""
    rng, own = np.random.default_rng(seed), dict(zip(plant.remembers._fields, plant.own, strict=True))
    begins, ends = over_the_part(record, text)
    time = np.arange(-MARGIN, ends[-1] + MARGIN, INTERVAL)
    idle = IDLE + SWING * np.sin(2.0 * math.pi * time / SWINGS)
    shown = np.zeros(time.size)
    for begin, end, P in zip(begins.tolist(), ends.tolist(), record.strokes["power"].tolist(), strict=True):
        shown[(time >= begin) & (time < end)] = P
    shown += idle
    if "meter_gain" in own:
        warmed = 1.0 - np.exp(-np.maximum(time, 0.0) / own["meter_warms"])
        shown = own["meter_gain"] * (shown + own["meter_idle"] * own["meter_creeps"] * warmed)
    shown += NOISE * rng.standard_normal(time.size)
    rows = [f"{t + MARGIN:.2f},{P:.1f}" for t, P in zip(time.tolist(), shown.tolist(), strict=True)]
    path.write_text("\n".join(["time [s],power [W]", *rows]) + "\n", encoding="utf-8")


def over_the_part(record: GrindingRecord, text: str) -> tuple[Array, Array]:
    """Return the times when the wheel begins and ends each stroke over the part, s; every stop adds operator time."""
    strokes = record.strokes
    stops = np.array([number for number, line in enumerate(text.splitlines(), 1) if STOP.search(line)])
    stopped = np.diff(np.searchsorted(stops, strokes["line"]), prepend=0) != 0
    over = 60.0 * strokes["Lw"] / strokes["E"]
    begins = strokes["time"] + PAUSE * np.cumsum(stopped) + 0.5 * (strokes["seconds"] - over)
    return begins, begins + over


def write_gauge(path: Path, record: GrindingRecord, job: Job, seed: int) -> None:
    """Write the gauged values of the parts of a run: size and Ra of each, and whether burn was seen."""
    rng, rows = np.random.default_rng(seed), ["part,size [um],Ra [um],burn"]
    for part in record.parts:
        size = part["size_error"] + SIZE_NOISE * rng.standard_normal()
        Ra = part["Ra"] * math.exp(ROUGHNESS_NOISE * rng.standard_normal())
        rows.append(f"{part['part']},{size:.1f},{Ra:.3f},{int(part['rise'] > job.limits.rise)}")
    path.write_text("\n".join(rows) + "\n", encoding="utf-8")

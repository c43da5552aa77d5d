"""What a shop logs of a batch: the power of its spindle over time, as its meter shows it, and what was gauged."""

import math
from pathlib import Path

import numpy as np

from grind_env.arrays import Array
from grind_env.machine.job import Job
from grind_env.machine.record import GrindingRecord
from grind_env.plants import Plant

INTERVAL, MARGIN = 0.1, 15.0
"""s, between samples, and before and after the batch."""
IDLE, SWING, SWINGS, NOISE = 600.0, 20.0, 700.0, 15.0
"""W of the idling spindle, W and s of a slow swing of it, W of a sample."""
SIZE_NOISE, ROUGHNESS_NOISE = 1.0, 0.05
"""um, and relative."""


def write_log(path: Path, record: GrindingRecord, job: Job, plant: Plant, seed: int) -> None:
    """Write the log of a run, in s and W, with what a meter of the family `meter` makes of it."""
    rng, own = np.random.default_rng(seed), dict(zip(plant.remembers._fields, plant.own, strict=True))
    time = np.arange(-MARGIN, record.seconds + MARGIN, INTERVAL)
    idle = IDLE + SWING * np.sin(2.0 * math.pi * time / SWINGS)
    shown = power_over(record, job, time) + idle
    if "meter_gain" in own:
        warmed = 1.0 - np.exp(-np.maximum(time, 0.0) / own["meter_warms"])
        shown = own["meter_gain"] * (shown + own["meter_idle"] * own["meter_creeps"] * warmed)
    shown += NOISE * rng.standard_normal(time.size)
    rows = [f"{t + MARGIN:.2f},{P:.1f}" for t, P in zip(time.tolist(), shown.tolist(), strict=True)]
    path.write_text("\n".join(["time [s],power [W]", *rows]) + "\n", encoding="utf-8")


def power_over(record: GrindingRecord, job: Job, time: Array) -> Array:
    """Power above idle, W, at times of a run, s: that of a stroke while the wheel is over the part."""
    power, strokes = np.zeros(time.size), record.strokes
    over = 60.0 * strokes["Lw"] / strokes["E"]
    begins = strokes["time"] + 0.5 * (strokes["seconds"] - over)
    for begin, end, P in zip(begins.tolist(), (begins + over).tolist(), strokes["power"].tolist(), strict=True):
        power[(time >= begin) & (time < end)] = P
    return power


def write_gauge(path: Path, record: GrindingRecord, job: Job, seed: int) -> None:
    """Write what was gauged of the parts of a run: size and Ra of each, and whether burn was seen."""
    rng, rows = np.random.default_rng(seed), ["part,size [um],Ra [um],burn"]
    for part in record.parts:
        size = part["size_error"] + SIZE_NOISE * rng.standard_normal()
        Ra = part["Ra"] * math.exp(ROUGHNESS_NOISE * rng.standard_normal())
        rows.append(f"{part['part']},{size:.1f},{Ra:.3f},{int(part['rise'] > job.limits.rise)}")
    path.write_text("\n".join(rows) + "\n", encoding="utf-8")

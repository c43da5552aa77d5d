"""Logs of shops with deliberate faults, made from a run of a machine with known constants.

They are independent of the package's calibration: the table moves in small time steps, and a meter samples the spindle.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from grind_env.control import Programs, ProgramStop, Stroke, execute, read
from grind_env.envs.job.repeated_program import repeated
from grind_env.machine.grind import grind
from grind_env.machine.job import Job

TICK = 0.005  # s


@dataclass(frozen=True, kw_only=True)
class Style:
    """Format and faults of the log of a shop."""

    rate: float = 10.0  # samples a second
    unit: str = "kW"  # unit of the power in the heading: kW, W, % or A
    separator: str = ";"  # text between columns
    comma: bool = True  # whether decimals have a comma
    clock: str = "clock"  # format of the time: "clock", "s" or "ms"
    headings: tuple[str, ...] = ("Uhrzeit", "Spindelleistung")  # headings of time, power and, if logged, the dress bit
    before: tuple[str, ...] = ()  # lines before the heading
    idle: float = 1500.0  # idle power at the start, W
    warm_up: float = 250.0  # fall of the idle power as the spindle warms up, W
    coolant: float = 40.0  # amplitude of a slow swing of the idle power, W
    noise: float = 15.0  # standard deviation of each sample, W
    lag: float = 0.05  # time constant of the meter, s
    scale: float = 0.02  # logarithmic spread of the factor of the meter
    volts: float = 590.0  # W per ampere of a logged current: volts times root 3 and power factor
    gaps: int = 2  # number of gaps of some seconds
    duplicates: float = 0.005  # share of repeated rows
    swaps: float = 0.005  # share of rows swapped with the next one
    overrides: tuple[float, ...] = (1.0,)  # feed overrides to choose from, part by part
    extra: Mapping[str, str] = field(default_factory=dict)  # further columns without use
    gain: float = 1.0  # factor of the meter
    wander: float = 0.0  # standard deviation of the drift of the idle power in a minute, W
    stops: bool = True  # whether the operator lets the program stop at its M01


#: style of a log with seconds, W and decimal points
PLAIN = Style(unit="W", comma=False, separator=",", clock="s", headings=("time [s]", "power [W]"), scale=0.0)


def strokes_of(
    programs: Programs, job: Job, override: float, stops: list[float]
) -> list[tuple[float, np.ndarray, float]]:
    """Return begin (s), table positions per TICK (mm) and time (s) of each stroke; append program stops to `stops`."""
    control = replace(job.control, whole_cycles=False)
    table = []
    for event in execute(programs, control):
        if isinstance(event, ProgramStop):
            stops.append(event.time)
        if isinstance(event, Stroke):
            a, b = event.start[event.axis], event.end[event.axis]
            table.append(
                (event.begin, _positions(a, b, event.feed / 60.0 * override, control.acceleration), event.seconds)
            )
    return table


def strokes_on(
    programs: Programs, truth: Job, ground: Any, stops: list[float]
) -> list[tuple[float, np.ndarray, float]]:
    """Return the strokes as in `strokes_of`, for a machine that keeps neither speed nor dwell of its program."""
    table = []
    planned = list(execute(programs, replace(truth.control, whole_cycles=False)))
    ways = [event for event in planned if isinstance(event, Stroke)]
    late = ground["time"] - ground["time"][0] - (np.array([way.begin for way in ways])[: len(ground)] - ways[0].begin)
    stops += [
        event.time + float(np.interp(event.time, [way.begin for way in ways][: len(late)], late[: len(ways)]))
        for event in planned
        if isinstance(event, ProgramStop)
    ]
    for number, row in enumerate(ground):
        way = ways[min(number, len(ways) - 1)]
        places = _positions(way.start[way.axis], way.end[way.axis], row["E"] / 60.0, truth.control.acceleration)
        table.append((row["time"] - ground["time"][0] + ways[0].begin, places, places.size * TICK))
    return table


def _positions(a: float, b: float, speed: float, acceleration: float) -> np.ndarray:
    """Return the table positions per TICK, mm; the table speeds up, and brakes as late as it can."""
    way, s, v, places, step = abs(b - a), 0.0, 0.0, [0.0], TICK / 20
    while way - s > 1e-3 and len(places) < 1_000_000:
        v = min(v + acceleration * step, speed, max((2.0 * acceleration * (way - s)) ** 0.5, 1.0))
        s = min(s + v * step, way)
        places.append(s)
    return a + np.sign(b - a) * np.array(places)[::20]


def power_of(
    programs: Programs, truth: Job, parts: int, style: Style, rng: np.random.Generator
) -> tuple[np.ndarray, Any, np.ndarray]:
    """Return the power above idle per TICK (W), the record of the run, and a mask of the turning spindle."""
    overrides = rng.choice(style.overrides, parts)
    record = _ground(programs, truth, overrides)
    on_plant = truth.process.before is not None
    dwell = truth.control.reversal_dwell
    timeline: list[np.ndarray] = [np.zeros(int(rng.uniform(5.0, 30.0) / TICK))]
    turns: list[np.ndarray] = [np.zeros(timeline[0].size, bool)]
    for part in range(parts):
        stops: list[float] = []
        ground = record.strokes[(record.strokes["part"] - 1) * parts // len(record.parts) == part]
        strokes = (
            strokes_on(programs, truth, ground, stops)
            if on_plant
            else strokes_of(programs, truth, overrides[part], stops)
        )
        timeline.append(np.zeros(int(rng.uniform(3.0, 6.0) / TICK)))
        for number, (begin, places, seconds) in enumerate(strokes):
            over = (places >= truth.part.start) & (places <= truth.part.start + truth.part.length)
            timeline.append(np.where(over, ground["power"][number], 0.0))
            following = strokes[number + 1][0] if number + 1 < len(strokes) else begin + seconds
            pause = following - begin - seconds
            short = max(pause, 0.0) if on_plant else dwell
            rest = short if pause < 0.5 else dwell + pause * rng.uniform(0.7, 1.6)
            if style.stops and any(begin < stop <= following for stop in stops):
                rest += rng.uniform(2.0, 25.0)  # the operator gauges
            timeline.append(np.zeros(round(rest / TICK)))
        timeline.append(np.zeros(int(rng.uniform(1.5, 3.0) / TICK)))
        size = sum(each.size for each in timeline) - sum(each.size for each in turns)
        turns.append(np.ones(size, bool))
        timeline.append(np.zeros(int(rng.uniform(15.0, 90.0) / TICK)))
        turns.append(np.zeros(timeline[-1].size, bool))
    return np.concatenate(timeline), record, np.concatenate(turns)


def _ground(programs: Programs, truth: Job, overrides: np.ndarray) -> Any:
    """Return the record of the run; the text of each part has the E of its override."""
    if np.all(overrides == 1.0):
        return grind(repeated(programs, len(overrides)), truth)
    text = "\n".join(block.text for block in programs.main.blocks)
    others = list(programs)[1:]
    load = "\n".join(("G80", "M00", "G00 G18 G07 G71 G90 G94 G97 G40 G54"))
    each = [
        re.sub(r"\bE(\d+(?:\.\d*)?)", lambda match, o=o: f"E{float(match[1]) * o:.3f}", re.sub(r"M30", "", text))
        for o in overrides
    ]
    tail = "\n".join(f"O{program.number}\n" + "\n".join(block.text for block in program.blocks) for program in others)
    return grind(read(f"\n{load}\n".join(each) + "\nM30\n" + tail, programs.name), truth)


def write_log(path: Path, programs: Programs, truth: Job, parts: int, style: Style, rng: np.random.Generator) -> Any:
    """Write a log of some parts ground with the constants of a job and return the record of the run."""
    work, record, turns = power_of(programs, truth, parts, style, rng)
    time = np.arange(work.size) * TICK
    hours = time / 3600.0
    idle = (
        style.idle
        - style.warm_up * (1.0 - np.exp(-hours / 0.15))
        + style.coolant * np.sin(2 * np.pi * hours / 0.2 + rng.uniform(0, 6))
    )
    if style.wander:
        idle = idle + style.wander * np.cumsum(rng.standard_normal(time.size)) * np.sqrt(TICK / 60.0)
    true = np.where(turns, idle, 20.0) + work
    share = TICK / (style.lag + TICK)
    shown = style.gain * _filtered(true, share) * np.exp(style.scale * rng.standard_normal())
    at = np.arange(rng.uniform(0, 1) / style.rate, time[-1], 1.0 / style.rate)
    at = at + rng.normal(0.0, 0.02 / style.rate, at.size)
    value = np.interp(at, time, shown) + style.noise * rng.standard_normal(at.size)
    keep = np.ones(at.size, bool)
    for _ in range(style.gaps):
        begin = rng.uniform(0.0, time[-1])
        keep &= ~((at > begin) & (at < begin + rng.uniform(2.0, 8.0)))
    at, value = at[keep], value[keep]
    order = np.sort(
        np.concatenate([np.arange(at.size), rng.choice(at.size, int(style.duplicates * at.size), replace=False)])
    )
    for k in rng.choice(order.size - 1, int(style.swaps * order.size), replace=False).tolist():
        order[k], order[k + 1] = order[k + 1], order[k]
    at, value = at[order], value[order]
    factor = {"kW": 1e-3, "W": 1.0, "%": 100.0 / truth.setup.machine.power_limit, "A": 1.0 / style.volts}[style.unit]
    lines = [*style.before, style.separator.join((*style.headings, *style.extra))]
    begin = rng.uniform(0.0, 20.0 * 3600.0) if style.clock == "clock" else rng.uniform(0.0, 1000.0)
    for t, v in zip((begin + at).tolist(), (factor * value).tolist(), strict=True):
        cells = [_stamp(t, style), f"{v:.4f}", *style.extra.values()]
        lines.append(style.separator.join(cell.replace(".", ",") if style.comma else cell for cell in cells))
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return record


def _filtered(values: np.ndarray, share: float) -> np.ndarray:
    from scipy.signal import lfilter

    return lfilter([share], [1.0, share - 1.0], values, zi=[(1.0 - share) * values[0]])[0]


def _stamp(t: float, style: Style) -> str:
    if style.clock == "s":
        return f"{t:.3f}"
    if style.clock == "ms":
        return f"{1000.0 * t:.0f}"
    t = t % 86_400.0
    whole = int(t)
    return f"{whole // 3600:02d}:{whole // 60 % 60:02d}:{whole % 60:02d}.{int((t - whole) * 1000):03d}"


def write_gauge(path: Path, record: Any, rng: np.random.Generator, *, filled: float = 0.6) -> None:
    """Write the gauge file of a run: Ra with its scatter, size, burn; many cells are empty."""
    lines = ["Teil;Ra [µm];Abmaß [µm];Schleifbrand"]
    for row in record.parts:
        Ra = row["Ra"] * np.exp(0.15 * rng.standard_normal()) * np.exp(0.05 * rng.standard_normal())
        size = row["size_error"] + 2.0 * rng.standard_normal()
        cells = [f"{Ra:.2f}", f"{size:.1f}", "ja" if row["rise"] > record.job.limits.rise else "nein"]
        shown = [cell.replace(".", ",") if rng.random() < filled else "" for cell in cells]
        lines.append(";".join((f"{row['part']}", *shown)))
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")

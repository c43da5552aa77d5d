"""How far off is a calibration on machines that are not the model? `python -m tests.shop.machines --seeds 1 2 3`.

Of each family, seed and program a log is written and calibrated; then the program is ground with other E, D and depths,
and the mean power of its blocks compared with that of the machine, without noise, as its meter's gain shows it: error,
%, of the calibration, of the catalogue, and of the regression that a shop can do without a model.
"""

import argparse
import re
import tempfile
import time
import warnings
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from grind_env.control import Programs, read, read_file
from grind_env.envs.job.text import repeated
from grind_env.errors import GrindError
from grind_env.examples import FOLDER as EXAMPLES
from grind_env.machine.grind import grind
from grind_env.machine.job import Job
from grind_env.machine.job.file import load_job
from grind_env.plants import Plant, find_plant
from grind_env.shop.calibrate.calibration import calibrate
from grind_env.shop.calibrate.result import Calibration
from tests.shop import regression
from tests.shop.blemished import Style, write_gauge, write_log

PROGRAMS = ("plate_g82", "rail_g83", "keyway_g81")
FAMILIES = ("model", "foreign", "thermal", "meter", "table", "fluid", "soft", "drift")
"""`bursts` and `graded` are left for the end."""
OTHERS = ((1.0, 1.0, True), (0.6, 1.0, True), (1.5, 1.0, True), (1.0, 0.5, True), (1.0, 1.6, True), (1.3, 1.4, False))
"""Factors on E and on depth of cut, and whether it is dressed."""
VARIED = ((1.0, 1.0, True), (1.4, 0.7, False), (0.75, 1.4, True))
"""The same of the parts of a log that tells more."""
STYLE = Style(
    rate=10.0, unit="W", comma=False, separator=",", clock="s", headings=("time [s]", "spindle power [W]"), scale=0.0
)


def style_of(plant: Plant) -> Style:
    """How its log looks."""
    own = dict(zip(plant.remembers._fields, plant.own, strict=True))
    idle = own.get("meter_idle", STYLE.idle)
    return replace(
        STYLE,
        lag=max(1.5 * own.get("meter_lag", 0.0), STYLE.lag),
        idle=idle,
        warm_up=-idle * own.get("meter_creeps", -0.1),
        wander=own.get("drift_idles", 0.0),
        gain=own.get("meter_gain", 1.0),
    )


def changed(programs: Programs, speed: float, depth: float, dresses: bool) -> Programs:
    """A program with other words."""
    return read("\n".join([_changed(programs, speed, depth, dresses), *_others(programs)]), programs.name)


def varied(programs: Programs) -> str:
    """A program of three parts, ground differently."""
    load = "\nG80\nM00\nG00 G18 G07 G71 G90 G94 G97 G40 G54\n"
    each = [re.sub(r"M30|%", "", _changed(programs, *words)) for words in VARIED]
    return "\n".join([load.join(each), "M30", *_others(programs)]) + "\n"


def _others(programs: Programs) -> list[str]:
    return [f"O{each.number}\n" + "\n".join(block.text for block in each.blocks) for each in list(programs)[1:]]


def _changed(programs: Programs, speed: float, depth: float, dresses: bool) -> str:
    text = "\n".join(block.text for block in programs.main.blocks)
    text = re.sub(r"\bE(\d+\.?)", lambda m: f"E{speed * float(m[1]):.0f}.", text)
    text = re.sub(r"\bJ-(\.\d+)", lambda m: f"J-{depth * float(m[1]):.5f}", text)
    text = re.sub(r"(G01 Y-\.\d+ F)(\.\d+)", lambda m: f"{m[1]}{speed * depth * float(m[2]):.4f}", text)
    if not dresses:
        text = re.sub(r"\bD\d\b", "D0", text)
    return text


def blocks_of(record: Any) -> tuple[np.ndarray, np.ndarray]:
    """Of each stroke of the table the number of its block, part by part, and its power."""
    rows = record.strokes[record.strokes["groove"] == 0]
    _, number = np.unique(rows["part"] * 100_000 + rows["line"], return_inverse=True)
    return number, rows


def powers_of(record: Any) -> tuple[np.ndarray, np.ndarray]:
    """Number of the block, and power, W, of each stroke."""
    number, rows = blocks_of(record)
    return number, rows["power"]


def means(number: np.ndarray, power: np.ndarray) -> np.ndarray:
    """Mean power of each block."""
    return np.bincount(number, power) / np.bincount(number)


def off(guess: np.ndarray, true: np.ndarray) -> float:
    """Mean of |log| of blocks."""
    return float(np.mean(np.abs(np.log(np.maximum(guess, 1.0) / np.maximum(true, 1.0)))))


def errors(
    found: Calibration, logged: Programs, programs: Programs, catalogue: Job, truth: Job, gain: float, parts: int = 2
) -> np.ndarray:
    """Of each of `OTHERS`: error of calibration, catalogue, regression by strokes and by blocks."""
    strokes = len(blocks_of(grind(logged, catalogue))[0])
    number, rows = blocks_of(grind(repeated(logged, found.seen.weights.shape[1] // strokes), catalogue))
    rules = []
    power = found.data.kind == "power"
    weights, value = found.seen.weights, found.data.value[power]
    b = weights @ rows["b"]
    a, V = (weights @ (rows["b"] * rows[name]) / np.maximum(b, 1e-9) for name in ("ae", "V"))
    v = weights @ rows["E"] / 60.0
    block = np.array([number[np.flatnonzero(row)[0]] for row in weights])
    for by_block in (False, True):
        if by_block:
            count = np.bincount(block)
            used = count > 0
            at = [np.bincount(block, each)[used] / count[used] for each in (a, v, V, b, value)]
            rules.append(regression.fitted(*at, np.ones(int(used.sum()))))
        else:
            rules.append(regression.fitted(a, v, V, b, value, value**2))
    table = []
    for other in OTHERS:
        text = repeated(changed(programs, *other), parts)
        goal = gain * means(*powers_of(grind(text, truth)))
        number, plain = blocks_of(grind(text, catalogue))
        _, fit = blocks_of(grind(text, found.fitted))
        at = plain["ae"], plain["E"] / 60.0, plain["V"], plain["b"]
        by_stroke, by_block = (means(number, regression.predicted(rule, *at)) for rule in rules)
        shown = np.exp(found.fit.scales.get("power", 0.0))
        table.append(
            [
                off(each, goal)
                for each in (shown * means(number, fit["power"]), means(number, plain["power"]), by_stroke, by_block)
            ]
        )
    return np.array(table)


def trial(
    name: str, program: str, folder: Path, parts: int, *, varies: bool = False, seed: int = 1
) -> tuple[Calibration, np.ndarray]:
    """A calibration of a machine, and the errors."""
    plant = find_plant(name)
    path = EXAMPLES / f"{program}.toml"
    given = programs = read_file(EXAMPLES / f"{program}.nc")
    if varies:
        (folder / "varied.nc").write_text(varied(given), encoding="utf-8")
        programs, parts = read_file(folder / "varied.nc"), parts // len(VARIED)
    truth, rng = load_job(path, plant=plant), np.random.default_rng(seed)
    style = style_of(plant)
    record = write_log(folder / "log.csv", programs, truth, parts, style, rng)
    write_gauge(folder / "parts.csv", record, rng)
    ground = folder / "varied.nc" if varies else EXAMPLES / f"{program}.nc"
    found = calibrate(folder / "log.csv", ground, path, gauge=folder / "parts.csv")
    return found, errors(found, programs, given, load_job(path), truth, style.gain)


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--families", nargs="*", default=list(FAMILIES))
    parser.add_argument("--programs", nargs="*", default=list(PROGRAMS))
    parser.add_argument("--seeds", type=int, nargs="*", default=[1, 2, 3, 4, 5])
    parser.add_argument("--parts", type=int, default=6)
    parser.add_argument("--varied", action="store_true", help="logs of parts that are ground differently")
    given = parser.parse_args(arguments)
    warnings.simplefilter("ignore")
    print("machine, program: error of calibration, catalogue, regression by strokes and by blocks, %; s")
    with tempfile.TemporaryDirectory() as folder:
        for family in given.families:
            rows = []
            for seed in given.seeds if family != "model" else given.seeds[:1]:
                for program in given.programs:
                    name, begun = family if family == "model" else f"{family}:{seed}", time.monotonic()
                    try:
                        found, table = trial(name, program, Path(folder), given.parts, varies=given.varied)
                    except GrindError as error:
                        print(f"{name} {program}: refused: {error}", flush=True)
                        continue
                    rows.append(table.mean(axis=0))
                    said = " ".join(f"{100.0 * each:6.1f}" for each in rows[-1])
                    print(
                        f"{name:12} {program:10} {said}  {time.monotonic() - begun:4.1f} {summary(found)}", flush=True
                    )
            mean = np.mean(rows, axis=0)
            print(f"== {family:9} {'':10} {' '.join(f'{100.0 * each:6.1f}' for each in mean)}", flush=True)


def summary(found: Calibration) -> str:
    """What was found, in few words."""
    told = [each for each in found.estimates if each.told]
    values = [f"{each.parameter.key[:9]} {each.value / (each.parameter.prior or 1.0):.2f}" for each in told]
    return f"width {found.fit.width:g}; {', '.join(values)}"


if __name__ == "__main__":
    main()

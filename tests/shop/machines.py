"""Calibration of an out-of-model machine from a faulty log, with the errors of the machine study.

`python -m agents plants --question calibrate` prints the table of families and seeds.
"""

import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from agents.plants.power_errors import errors
from agents.plants.program_variants import scaled, write
from agents.plants.shop_log import Logged
from agents.plants.study_machines import StudyMachine, StudyProgram
from grind_env.control import Programs, read_file
from grind_env.examples import FOLDER as EXAMPLES
from grind_env.plants import Plant, find_plant
from grind_env.shop.calibrate.log_calibration import calibrate
from grind_env.shop.calibrate.result import Calibration
from tests.shop.blemished import PLAIN, Style, write_gauge, write_log

#: parts of a varied log: factor on E, factor on depth of cut, whether the wheel is dressed
VARIED = ((1.0, 1.0, True), (1.4, 0.7, False), (0.75, 1.4, True))


def style_of(plant: Plant) -> Style:
    """Return the style of a plant's log: lag, idle power and gain of its meter."""
    own = dict(zip(plant.remembers._fields, plant.own, strict=True))
    idle = own.get("meter_idle", PLAIN.idle)
    return replace(
        PLAIN,
        lag=max(1.5 * own.get("meter_lag", 0.0), PLAIN.lag),
        idle=idle,
        warm_up=-idle * own.get("meter_creeps", -0.1),
        wander=own.get("drift_idles", 0.0),
        gain=own.get("meter_gain", 1.0),
    )


def varied_program(programs: Programs) -> str:
    """Return a program of three parts that differ in E, depth of cut and dress."""
    load = "\nG80\nM00\nG00 G18 G07 G71 G90 G94 G97 G40 G54\n"
    text = "\n".join(block.text for block in programs.main.blocks)
    each = [re.sub(r"M30|%", "", scaled(text, E, J, dressed=D)) for E, J, D in VARIED]
    others = [f"O{each.number}\n" + "\n".join(block.text for block in each.blocks) for each in list(programs)[1:]]
    return "\n".join([load.join(each), "M30", *others]) + "\n"


def trial(
    name: str, program: str, folder: Path, parts: int, *, varies: bool = False
) -> tuple[Calibration, Mapping[str, float]]:
    """Return a calibration of a machine, and the errors of the fit, of a regression and of the catalogue."""
    path = EXAMPLES / f"{program}.nc"
    job = path.with_suffix(".toml")
    machine, plant = StudyMachine(name, StudyProgram(program, path, job)), find_plant(name)
    programs, rng = read_file(path), np.random.default_rng(1)
    if varies:
        path = write(folder / "varied.nc", varied_program(programs))
        programs, parts = read_file(path), parts // len(VARIED)
    style = style_of(plant)
    record = write_log(folder / "log.csv", programs, machine.job(), parts, style, rng)
    write_gauge(folder / "parts.csv", record, rng)
    files = Logged(program=path, job=job, log=folder / "log.csv", gauge=folder / "parts.csv", gain=style.gain)
    found = calibrate(files.log, path, job, gauge=files.gauge)
    return found, errors(machine, files, found)

"""Coverage of calibration intervals: constants drawn from the priors are fitted to logs with deliberate faults."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from grind_env.control import read_file
from grind_env.examples import FOLDER as EXAMPLES
from grind_env.machine.job.job_entries import with_entries
from grind_env.machine.job.job_file import load_job
from grind_env.shop.calibrate.fitted_constants import HEAT, chosen_parameters
from grind_env.shop.calibrate.least_squares import changes_of
from grind_env.shop.calibrate.log_calibration import calibrate
from grind_env.shop.calibrate.result import Calibration
from tests.shop.blemished import PLAIN, Style, write_gauge, write_log

PROGRAMS = ("plate_g82", "rail_g83", "keyway_g81")
STYLES = (
    Style(),
    replace(PLAIN, rate=50.0, lag=0.1, scale=0.02),
    Style(rate=5.0, separator="\t", comma=False, clock="ms", unit="kW", headings=("t [ms]", "Power [kW]"), noise=30.0),
    Style(rate=1.0, unit="%", headings=("Zeit", "Spindellast [%]"), scale=0.02),
    Style(rate=10.0, unit="A", headings=("Uhrzeit", "Strom Spindel [A]"), noise=25.0, scale=0.1),
    Style(rate=20.0, overrides=(0.8, 0.9, 1.0, 1.1), unit="kW", headings=("Hora", "Potencia husillo [kW]")),
)


def trial(
    seed: int, folder: Path, parts: int, program: str, style: Style
) -> tuple[Calibration, list[tuple[str, bool, bool, float]]]:
    """Return a calibration and a row for each constant: name, whether the log determines it, whether its interval
    holds the true value, and the error in posterior spreads."""
    rng = np.random.default_rng(seed)
    programs, job = read_file(EXAMPLES / f"{program}.nc"), load_job(EXAMPLES / f"{program}.toml")
    parameters = chosen_parameters(job, None, HEAT)
    z = np.append(rng.standard_normal(len(parameters) - 1), np.random.default_rng((seed, 1)).standard_normal())
    truth = with_entries(job, changes_of(parameters, z))
    log, gauge, said = folder / "log.csv", folder / "parts.csv", folder / "map.toml"
    record = write_log(log, programs, truth, parts, style, rng)
    write_gauge(gauge, record, rng)
    said.write_text(f"[log]\nrated_power = {job.setup.machine.power_limit}\n", encoding="utf-8")
    found = calibrate(log, EXAMPLES / f"{program}.nc", EXAMPLES / f"{program}.toml", gauge=gauge, map_file=said)
    rows = []
    known = {each.name: place for each, place in zip(parameters, z.tolist(), strict=True)}
    for each, fitted in zip(found.estimates, found.fit.z.tolist(), strict=True):
        true = known.get(each.parameter.name, 0.0)  # the true value of a free term is 0
        holds = each.low <= each.parameter.value(true) <= each.high
        rows.append((each.parameter.name, each.determined, holds, (fitted - true) / each.share))
    return found, rows

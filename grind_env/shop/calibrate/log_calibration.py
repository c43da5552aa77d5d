"""Calibration of the process model from the files of a shop."""

import math
from collections.abc import Callable, Collection, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from grind_env.array_types import Floats, Numbers
from grind_env.control import Programs, read_file
from grind_env.envs.job.program_outline import JobProgramError
from grind_env.files import shown
from grind_env.machine.job import Job
from grind_env.machine.job.job_entries import with_entries
from grind_env.machine.job.job_file import load_job
from grind_env.message_text import listed
from grind_env.plants.plant_names import MODEL
from grind_env.process.user_catalogue import OVERRIDES
from grind_env.shop.calibrate.column_names import Map, read_map
from grind_env.shop.calibrate.exceptions import CalibrationError
from grind_env.shop.calibrate.fit import Fit, FitProblem, fit_and_judge, residual_and_drift
from grind_env.shop.calibrate.fitted_constants import HEAT, chosen_parameters, free_parameters
from grind_env.shop.calibrate.gauged_parts import Gauged, check_gauges, gauges_of, measured_of, read_gauge
from grind_env.shop.calibrate.least_squares import Changes, Data
from grind_env.shop.calibrate.log_alignment import SAME_FEED, Alignment
from grind_env.shop.calibrate.meter_lag import FINEST, find_program, with_lag
from grind_env.shop.calibrate.power_logs import Log, averaged, read_log
from grind_env.shop.calibrate.result import Calibration, Idle
from grind_env.shop.calibrate.stroke_power import DISCREPANCY, DISCREPANCY_ACROSS, Observations, observe
from grind_env.shop.calibrate.stroke_schedule import Pattern, RepeatedProgram, pattern_of, powers
from grind_env.shop.calibrate.verdict import Errors
from grind_env.toml import read_toml

LEAST_POWER_ERROR = 0.002  #: least error of the power of a stroke, as a share of the root mean square of all strokes
HOPELESS = 0.3  #: error of the fitted power, over its root mean square, above which log and job do not belong together
MOST_RESIDUAL = 2.0  #: root mean square of the residuals, in measurement errors, that must be exceeded, too
WRONG_UNIT_FACTOR = 2.5  #: factor between measured and modelled power that no job causes, but a wrong unit does
#: greatest difference between 3 and the decimal logarithm of measured over modelled power if W and kW are confused
FACTOR_1000_TOLERANCE = 0.7
HOPELESS_ROUGHNESS = 1.0  #: error of the logarithm of Ra above which Ra is in another unit or of another part
LINES = 1_000_000  #: number above the number of lines of any program
#: logarithmic standard deviation of the scale of a meter in % whose rating is stated by the map or the job
STATED_SCALE_SPREAD = 0.02
REPORTED_DEVIATION = 1.5  #: deviation of a fitted scale that is reported, in standard deviations
MOST_NAMED_RUNS = 3  #: greatest number of left-out runs that a remark names


def calibrate(
    log: Path,
    program: Path,
    job: Path,
    *,
    gauge: Path | None = None,
    map_file: Path | None = None,
    names: Collection[str] | None = None,
    report_stage: Callable[[str], None] = lambda stage: None,
) -> Calibration:
    """Fit the process model to a log of the spindle's power."""
    map_ = read_map(map_file)
    settings, programs = load_job(job, plant=MODEL), read_file(program)
    if settings.parts:
        raise CalibrationError(
            f"{shown(job)} says how each part differs, but a calibration takes like parts; leave [[parts]] out"
        )
    free = free_parameters(settings) if names is None else ()
    report_stage("reading the log")
    rows = _bound(read_log(log, settings.setup.machine, map_), map_, job)
    gauged = None if gauge is None else read_gauge(gauge, map_)
    if gauged is not None:
        check_gauges(gauged, settings)
    tells_heat = gauged is not None and np.isfinite([gauged.size, gauged.burn]).any()
    parameters = chosen_parameters(settings, names, HEAT if tells_heat else ())
    pattern = pattern_of(programs, settings)
    usual = _usual(programs, settings)
    report_stage("looking for the program in the log")
    found, about = find_program(rows, pattern, usual)
    report_stage("fitting")
    rows = averaged(rows, rows.time * found.time_unit, FINEST)
    rows, found = with_lag(rows, pattern, found, usual, about)
    found = found.known
    seen = observe(rows, pattern, found)
    machine = RepeatedProgram(programs, settings, found.executions, found.overrides(pattern))
    extra = measured_of(gauged, found.executions * pattern.parts, settings)
    nominal = seen.weights @ powers(machine.run(settings))
    gain = float(nominal @ seen.power / (nominal @ nominal))  # power of the log over the power with the job's constants
    data = _data(seen, pattern, 1.0 if rows.known_scale else gain, extra)

    def predict(changes: Changes) -> Floats:
        changed = with_entries(settings, changes)
        record = machine.run(changed)
        return np.concatenate([seen.weights @ powers(record), gauges_of(record, changed, extra)])

    unlogged = 0 if gauged is None else int((gauged.part > found.executions * pattern.parts).sum())
    jumps, scales = bool(pattern.crosses.any()), {"power": rows.scale_spread} if rows.scale_spread else {}
    problem = FitProblem(parameters, scales, data, predict, report_stage, free, jumps)
    fitted, judged = fit_and_judge(problem)
    _refuse_hopeless(fitted, judged.errors, data, rows.unit, gain)
    block = np.zeros(data.value.size, np.int64)
    block[: seen.stroke.size] = pattern.line[seen.stroke] + LINES * _parts(seen, pattern)
    residual, drift = residual_and_drift(fitted, data, block)
    power_scale = math.exp(fitted.scales.get("power", 0.0))
    return Calibration(
        source=log.name,
        program=program.name,
        job=settings,
        data=data,
        fit=fitted,
        time=np.concatenate([seen.time, np.full(extra.part.size, np.nan)]),
        judged=judged,
        quality=found.quality,
        idle=_idle(seen, power_scale, rows.full, job) if rows.known_scale else None,
        meter_scale=rows.scale * power_scale if rows.known_scale else None,
        residual=residual,
        drift=drift,
        by_stroke=seen.by_stroke,
        seen=seen,
        remarks=(
            *rows.remarks,
            *(() if gauged is None else gauged.remarks),
            *([f"{unlogged} rows of the gauge file are of parts that are not in the log"] if unlogged else []),
            *log_remarks(rows, found, seen, pattern),
            *_scale_remarks(fitted, scales),
            *override_remarks(job, fitted, idle=rows.known_scale),
        ),
    )


def _usual(programs: Programs, job: Job) -> Floats:
    """Return the power of each stroke above idle with the catalogue, W, for a wheel that has ground before.

    The strokes are of a second execution, or of the first one if a program can be run only once.
    """
    try:
        program = RepeatedProgram(programs, job, 2)
    except JobProgramError:
        program = RepeatedProgram(programs, job)
    return powers(program.run(job))[-program.part.size :]


def _refuse_hopeless(fitted: Fit, errors: Errors, data: Data, unit: str, gain: float) -> None:
    """Refuse a fit that misses the log; `gain` is the power of the log, in its unit, over the catalogue's power."""
    error, of_power = errors["power"][2], (data.kind == "power") & fitted.used
    residual = float(np.sqrt(np.mean(np.square((data.value - fitted.predicted)[of_power] / data.error[of_power]))))
    if error > HOPELESS and residual > MOST_RESIDUAL:
        shown, meant = ("W", "kW") if gain < 1.0 else ("kW", "W")
        if unit == shown.lower() and gain > 0.0 and abs(abs(math.log10(gain)) - 3.0) < FACTOR_1000_TOLERANCE:
            raise CalibrationError(
                f"the log shows {gain:.2g} times the power that the catalogue expects, so that it is in {meant} and "
                f"not in {shown}, a factor of 1000; write {meant} in its heading, or say it with a map: [log] "
                f'power_unit = "{meant}"'
            )
        measured, modelled = data.value[of_power], fitted.predicted[of_power]
        times = float(measured @ modelled / (modelled @ modelled))
        is_right = 1.0 / WRONG_UNIT_FACTOR < times < WRONG_UNIT_FACTOR
        remedy = "part, wheel and machine of the job" if is_right else "the unit of the power"
        raise CalibrationError(
            f"even with the best constants the power of the strokes differs from the log by {100.0 * error:.0f} % (the "
            f"log shows {times:.3g} times as much), and {100.0 * HOPELESS:.0f} % is the most that is taken; check "
            f"{remedy}"
        )
    if "Ra" in errors and errors["Ra"][2] > HOPELESS_ROUGHNESS:
        raise CalibrationError(
            "even with the best constants Ra differs from what was gauged by a factor of "
            f"{math.exp(errors['Ra'][2]):.3g}; check the unit of Ra in the gauge file, um if none is said"
        )


def _data(seen: Observations, pattern: Pattern, unit: float, extra: Gauged) -> Data:
    power = seen.power / unit
    discrepancy = np.where(pattern.crosses[seen.stroke], DISCREPANCY_ACROSS, DISCREPANCY)
    error = np.sqrt(
        np.square(seen.error / unit)
        + np.square(discrepancy * power)
        + np.square(LEAST_POWER_ERROR * np.sqrt(np.mean(power**2)))
    )
    return Data(
        value=np.concatenate([power, extra.value]),
        error=np.concatenate([error, extra.error]),
        kind=np.concatenate([np.full(power.size, "power", "U10"), extra.kind]),
        part=np.concatenate([_parts(seen, pattern), extra.part]),
    )


def _parts(seen: Observations, pattern: Pattern) -> Numbers:
    """Return the part of each observation, from 1."""
    return seen.execution * pattern.parts + pattern.part[seen.stroke] + 1


def _bound(log: Log, map_: Map, job: Path) -> Log:
    """Return the log with a smaller uncertainty of its meter's scale if the map or the job states the rating."""
    stated = log.unit == "%" and (map_.number("log", "rated_power") is not None or _states_limit(job))
    return replace(log, scale_spread=min(log.scale_spread, STATED_SCALE_SPREAD)) if stated else log


def _states_limit(job: Path) -> bool:
    return "power_limit" in read_toml(job).get("setup", {}).get("machine_overrides", {})


def _scale_remarks(fitted: Fit, spreads: Mapping[str, float]) -> list[str]:
    """Return remarks on meters that would need another scale."""
    return [
        f"the {kind} fits better if its meter shows {100.0 * abs(math.expm1(scale)):.0f} % or more too "
        f"{'much' if scale > 0.0 else 'little'}; check its scale and rating"
        for kind, scale in fitted.scales.items()
        if abs(scale) > REPORTED_DEVIATION * spreads[kind]
    ]


def _idle(seen: Observations, scale: float, full: float | None, job: Path) -> Idle:
    idle = seen.idle[np.isfinite(seen.idle)] / scale
    whole = None if full is None else full / scale
    return Idle(float(np.median(idle)), float(idle.min()), float(idle.max()), whole, not _states_limit(job))


def log_remarks(log: Log, found: Alignment, seen: Observations, pattern: Pattern) -> list[str]:
    """Return remarks on the alignment of the log."""
    executions = f"{found.executions} times" if found.executions > 1 else "once"
    remarks = [f"the program is in the log {executions}; median correlation with its strokes {found.quality:.2f}"]
    if log.lag:
        remarks.append(f"the meter lags by about {log.lag:.2g} s, which was taken out")
    if not log.sure_of_time:
        remarks.append(f"the time has no unit; as the program says it is in {'s' if found.time_unit == 1.0 else 'ms'}")
    changed = [f"part {k}: {100.0 * each:.0f} %" for k, each in enumerate(found.overrides(pattern), 1) if each != 1.0]
    if changed:
        remarks.append(f"the feed was overridden, {listed(changed)}")
    usual = found.usual_override(pattern)
    if abs(np.log(usual)) > np.log(SAME_FEED):
        remarks.append(
            f"in all parts the table went at {100.0 * usual:.0f} % of its pace; what is found holds for the feeds as "
            "they are programmed"
        )
    left_out = np.argwhere(np.isfinite(found.correlation) & ~found.sure)
    if left_out.size:
        firsts = pattern.firsts[left_out[:, 1]]
        parts = left_out[:, 0] * pattern.parts + pattern.part[firsts] + 1
        names = [
            f"part {part} from line {line} on"
            for part, line in zip(parts.tolist(), pattern.line[firsts].tolist(), strict=True)
        ]
        remarks.append(
            f"runs of strokes that are not in the log as programmed were left out: {listed(names, MOST_NAMED_RUNS)}; a "
            "feed that was overridden in the middle is such a case"
        )
    if pattern.crosses.any():
        remarks.append(
            "of cycles that cross means of whole blocks are fitted, for what one stroke of them cuts a log does not "
            "tell"
        )
    if not seen.by_stroke:
        remarks.append(
            "the log has fewer than five samples a stroke, so that means of whole runs of strokes are fitted"
        )
    return remarks


def override_remarks(job: Path, fitted: Fit, *, idle: bool) -> list[str]:
    """Return a remark on constants that the job itself sets, so that those of a catalogue file have no effect."""
    setup = read_toml(job).get("setup", {})
    fixed = {f"{table.removesuffix('_overrides')}.{key}" for table in OVERRIDES for key in setup.get(table, {})}
    written = [each.name for each, known in zip(fitted.parameters, fitted.determined, strict=True) if known]
    written += ["machine.idle_power", "machine.power_limit"] if idle else []
    names = [name for name in written if name in fixed]
    if not names:
        return []
    return [f"the job sets {', '.join(names)} itself; take it out there, or what is found has no effect"]

"""`calibrate`: from the files of a shop to a calibration."""

import itertools
import math
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from grind_env.arrays import Numbers
from grind_env.control import Programs, read_file
from grind_env.envs.job.outline import JobProgramError
from grind_env.files import shown
from grind_env.machine.job import Job
from grind_env.machine.job.file import load_job
from grind_env.machine.record import GrindingRecord
from grind_env.shop.calibrate.align import Alignment, shifted
from grind_env.shop.calibrate.columns import read_map
from grind_env.shop.calibrate.errors import CalibrationError
from grind_env.shop.calibrate.fit import Fit, Problem, errors_of, fit
from grind_env.shop.calibrate.forward import Forward, powers
from grind_env.shop.calibrate.gauge import Gauge, read_gauge
from grind_env.shop.calibrate.logs import Log, read_log
from grind_env.shop.calibrate.meter import averaged, find, without_lag
from grind_env.shop.calibrate.observe import Observations, observe
from grind_env.shop.calibrate.parameters import Parameter, chosen_parameters, free_parameters, with_entries
from grind_env.shop.calibrate.pattern import Pattern, pattern_of
from grind_env.shop.calibrate.remarks import fit_remarks, gauge_remarks, log_remarks, overridden
from grind_env.shop.calibrate.result import Calibration, HeldOut, Idle, estimates_of, scales_of
from grind_env.shop.calibrate.sheet import Floats
from grind_env.shop.calibrate.solver import YES_OR_NO, Changes, Data, changes_of

DISCREPANCY, DISCREPANCY_ACROSS = 0.01, 0.03
"""Of the power of a stroke, and of a block of strokes that cross, than which no model of it does better."""
LEAST_POWER = 0.002
"""The same, of the root mean square of all strokes."""
SIZE_ERROR, ROUGHNESS_ERROR, DIAMETER_ERROR = 2.0, 0.05, 0.02
"""Of touching off and gauging, um; of a roughness gauge, relative; of measuring a wheel, mm."""
LEAST_WHEEL = 0.5
"""Of the diameter of a new wheel, below which it is none of that wheel."""
BURN_WIDTH = 0.05
"""Of the step in temperature rise at which burn is seen, of the rise that tempers."""
LINEAR_STEP = 0.5
"""Spreads of the prior over which the effect of a constant is taken to be linear."""
HOPELESS = 0.3
"""Error of the fitted power, over its root mean square, from which on log and job do not belong together."""
FAR = 2.5
"""Factor between measured and modelled power that no job makes, but a unit does."""
HOPELESS_ROUGHNESS = 1.0
"""Error of the logarithm of Ra from which on it is of another unit or part."""
CLEARLY = 0.8
"""Of the misfit of a place: what another one must have to be preferred."""
HELD_OUT = 4
"""One part in so many judges the fit, the last ones; from `ENOUGH_PARTS` on."""
ENOUGH_PARTS = 3


@dataclass(frozen=True, slots=True)
class _Gauged:
    """What was gauged, one value after the other.

    Attributes:
        value: as of `fit.Data`, like the next two.
        error: see there.
        kind: see there.
        part: of each, from 1.
        origin: part from whose wheel diameter that of the value is the difference; 0 of other kinds.
    """

    value: Floats
    error: Floats
    kind: NDArray[np.str_]
    part: Numbers
    origin: Numbers


def calibrate(
    log: Path,
    program: Path,
    job: Path,
    *,
    gauge: Path | None = None,
    map_file: Path | None = None,
    names: Collection[str] | None = None,
    told: Callable[[str], None] = lambda stage: None,
) -> Calibration:
    """Fit the process model to a log of the spindle's power.

    Args:
        log: text of rows with time and power.
        program: part program that was run, once or several times.
        job: what was ground on which machine.
        gauge: text with a row for every part that was measured.
        map_file: what the columns are, where their names do not say it.
        names: of the constants to fit; None for those of the usual ones that the log tells.
        told: is told what is being done.

    Raises:
        CalibrationError: nothing can be fitted; the message says why, and what to do.
        GrindError: program or job cannot be used.
    """
    said = read_map(map_file)
    settings, programs = load_job(job), read_file(program)
    if settings.parts:
        raise CalibrationError(
            f"{shown(job)} says how each part differs, but a calibration takes like parts; leave [[parts]] out"
        )
    parameters = chosen_parameters(settings, names)
    free = free_parameters(settings) if names is None else ()
    told("reading the log")
    rows = read_log(log, settings.setup.machine, said)
    gauged = None if gauge is None else read_gauge(gauge, said)
    if gauged is not None:
        _refuse_impossible(gauged, settings)
    pattern = pattern_of(programs, settings)
    usual = _usual(programs, settings)
    told("looking for the program in the log")
    found, about = find(rows, pattern, usual)
    told("fitting")
    rows = averaged(rows, found.time_unit)
    rows, found, lag = without_lag(rows, pattern, found, usual, about)
    found = _best_place(rows, pattern, usual, found, settings, programs, parameters).known
    model = _model(rows, pattern, found, gauged, settings, programs)
    seen, extra, data = model.seen, model.extra, model.data
    parts = found.executions * pattern.parts
    jumps, scales = bool(pattern.crosses.any()), {"power": rows.scale_spread}
    problem = Problem(parameters, scales, data, model.predict, free, jumps)
    fitted = fit(problem, told)
    _refuse_hopeless(fitted, data)
    held_out = None
    if data.held_out.any() and not data.held_out.all():
        told("fitting without the last parts")
        others = fit(problem, held_out=data.held_out, start=fitted)
        held_out = HeldOut(_last(parts), errors_of(others, data, data.held_out))
    return Calibration(
        source=log.name,
        program=program.name,
        job=settings,
        fitted=with_entries(settings, changes_of(fitted.parameters, fitted.z)),
        estimates=estimates_of(fitted),
        scales=scales_of(fitted),
        data=data,
        fit=fitted,
        label=(*_labels(seen, pattern), *(f"part {part}" for part in extra.part.tolist())),
        part=data.part,
        time=np.concatenate([seen.time, np.full(extra.part.size, np.nan)]),
        errors=errors_of(fitted, data, fitted.used),
        held_out=held_out,
        quality=found.quality,
        idle=_idle(seen, math.exp(fitted.scales["power"]), rows.full) if rows.known_scale else None,
        by_stroke=seen.by_stroke,
        seen=seen,
        remarks=(
            *rows.remarks,
            *(() if gauged is None else gauge_remarks(gauged, parts)),
            *log_remarks(rows, found, seen, pattern, lag),
            *fit_remarks(fitted),
            *overridden(job, fitted, idle=rows.known_scale),
        ),
    )


def _usual(programs: Programs, job: Job) -> Floats:
    """Power of each stroke above idle, W, as the catalogue has it, once the wheel has ground.

    That is in a second execution, but for a program that can be run only once.
    """
    try:
        forward = Forward(programs, job, 2)
    except JobProgramError:
        forward = Forward(programs, job)
    return powers(forward.run(job))[-forward.part.size :]


def _refuse_hopeless(fitted: Fit, data: Data) -> None:
    errors = errors_of(fitted, data, fitted.used)
    error = errors["power"][2]
    if error > HOPELESS:
        power = (data.kind == "power") & fitted.used
        measured, modelled = data.value[power], fitted.predicted[power]
        times = float(measured @ modelled / (modelled @ modelled))
        remedy = "part, wheel and machine of the job" if 1.0 / FAR < times < FAR else "the unit of the power"
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


@dataclass(frozen=True, slots=True)
class _Model:
    """What was measured in a log that is aligned in some way, and the machine that predicts it."""

    seen: Observations
    extra: _Gauged
    data: Data
    forward: Forward
    job: Job

    def predict(self, changes: Changes) -> Floats:
        """What would be measured with other constants."""
        changed = with_entries(self.job, changes)
        record = self.forward.run(changed)
        return np.concatenate([self.seen.weights @ powers(record), _predicted(record, changed, self.extra)])


def _model(log: Log, pattern: Pattern, found: Alignment, gauge: Gauge | None, job: Job, programs: Programs) -> _Model:
    seen = observe(log, pattern, found)
    forward = Forward(programs, job, found.executions, found.overrides(pattern))
    extra = _gauged(gauge, found.executions * pattern.parts, job)
    nominal = seen.weights @ powers(forward.run(job))
    unit = 1.0 if log.known_scale else float(nominal @ seen.power / (nominal @ nominal))
    return _Model(seen, extra, _data(seen, pattern, unit, extra, found.executions), forward, job)


def _best_place(
    log: Log,
    pattern: Pattern,
    expected: Floats,
    found: Alignment,
    job: Job,
    programs: Programs,
    parameters: tuple[Parameter, ...],
) -> Alignment:
    """The alignment that the model can agree with best, among those in which a run begins a stroke sooner or later.

    With constants of the catalogue a run may look more like the log one stroke beside its place. What other constants
    do is taken to be linear.
    """
    forward = Forward(programs, job, found.executions, found.overrides(pattern))
    nominal = powers(forward.run(job))
    moved = [
        powers(forward.run(with_entries(job, changes_of((each,), np.array([LINEAR_STEP]))))) for each in parameters
    ]
    slopes = np.column_stack([nominal, *((each - nominal) / LINEAR_STEP for each in moved)])

    def misfit(place: Alignment) -> float:
        seen = observe(log, pattern, place, found.sure)  # a place is no better because it has fewer runs
        observed = seen.weights @ slopes
        scale = float(observed[:, 0] @ seen.power / (observed[:, 0] @ observed[:, 0])) if not log.known_scale else 1.0
        error = np.hypot(seen.error / scale, DISCREPANCY * np.abs(observed[:, 0]).max())[:, None]
        columns = np.column_stack([log.scale_spread * observed[:, 0], observed[:, 1:]]) / error
        rest = (seen.power / scale - observed[:, 0]) / error[:, 0]
        count = columns.shape[1]
        z = np.linalg.solve(columns.T @ columns + np.eye(count), columns.T @ rest)
        return float((np.square(rest - columns @ z).sum() + z @ z) / rest.size)

    best, least = found, misfit(found)
    for run, strokes in itertools.product(range(pattern.runs), (-1, 1)):
        other = shifted(found, log, pattern, expected, run, strokes)
        value = math.inf if other is None else misfit(other)
        if other is not None and value < CLEARLY * least:
            best, least = other, value
    return best


def _data(seen: Observations, pattern: Pattern, unit: float, extra: _Gauged, executions: int) -> Data:
    power = seen.power / unit
    discrepancy = np.where(pattern.crosses[seen.stroke], DISCREPANCY_ACROSS, DISCREPANCY)
    error = np.sqrt(
        np.square(seen.error / unit)
        + np.square(discrepancy * power)
        + np.square(LEAST_POWER * np.sqrt(np.mean(power**2)))
    )
    parts = executions * pattern.parts
    kept = parts - (max(parts // HELD_OUT, 1) if parts >= ENOUGH_PARTS else 0)
    part = np.concatenate([_parts(seen, pattern), extra.part])
    return Data(
        value=np.concatenate([power, extra.value]),
        error=np.concatenate([error, extra.error]),
        kind=np.concatenate([np.full(power.size, "power", "U10"), extra.kind]),
        part=part,
        held_out=part > kept,
    )


def _parts(seen: Observations, pattern: Pattern) -> Numbers:
    """Of each observation the part that it is of, from 1."""
    return seen.execution * pattern.parts + pattern.part[seen.stroke] + 1


def _gauged(gauge: Gauge | None, parts: int, job: Job) -> _Gauged:
    """What was gauged of the parts that are in the log."""
    rows: list[tuple[float, float, str, int, int]] = []
    if gauge is not None:
        errors = {"size": SIZE_ERROR, "Ra": math.hypot(job.lots.roughness, ROUGHNESS_ERROR), YES_OR_NO: 1.0}
        inside = gauge.part <= parts
        for kind, error in errors.items():
            values = getattr(gauge, kind)
            rows += [(values[k], error, kind, gauge.part[k], 0) for k in np.flatnonzero(np.isfinite(values) & inside)]
        wheels = np.flatnonzero(np.isfinite(gauge.diameter) & inside)
        for k in wheels[1:]:
            less = gauge.diameter[k] - gauge.diameter[wheels[0]]
            rows.append((less, DIAMETER_ERROR * math.sqrt(2.0), "diameter", gauge.part[k], gauge.part[wheels[0]]))
    value, error_, kind_, part, origin = zip(*rows, strict=True) if rows else ((), (), (), (), ())
    return _Gauged(
        np.array(value, np.float64),
        np.array(error_, np.float64),
        np.array(kind_, "U10"),
        np.array(part, np.int64),
        np.array(origin, np.int64),
    )


def _refuse_impossible(gauge: Gauge, job: Job) -> None:
    most = max(part.stock for part in (job.part, *(each.part for each in job.stations)))
    stock, wheel = 1e3 * most, job.setup.wheel.diameter
    for part, size, diameter in zip(gauge.part.tolist(), gauge.size.tolist(), gauge.diameter.tolist(), strict=True):
        if abs(size) > stock:
            raise CalibrationError(
                f"the size of part {part} is {size:g} um off, more than the stock of {stock:g} um that the job has; "
                "check the unit of the sizes and the nominal one"
            )
        if diameter < LEAST_WHEEL * wheel or diameter > wheel / LEAST_WHEEL:
            raise CalibrationError(
                f"the wheel is {diameter:g} mm after part {part}, and {wheel:g} mm new in the job; check the unit of "
                "its diameter, mm if none is said"
            )


def _predicted(record: GrindingRecord, job: Job, extra: _Gauged) -> Floats:
    """What the gauges would show."""
    parts, at = record.parts, extra.part - 1
    if not extra.part.size:
        return np.empty(0)
    last = np.searchsorted(record.strokes["part"], np.arange(1, len(parts) + 1), side="right") - 1
    diameter = record.strokes["ds"][last]
    limit = job.limits.rise
    values: Mapping[str, Floats] = {
        "size": parts["size_error"][at],
        "Ra": parts["Ra"][at],
        YES_OR_NO: (parts["rise"][at] - limit) / (BURN_WIDTH * limit),
        "diameter": diameter[at] - diameter[np.maximum(extra.origin - 1, 0)],
    }
    return np.select([extra.kind == kind for kind in values], list(values.values()))


def _last(parts: int) -> str:
    """Which parts are held out, as it is said."""
    last = max(parts // HELD_OUT, 1)
    return f"the last of {parts} parts" if last == 1 else f"the last {last} of {parts} parts"


def _idle(seen: Observations, scale: float, full: float | None) -> Idle:
    idle = seen.idle[np.isfinite(seen.idle)] / scale
    whole = None if full is None else full / scale
    return Idle(float(np.median(idle)), float(idle.min()), float(idle.max()), whole)


def _labels(seen: Observations, pattern: Pattern) -> list[str]:
    return [
        f"part {part}, line {pattern.line[stroke]}, "
        + _strokes(seen, pattern, stroke, run, stroke - pattern.firsts[run] + 1)
        for part, run, stroke in zip(
            _parts(seen, pattern).tolist(), seen.run.tolist(), seen.stroke.tolist(), strict=True
        )
    ]


def _strokes(seen: Observations, pattern: Pattern, stroke: int, run: int, number: int) -> str:
    if pattern.crosses[stroke]:
        return "all strokes"
    return f"stroke {number} of run {run + 1}" if seen.by_stroke else f"run {run + 1}"

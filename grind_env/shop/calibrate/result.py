"""The result of a calibration, for terminal, reports and catalogue files."""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from grind_env.array_types import Floats
from grind_env.files import write_atomically
from grind_env.machine.job import Job
from grind_env.machine.job.job_entries import entries_of, with_entries
from grind_env.message_text import listed
from grind_env.notebook_loader import html, presenter
from grind_env.shop.calibrate.exceptions import CalibrationError, WorseFit
from grind_env.shop.calibrate.fit import NORMAL_90, Fit, uncertainty_lines
from grind_env.shop.calibrate.fitted_constants import Parameter
from grind_env.shop.calibrate.least_squares import Data, changes_of
from grind_env.shop.calibrate.stroke_power import Observations
from grind_env.shop.calibrate.verdict import FitJudgement, FitVerdict
from grind_env.toml import toml_value

if TYPE_CHECKING:
    from matplotlib.figure import Figure

BARE_KEY = re.compile("[A-Za-z0-9_-]+")  #: a key that TOML takes without quotes


@dataclass(frozen=True, slots=True)
class FittedConstant:
    """Fitted constant."""

    parameter: Parameter  #: the constant, with its value in the catalogue
    value: float  #: most probable value, in the unit of the parameter; the catalogue's if undetermined
    low: float  #: lower end of the 90 % interval, in the unit of the parameter
    high: float  #: upper end of the 90 % interval, in the unit of the parameter
    determined: bool  #: whether the measurements determine it
    share: float  #: ratio of the posterior to the prior spread


@dataclass(frozen=True, slots=True)
class Idle:
    """Power of the idling spindle, W: `mean` under the strokes, `low` and `high` the lowest and highest of them.

    `full` is the power, W, idling included, at which a meter in per cent shows 100; None for other meters. Idle power
    is not `written` if the job itself states the power limit, because less power would then be left for grinding.
    """

    mean: float
    low: float
    high: float
    full: float | None = None
    written: bool = True


@dataclass(frozen=True, slots=True, eq=False)
class Calibration:
    """Calibration of a model."""

    source: str  #: file of the log or table
    program: str  #: name of the part program; empty for a table
    job: Job  #: job with the catalogue before
    data: Data  #: the measurements
    fit: Fit  #: fit to all measurements
    time: Floats  #: time of each measurement in the log, s; NaN for gauged values
    judged: FitJudgement  #: prediction errors of each kind of measurement
    quality: float = math.nan  #: median correlation of the log with the program, no unit; NaN for a table
    idle: Idle | None = None  #: power of the idling spindle, W; None for a table and for an unknown scale of the meter
    by_stroke: bool = True  #: whether each stroke has its own mean
    seen: Observations | None = None  #: observations of the log; None for a table
    meter_scale: float | None = None  #: reading over true power, a ratio; None if unknown
    residual: float = 0.0  #: logarithmic standard deviation of the unexplained power of a block, no unit
    drift: float = 0.0  #: logarithmic standard deviation of the step of the power level from part to part, no unit
    remarks: tuple[str, ...] = ()  #: sentences on how files were read and on what was left out

    @property
    def fitted(self) -> Job:
        """The job with the fitted constants."""
        return with_entries(self.job, changes_of(self.fit.parameters, self.fit.z))

    @property
    def estimates(self) -> list[FittedConstant]:
        """Value and interval of each constant that may have been fitted."""
        fit = self.fit
        found = zip(fit.parameters, fit.z.tolist(), fit.spread.tolist(), fit.determined.tolist(), strict=True)
        return [
            FittedConstant(p, p.value(z), p.value(z - NORMAL_90 * s), p.value(z + NORMAL_90 * s), determined, s)
            for p, z, s, determined in found
        ]

    @property
    def scales(self) -> Mapping[str, list[float]]:
        """Factor of each meter whose scale is uncertain, with its interval of 90 %, by kind of measurement."""
        half = {kind: NORMAL_90 * spread for kind, spread in self.fit.scale_spreads.items()}
        return {
            kind: [math.exp(value + side * half[kind]) for side in (0, -1, 1)]
            for kind, value in self.fit.scales.items()
        }

    @property
    def undetermined(self) -> tuple[str, ...]:
        """Return the constants that were not fitted, because the measurements do not determine them."""
        return tuple(each.parameter.name for each in self.estimates if not each.determined)

    @property
    def tells_nothing(self) -> bool:
        """Return whether a catalogue file would be empty."""
        return self.idle is None and not any(each.determined for each in self.estimates)

    @property
    def verdict(self) -> FitVerdict:
        """Return whether the fitted model may be used, and for what."""
        return self.judged.verdict(tells_nothing=self.tells_nothing)

    def write(self, path: str | Path, *, force: bool = False) -> None:
        """Write the catalogue file, as `grind calibrate -o`.

        Raises:
            WorseFit: the catalogue predicts a kind of measurement better, and `force` is False.
            CalibrationError: the measurements determine no constant.
            FileError: the folder does not exist or cannot be written to.
        """
        if self.tells_nothing:
            remedy = "log faster or more parts, or add gauged parts"
            raise CalibrationError(f"{path} was not written, because {self.source} determines no constant; {remedy}")
        if self.judged.worse and not force:
            raise WorseFit(
                f"{path} was not written, because the catalogue predicts {listed(self.judged.worse)} better; log more "
                "parts, check part and wheel of the job, or say --force"
            )
        write_atomically(Path(path), lambda temporary: temporary.write_text(catalogue_text(self), encoding="utf-8"))

    def plot(self) -> "Figure":
        """Return a figure of measured over modelled values, before and after the fit, a panel for each kind.

        Raises:
            MissingExtra: matplotlib is not installed.
        """
        figure: Figure = presenter("calibrations").figure(self)
        return figure

    def _repr_html_(self) -> str:
        return html("calibrations", self)


def catalogue_text(found: Calibration) -> str:
    """Return the text of a catalogue file that redefines the entries of the job with the fitted constants."""
    lines = [
        f"# Calibrated by `grind calibrate` from {_comment(found.source)}"
        + (f" and {_comment(found.program)}." if found.program else "."),
        '# A job takes it up as its last catalogue file: [catalogue] files = [..., "this file"].',
        "# Behind each value: the interval that holds it with 90 %, and what the catalogue had before.",
    ]
    kept = ", ".join(found.undetermined)
    if kept:
        lines.append(f"# Kept as the catalogue has them, because the measurements do not tell them: {kept}.")
    entries = entries_of(found.job)
    for kind, entry in entries.items():
        rows = [
            f"{each.parameter.key} = {each.value:.4g}  # {each.low:.3g} to {each.high:.3g}"
            f"{' ' + each.parameter.unit if each.parameter.unit else ''}; was {each.parameter.prior:.4g}"
            for each in found.estimates
            if each.determined and each.parameter.kind == kind
        ]
        if kind == "machine" and found.idle is not None and found.idle.written:
            rows += _idle_rows(found.job, found.idle)
        if kind == "machine" and found.meter_scale is not None:
            rows += [f"meter_scale = {found.meter_scale:.4g}  # what its power meter shows over the power"]
        if rows:
            key = entry.name if BARE_KEY.fullmatch(entry.name) else toml_value(entry.name)
            lines += ["", f"[{kind}.{key}]", f"base = {toml_value(entry.name)}", *rows]
    source = toml_value(f"calibrated from {found.source}")
    lines += ["", *uncertainty_lines(found.job, found.fit, source, found.residual, found.drift)]
    return "\n".join(lines) + "\n"


def grinding_power(job: Job, idle: Idle) -> float:
    """Return the power above idle left for grinding, W: as before, or 100 % of a meter in per cent less idle."""
    machine = job.setup.machine
    return machine.power_limit - machine.idle_power if idle.full is None else round(idle.full) - round(idle.mean)


def _idle_rows(job: Job, idle: Idle) -> list[str]:
    left = grinding_power(job, idle)
    origin = "as before" if idle.full is None else f"of the {idle.full:.0f} W that the meter shows as 100 %"
    return [
        f"idle_power = {idle.mean:.0f}  # {idle.low:.0f} to {idle.high:.0f} W under the strokes",
        f"power_limit = {left + round(idle.mean):.0f}  # leaves {left:.0f} W for grinding, {origin}",
    ]


def _comment(text: str) -> str:
    return "".join(each if each.isprintable() else "?" for each in text)

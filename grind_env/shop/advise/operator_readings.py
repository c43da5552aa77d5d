"""Readings of a block or part that an operator enters, checked."""

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from typing import Any

from grind_env.belief.power_sensor import POWER_NOISE, POWER_NOISE_FLOOR, POWER_RANGE
from grind_env.envs.job.job_simulation import JobSimulation
from grind_env.envs.job.program_outline import INCH, BlockOutline
from grind_env.envs.job.real_machine_episode import Measured
from grind_env.errors import GrindError
from grind_env.message_text import did_you_mean, quoted
from grind_env.process.equations import LEAST_DIAMETER
from grind_env.shop.measurements.measured_sheet import NO, YES

#: least power, W, and size error, um, that meters and gauges resolve; a smaller number is probably in kW or mm
LEAST_POWER, LEAST_SIZE = POWER_NOISE_FLOOR, 0.05
#: number of standard deviations of a reading by which noise may put the peak below the mean
SCATTER = 4.0 * math.sqrt(2.0)
MOST_RA = 50.0  #: highest possible Ra, um; no ground surface is rougher


class ReadingError(GrindError):
    """Reading that is no number, is out of range, or belongs to another block."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MachineReadings:
    """Readings of a block, or of a part that it finished; None for a missing reading."""

    block: int | None = None  #: number of the block, from 1, to check that no row is missing
    part: int | None = None  #: number of its part, from 1, to check that no row is missing
    E: float | None = None  #: table speed, in the units of the program, if not the advised one
    D: int | None = None  #: dress executions, if not the advised number
    # mean load of the spindle above idle in its last (up to six) full picks since a dress, W
    mean_power: float | None = None
    first_power: float | None = None  #: mean load above idle in its first full picks since a dress, W
    peak_power: float | None = None  #: highest load, W
    size_error: float | None = None  #: stock left on the finished part, um
    Ra: float | None = None  #: roughness of the finished part, um
    Ra_before: float | None = None  #: roughness of the part before, um, if unknown until now
    burn: bool | None = None  #: 1 if the part shows grinding burn, 0 if it was inspected and shows none
    diameter: float | None = None  #: wheel diameter, mm
    new_wheel: bool | None = None  #: 1 if the wheel was changed after the block
    new_lot: bool | None = None  #: 1 if the next part begins a new lot of material

    def given(self) -> dict[str, Any]:
        """Return the readings that are not missing, by name."""
        return {name: value for name, value in asdict(self).items() if value is not None}

    def measured(self, meter_scale: float = 1.0) -> Measured:
        """Return the readings for the episode; powers are divided by the meter's scale, and 0 if missing."""
        return Measured(
            mean_power=(self.mean_power or 0.0) / meter_scale,
            first_power=(self.first_power or 0.0) / meter_scale,
            peak_power=(self.peak_power or 0.0) / meter_scale,
            size_error=self.size_error,
            Ra=self.Ra,
            Ra_before=self.Ra_before,
            diameter=self.diameter,
            new_wheel=bool(self.new_wheel),
            new_lot=bool(self.new_lot),
        )


NAMES = tuple(each.name for each in fields(MachineReadings))
WHOLE, FLAGS = ("block", "part", "D"), ("burn", "new_wheel", "new_lot")
#: readings in danger of a wrong unit: name, least credible value, its unit, and the wrong unit
SLIPS = (
    *((name, LEAST_POWER, "W", "kW") for name in ("mean_power", "first_power", "peak_power")),
    ("size_error", LEAST_SIZE, "um", "mm"),
)
#: readings that only a block which finishes a part can have
OF_PART = ("size_error", "Ra", "Ra_before", "burn", "new_lot")


def readings_of(table: Mapping[str, Any], place: str) -> MachineReadings:
    """Return readings from a table of numbers or texts; an empty text or null is a missing reading."""
    values: dict[str, Any] = {}
    for name, value in table.items():
        if name not in NAMES:
            raise ReadingError(
                f"{place}: there is no reading {quoted(name)}{did_you_mean(str(name), NAMES)}: "
                f"the readings are {', '.join(NAMES)}"
            )
        if value is None or (isinstance(value, str) and not value.strip()):
            continue
        values[name] = _flag(name, value, place) if name in FLAGS else _number(name, value, place)
    return MachineReadings(**values)


def _number(name: str, value: Any, place: str) -> float | int:
    try:
        number = float(value) if isinstance(value, str | int | float) and not isinstance(value, bool) else math.nan
    except (ValueError, OverflowError):
        number = math.nan
    if not math.isfinite(number):
        raise ReadingError(f"{place}: {name} is {quoted(value)}, but must be a number; leave it empty if it is missing")
    if name not in WHOLE:
        return number
    if number != int(number):
        raise ReadingError(f"{place}: {name} is {quoted(value)}, but must be a whole number")
    return int(number)


def _flag(name: str, value: Any, place: str) -> bool:
    text = str(int(value) if isinstance(value, float) and value.is_integer() else value).strip().lower()
    if not (YES.fullmatch(text) or NO.fullmatch(text)):
        raise ReadingError(f"{place}: {name} is {quoted(value)}, but must be 1 or 0")
    return YES.fullmatch(text) is not None


def check_readings(readings: MachineReadings, simulation: JobSimulation, number: int, place: str) -> None:
    """Check readings against the block `number`, from 0; `place` says in messages where the readings are."""
    block, job = simulation.blocks[number], simulation.job
    for name, expected in (("block", number + 1), ("part", block.part + 1)):
        found = getattr(readings, name)
        if found is not None and found != expected:
            raise ReadingError(f"{place}: this is of {name} {found}, but {name} {expected} is awaited: give that one")
    given = readings.given()
    if not block.finished and (early := next((name for name in OF_PART if name in given), None)):
        raise ReadingError(
            f"{place}: {early} is of a finished part, but block {number + 1} finishes none: give it with the last "
            f"block of part {block.part + 1}"
        )
    for name, (low, high, unit) in _ranges(simulation, block).items():
        value = given.get(name)
        if value is not None and not low <= value <= high:
            raise ReadingError(f"{place}: {name} is {value:g}, but must lie between {low:g} and {high:g} {unit}")
    for name, least, unit, other in SLIPS:
        value = given.get(name)
        if value is not None and 0.0 < abs(value) < least:
            raise ReadingError(f"{place}: {name} is {value:g} {unit}: if that is {other}, write {1000.0 * value:g}")
    means = [given[name] for name in ("mean_power", "first_power") if given.get(name)]
    most = max(means, default=0.0)
    if given.get("peak_power") and given["peak_power"] < most - SCATTER * (POWER_NOISE * most + POWER_NOISE_FLOOR):
        raise ReadingError(
            f"{place}: peak_power is {given['peak_power']:g}, but a mean power {most:g} W: no mean is above the "
            "highest load; read both again, or leave one out"
        )
    if readings.D and not block.takes_dresses:
        raise ReadingError(f"{place}: D is {readings.D}, but block {number + 1} can have no D word: leave it out")
    if readings.new_wheel and job.times.wheel_change is None and readings.diameter is None:
        raise ReadingError(f"{place}: new_wheel is 1, but not how large it is: give its diameter, mm, as well")


def _ranges(simulation: JobSimulation, block: BlockOutline) -> dict[str, tuple[float, float, str]]:
    """Return lowest and highest value of each reading, with the unit."""
    job, task = simulation.job.of_part(block.part + 1), simulation.task
    scale, unit = (1.0 / INCH, "inch/min") if block.inch else (1.0, "mm/min")
    slowest, fastest = (scale * bound for bound in task.action.speed_ends)
    power = (0.0, POWER_RANGE * job.setup.machine.power_limit, "W")
    return {
        "E": (slowest, fastest, unit),
        "D": (0, task.action.executions, "executions"),
        "mean_power": power,
        "first_power": power,
        "peak_power": power,
        "size_error": (-1000.0 * job.part.stock, 1000.0 * job.part.stock, "um"),
        "Ra": (0.0, MOST_RA, "um"),
        "Ra_before": (0.0, MOST_RA, "um"),
        "diameter": (LEAST_DIAMETER, job.setup.wheel.diameter + 1.0, "mm"),
    }

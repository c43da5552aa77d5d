"""What an agent sees before a stroke: what the machine measured in the strokes before, and the coming pick.

Names, scales and noise are those of `observations` wherever they mean the same.
"""

from typing import NamedTuple

from grind_env.belief.sensor import POWER_NOISE, POWER_NOISE_FLOOR, POWER_RANGE
from grind_env.envs.observations import PART_RISE, Reading, constant_readings, readings
from grind_env.envs.tasks import Task


class StrokeReadings(NamedTuple):
    """Everything that is observed before a stroke, in physical units and in the order of the observation."""

    power: float
    mean_power: float
    peak_power: float
    last_speed: float
    last_dress: float
    size_error: float
    roughness: float
    parts_since_gauged: float
    volume: float
    dresses: float
    diameter: float
    pick: float
    strokes_left: float
    stock: float
    starts_part: float
    new_lot: float
    remaining: float
    wear_flat: float
    loading: float
    diamond_flat: float
    wheel_volume: float
    growth: float
    pressure: float
    part_rise: float


MEASURED = StrokeReadings._fields.index("wear_flat")
"""Readings that are not of the hidden state."""


def stroke_readings(task: Task, *, full: bool) -> tuple[Reading, ...]:
    """The observation of the task, entry by entry; `full` with the hidden state behind it."""
    power = task.machine.power_limit
    low, high = task.action.speed_ends
    noise = f"{100.0 * POWER_NOISE:g} % + {POWER_NOISE_FLOOR:g} W"
    own = [
        Reading("power", "W", 0.0, power, 0.0, POWER_RANGE, noise, "load of the spindle above idle in the last stroke"),
        Reading("mean_power", "W", 0.0, power, 0.0, POWER_RANGE, noise,
                "mean of the power readings of the last (up to 6) full plunges since the last dress; 0 if none"),
        Reading("peak_power", "W", 0.0, power, 0.0, POWER_RANGE, noise, "highest load reading on the part"),
        Reading("last_speed", "m/min", (low + high) / 2.0, (high - low) / 2.0, -1.3, 1.0, "exact",
                "E of the last stroke"),
        Reading("last_dress", "", 0.0, 1.0, 0.0, 1.0, "exact", "1 if there was a dress before the last stroke"),
        Reading("pick", "mm", 0.0, 0.02, 0.0, 2.0, "exact", "pick before the coming stroke; 0 in spark-out"),
        Reading("strokes_left", "", 0.0, 20.0, 0.0, 5.0, "exact", "strokes left on the part"),
        Reading("stock", "of nominal", 1.0, 1.0, -1.0, 3.0, "pre-gauge of the task", "stock of the part"),
        Reading("starts_part", "", 0.0, 1.0, 0.0, 1.0, "exact", "1 if the coming stroke is the first on its part"),
        Reading("new_lot", "", 0.0, 1.0, 0.0, 1.0, "exact", "1 if the part begins a new lot"),
        Reading("remaining", "of all", 0.0, 1.0, 0.0, 1.0, "exact", "parts not yet finished"),
        Reading("growth", "", 1.0, 1.0, -1.0, 10.0, "hidden", "factor on wear-flat growth"),
        Reading("pressure", "", 1.0, 1.0, -1.0, 10.0, "hidden", "factor on wear-flat pressure"),
    ]  # fmt: skip
    known = {entry.name: entry for entry in (*readings(task, full=True), PART_RISE, *own)}
    names = StrokeReadings._fields if full else StrokeReadings._fields[:MEASURED]
    # the pick of a stroke changes: spark-out has none
    constant = constant_readings(task).keys() - {"pick"}
    return tuple(known[name] for name in names if name not in constant)

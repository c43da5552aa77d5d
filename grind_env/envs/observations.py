"""Observations: named readings with unit, scale, noise and delay.

A reading is computed in physical units and returned as `(value - offset) / scale`, about -1 to 1, cut at the
range of its sensor. `HIDDEN` readings are only in `observation="full"`.
"""

import math
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grind_env.belief.power_sensor import POWER_NOISE, POWER_NOISE_FLOOR, POWER_RANGE
from grind_env.envs.task_gauges import ROUGHNESS_NOISE, SIZE_NOISE, TAPER_NOISE
from grind_env.envs.tasks import Task

#: origin of an observed wheel diameter
BOOK = "by the shop's book: less what dresses take off, and the wear when it is gauged"
LEAST_SLACK = 0.05  #: ratio of time left to work left below which the slack does not change; `time_to_due` still does


class Readings(NamedTuple):
    """Everything that is observed before a block, in physical units; `readings` says what each one means.

    `mean_power`, `first_power` and `peak_power` are W. `last_speed` is mm/min. `last_pick`, `last_width`, `diameter`,
    `pick`, `width`, `length` and `diamond_flat` are mm. `size_error`, `roughness_limit`, `tolerance`, `taper` and
    `dressed_roughness` are um. `volume` and `wheel_volume` are mm3/mm, `dressed_density` is 1/mm2. `time_to_due` is s.
    `scrap` is $. `part_rise` is a temperature difference, K.

    `last_executions`, `parts_since_gauged`, `blocks_since_dress`, `dresses`, `sparkout` and `executions_left` are
    numbers of executions, parts, blocks or strokes. `roughness` (over its limit), `stock` (over the nominal one) and
    `remaining` (over all) are ratios. `slack` is the log of a ratio. `wear_flat` is a fraction of the wheel surface.
    `loading` is 0 to 1, with no unit. `growth`, `pressure`, `fracture`, `wear`, `convection` and `roughness_scale` are
    factors. `new_lot` and `last_pre_dress` are 1 if so, else 0.
    """

    mean_power: float
    first_power: float
    peak_power: float
    last_speed: float
    last_executions: float
    last_pick: float
    last_width: float
    size_error: float
    roughness: float
    parts_since_gauged: float
    volume: float
    blocks_since_dress: float
    dresses: float
    diameter: float
    pick: float
    width: float
    length: float
    sparkout: float
    stock: float
    roughness_limit: float
    tolerance: float
    scrap: float
    new_lot: float
    remaining: float
    last_pre_dress: float
    executions_left: float
    time_to_due: float
    slack: float
    taper: float
    wear_flat: float
    loading: float
    diamond_flat: float
    dressed_roughness: float
    dressed_density: float
    growth: float
    pressure: float
    fracture: float
    wear: float
    convection: float
    roughness_scale: float
    wheel_volume: float
    part_rise: float


class Reading(NamedTuple):
    """One entry of the observation: `(value - offset) / scale`, within `low` and `high`.

    `offset` and `scale` are in `unit`; `low` and `high` have no unit.
    """

    name: str
    unit: str
    offset: float
    scale: float
    low: float
    high: float
    noise: str
    meaning: str


#: readings with numbers of the kind of the coming block
OF_KIND = ("pick", "width", "length", "sparkout", "roughness_limit", "tolerance", "scrap")
PART_RISE = Reading("part_rise", "K", 0.0, 50.0, 0.0, 20.0, "hidden",
                    "mean temperature of the part in work over the hall; 0 of one not ground so far")  # fmt: skip
"""Reading for tasks and jobs in which a part has several blocks."""
HIDDEN = Readings._fields[Readings._fields.index("wear_flat") :]  #: readings that no real machine gives


def readings(task: Task, *, full: bool, pre_dress: bool = False) -> tuple[Reading, ...]:
    """Return the observation of a task, entry by entry, hidden ones last, without constant readings.

    Args:
        task: the task.
        full: whether to include the hidden state, for oracles and tests.
        pre_dress: whether an action can ask for a pre-dress.
    """
    absent = {*constant_readings(task, pre_dress=pre_dress), *(() if full else HIDDEN)}
    if not pre_dress:
        absent.add("last_pre_dress")
    if task.wheel_change is None:
        absent.add("executions_left")
    if task.due is None:
        absent |= {"time_to_due", "slack"}
    if all(kind.starts_part for kind in task.kinds):
        absent.add("part_rise")
    if task.cycle == "G81":
        absent.add("pick")
    if task.cycle != "G83":
        absent.add("taper")
    shown = (reading for reading in _table(task) if reading.name not in absent)
    # every full observation begins with the measured observation
    return tuple(sorted((*shown, *_one_hot(task)), key=lambda entry: entry.noise == "hidden"))


def constant_readings(task: Task, *, pre_dress: bool = False) -> dict[str, float]:
    """Return the measured readings, with values, that no choice, draw or context changes in a task.

    Readings of the last block before the first block, and of the coming block after the last block, do not count.
    """
    kinds = task.kinds
    constant = {
        name: float(getattr(kinds[0], name)) for name in OF_KIND if len({getattr(kind, name) for kind in kinds}) == 1
    }
    if "width" in constant:
        constant["last_width"] = kinds[0].width
    # during an infeed, the depth of a stroke depends on its time
    if "pick" in constant and task.infeed == 0.0:
        constant["last_pick"] = kinds[0].pick
    if task.action.executions == 0:
        constant |= {"last_executions": 0.0} if pre_dress else {"last_executions": 0.0, "dresses": 0.0}
    limited = any(kind.ends_part and kind.roughness_limit > 0.0 for kind in kinds)
    constant |= of_few_parts(task.parts, gauged=limited)
    if task.orders is None and task.spread.lot_probability == 0.0:
        constant["new_lot"] = 0.0
    return constant


def of_few_parts(parts: int, *, gauged: bool) -> dict[str, float]:
    """Return the readings of finished parts, with their values, that come after the last decision or never.

    Args:
        parts: number of parts of an episode; readings of the last part come after the last decision.
        gauged: whether roughness has a limit; the reading is the ratio to this limit.
    """
    size = {"size_error": 0.0} if parts < 2 else {}
    # the roughness of the first gauged part is known one part late
    return size | ({} if gauged and parts > 2 else {"roughness": 0.0, "parts_since_gauged": 0.0})


def _table(task: Task) -> list[Reading]:
    power = task.machine.power_limit
    low, high = task.action.speed_ends
    centre, half = (low + high) / 2.0, (high - low) / 2.0
    tolerance = max(max(kind.tolerance for kind in task.kinds), 1.0)
    most = max(task.action.executions, 1)
    period = (
        max(task.nominal_seconds(kind, task.due.speed) for kind in task.kinds) * task.due.blocks if task.due else 1.0
    )
    # an infeed covers 0.06 mm in a stroke at 3000 mm/min
    deepest = 5.0 if task.cycle == "G81" else 2.0
    left = "stock left on the last finished part"
    left += " where it is farthest from its size" if task.cycle == "G83" else ""
    factor = task.spread.measurement
    taper_noise = f"{TAPER_NOISE * factor:.2g} um" if factor > 0.0 else "exact"
    power_noise, size_noise, wheel_noise, ra_noise = (
        (
            f"{100.0 * POWER_NOISE * factor:g} % + {POWER_NOISE_FLOOR * factor:g} W",
            f"{SIZE_NOISE * factor:g} um",
            f"{2.0 * SIZE_NOISE * factor:g} um",
            f"{100.0 * ROUGHNESS_NOISE * factor:g} %, ",
        )
        if factor > 0.0
        else ("exact", "exact", "to 1 um", "")
    )
    table = [
        Reading("mean_power", "W", 0.0, power, 0.0, POWER_RANGE, power_noise,
                "mean load of the spindle above idle in the last (up to 6) full plunges since a dress; 0 if none"),
        Reading("first_power", "W", 0.0, power, 0.0, POWER_RANGE, power_noise,
                "mean load of the first (up to 6) full plunges of the last block"),
        Reading("peak_power", "W", 0.0, power, 0.0, POWER_RANGE, power_noise, "highest load of the last block"),
        Reading("last_speed", "mm/min", centre, half, -1.1, 1.0, "exact", "E of the last block"),
        Reading("last_executions", "", most / 2.0, most / 2.0, -1.0, 1.0, "exact", "D of the last block"),
        Reading("last_pick", "mm", 0.0, 0.02, 0.0, deepest, "exact", "depth per stroke of the last block"),
        Reading("last_width", "mm", 0.0, 60.0, 0.0, 5.0, "exact", "width of the last block"),
        Reading("size_error", "um", 0.0, tolerance, -5.0, 5.0, size_noise, left),
        Reading("roughness", "Ra/limit", 0.0, 1.0, 0.0, 5.0, f"{ra_noise}every third part, one part late",
                "Ra of the last gauged part over its limit"),
        Reading("parts_since_gauged", "", 0.0, 10.0, 0.0, 1.0, "exact", "parts since that gauging"),
        Reading("volume", "mm3/mm", 0.0, 300.0, 0.0, 20.0, "exact",
                "depth by the pre-gauge times length since the last dress, by book-keeping"),
        Reading("blocks_since_dress", "", 0.0, 10.0, 0.0, 20.0, "exact", "blocks since the last dress"),
        Reading("dresses", "", 0.0, 50.0, 0.0, 10.0, "exact", "dress executions so far"),
        Reading("diameter", "mm", 220.0, 80.0, 0.0, 1.5, wheel_noise, f"wheel diameter (offset 33), {BOOK}"),
        Reading("pick", "mm", 0.0, 0.02, 0.0, 2.0, "exact", "depth per stroke of the coming block"),
        Reading("width", "mm", 0.0, 60.0, 0.0, 5.0, "exact", "width of the coming block"),
        Reading("length", "mm", 0.0, 300.0, 0.0, 5.0, "exact", "length of the coming block"),
        Reading("sparkout", "", 0.0, 5.0, 0.0, 5.0, "exact", "spark-out strokes of the coming block"),
        Reading("stock", "of nominal", 1.0, 1.0, -1.0, 3.0, "pre-gauge of the task",
                "stock of the coming block"),
        Reading("roughness_limit", "um", 0.0, 1.0, 0.0, 5.0, "exact",
                "Ra limit of the coming block, 0 for none"),
        Reading("tolerance", "um", 0.0, 10.0, 0.0, 5.0, "exact", "tolerance of the coming block, 0 for none"),
        Reading("scrap", "$", 0.0, 100.0, 0.0, 5.0, "exact", "price of scrapping the coming part"),
        Reading("new_lot", "", 0.0, 1.0, 0.0, 1.0, "exact", "1 if the coming part begins a new lot"),
        Reading("remaining", "of all", 0.0, 1.0, 0.0, 1.0, "exact", "blocks still to grind"),
        Reading("last_pre_dress", "", 0.0, 1.0, 0.0, 1.0, "exact", "1 if the last block began with a dress"),
        Reading("executions_left", "", 0.0, 50.0, 0.0, 10.0, "exact",
                "dress executions before the wheel is below its minimum diameter"),
        Reading("time_to_due", "s", 0.0, period, -50.0, 10.0, "exact", "time to the next due date, negative if late"),
        Reading("slack", "log", 0.0, 1.0, math.log(LEAST_SLACK), 5.0, "exact",
                "ln of the time to the next due date over the nominal time of the work up to it"),
        Reading("taper", "um", 0.0, tolerance, 0.0, 5.0, taper_noise,
                "range of the size across the last finished part"),
        Reading("wear_flat", "", 0.0, 0.05, 0.0, 5.0, "hidden", "wear-flat area A"),
        Reading("loading", "", 0.0, 1.0, 0.0, 1.0, "hidden", "loading"),
        Reading("diamond_flat", "mm", 0.0, 0.2, 0.0, 20.0, "hidden", "wear flat of the diamond"),
        Reading("dressed_roughness", "um", 0.0, 1.0, 0.0, 5.0, "hidden", "roughness scale left by the dress"),
        Reading("dressed_density", "1/mm2", 0.0, 10.0, 0.0, 5.0, "hidden", "grain density left by the dress"),
        Reading("growth", "", 1.0, 1.0, -1.0, 10.0, "hidden", "factor on wear-flat growth, coming block"),
        Reading("pressure", "", 1.0, 1.0, -1.0, 10.0, "hidden", "factor on wear-flat pressure, coming block"),
        Reading("fracture", "", 1.0, 1.0, -1.0, 10.0, "hidden", "factor on the fracture force"),
        Reading("wear", "", 1.0, 1.0, -1.0, 10.0, "hidden", "factor on the G-ratio"),
        Reading("convection", "", 1.0, 1.0, -1.0, 10.0, "hidden", "factor on the convection, coming block"),
        Reading("roughness_scale", "", 1.0, 1.0, -1.0, 10.0, "hidden", "factor on the roughness"),
        Reading("wheel_volume", "mm3/mm", 0.0, 300.0, 0.0, 20.0, "hidden",
                "specific volume since the last dress as the wheel feels it: a dress leaves a part of it"),
        PART_RISE,
    ]  # fmt: skip
    assert tuple(reading.name for reading in table) == Readings._fields
    return table


def _one_hot(task: Task) -> Iterable[Reading]:
    """Yield the flags of the kind and the material of a block, if there are several."""
    if len(task.kinds) > 1:
        for when in ("coming", "following"):
            for kind in task.kinds:
                yield _flag(f"{when}_{kind.name}", f"1 if the {when} block is a {kind.name}")
    names = [name for name in task.materials if any(kind.material == name for kind in task.kinds)]
    for name in names if len(names) > 1 else []:
        yield _flag(f"material_{name}", f"1 if the coming block is of {name}")


def _flag(name: str, meaning: str) -> Reading:
    return Reading(name, "", 0.0, 1.0, 0.0, 1.0, "exact", meaning)


def bounds(entries: tuple[Reading, ...]) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return the lowest and highest observation, each shape (entries,)."""
    low = np.array([entry.low for entry in entries], np.float32)
    high = np.array([entry.high for entry in entries], np.float32)
    return low, high


def physical(observation: NDArray[np.float32], entries: tuple[Reading, ...]) -> dict[str, NDArray[np.float64]]:
    """Return observations, shape (..., entries), in physical units, by name."""
    scaled = np.asarray(observation, np.float64)
    return {entry.name: entry.offset + entry.scale * scaled[..., k] for k, entry in enumerate(entries)}

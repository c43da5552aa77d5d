"""The tables of a task page: action, observation, blocks, random draws, reward."""

from collections.abc import Mapping

from grind_env.belief.filter_quantities import CUT
from grind_env.data_table import Column, table_of
from grind_env.envs.actions import ACTIONS, ActionCodec
from grind_env.envs.observations import Reading
from grind_env.envs.tasks import Kind, Task
from grind_env.pages.reward_bounds import MEANINGS, STOCK_SIGMAS, WORST_WEAR, RewardSpan
from grind_env.pages.task_page_data import TaskSheet

LOTS = {"lot_growth": "dulling rate kA", "lot_pressure": "wear-flat pressure pm"}
#: quantities that log-normal factors multiply, by the key of the factor in a task file
EPISODE = {
    "wheel_growth": "dulling rate kA, of every wheel",
    "wheel_roughness": "roughness scale, of every wheel",
    "fracture_force": "fracture force fc, the grade of the wheels",
    "g_ratio": "G-ratio",
    "convection": "convection of the coolant",
}


def action_table(sheet: TaskSheet) -> str:
    """Return a table of the components of the default action: range and meaning."""
    space = sheet.env.action_space
    rows = [
        (str(k), name, f"{low:g}", f"{high:g}", choice)
        for k, ((name, choice), low, high) in enumerate(zip(_components(sheet), space.low, space.high, strict=True))
    ]
    return table_of(("#", "component", "min", "max", "chooses"), rows).markdown()


def _components(sheet: TaskSheet) -> list[tuple[str, str]]:
    codec = sheet.env.codec
    speed = f"{codec.low:g} to {codec.high:g} mm/min, geometric, rounded to whole mm/min"
    if codec.levels.size > 0:
        levels = ", ".join(f"{level:g}" for level in codec.levels)
        speed = f"{levels} mm/min, {codec.levels.size} bins of equal width"
    most = codec.executions
    above = "1 above" if most == 1 else f"above it 1 to {most} in bins of equal width"
    return [("E", speed), ("D", f"0 to {most} dress executions: none up to 1/3, {above}")]


def form_table(task: Task, *, predress: bool) -> str:
    """Return a table of the action space in each of its forms, also with a pre-dress if `predress`."""
    rows = [(f'`action="{form}"`', f"`{ActionCodec(task, form).space}`") for form in ACTIONS]
    if predress:
        rows.append(("`predress=True`", f"`{ActionCodec(task, predress=True).space}`"))
    return table_of(("argument", "action space"), rows).markdown()


def observation_table(readings: Mapping[int, Reading]) -> str:
    """Return a table of the entries by their place; the column `value` converts an observation x into its unit."""
    rows = [
        (
            place,
            f"`{each.name}`",
            f"{each.low:g}",
            f"{each.high:g}",
            _value(each),
            each.unit or "-",
            each.noise,
            each.meaning,
        )
        for place, each in readings.items()
    ]
    return table_of(("#", "name", "min", "max", "value", "unit", "noise, delay", "meaning"), rows).markdown()


def _value(reading: Reading) -> str:
    slope = "x" if reading.scale == 1.0 else f"{reading.scale:g} x"
    return slope if reading.offset == 0.0 else f"{reading.offset:g} + {slope}"


def setup_table(task: Task) -> str:
    """Return a table of the set-up, with the catalogue values that this task changes."""
    setup, dress = task.setup, task.dress
    wheel = ", ".join(f"{name} {value:g}" for name, value in setup.wheel_overrides.items())
    machine = ", ".join(f"{name} {value:g}" for name, value in setup.machine_overrides.items())
    rows = [
        ("wheel", setup.wheel + (f" with {wheel}" if wheel else "") + f", {setup.wheel_speed:g} m/s when new"),
        (
            "dress",
            f"{dress.passes} passes of {dress.depth:g} mm, lead {dress.lead:g} mm/rev, {task.dress_seconds:.1f} s",
        ),
        ("dresser, fluid", f"{setup.dresser}, {setup.fluid}"),
        ("machine", setup.machine + (f" with {machine}" if machine else "")),
        ("part change", f"{setup.load:g} s a part"),
        ("prices", f"{task.rates.hourly:g} $/h, {task.rates.wheel:g} $/mm3 of wheel, {task.rates.dress:g} $ a dress"),
    ]
    if task.wheel_change is not None:
        change = task.wheel_change
        least = task.wheel.minimum_diameter
        rows.append(("wheel change", f"below {least:g} mm: {change.price:g} $ and {change.seconds:g} s"))
    if task.due is not None:
        rows.append(("due dates", f"one after every {task.due.blocks} blocks; lateness costs {task.due.late:g} $/h"))
    return table_of(("set-up", ""), rows).markdown()


def kind_table(sheet: TaskSheet, task: Task) -> str:
    """Return a table of the kinds of block, with the pick if it can be observed."""
    picks = any(reading.name == "pick" for reading in sheet.readings)
    columns = (
        Column("block", "name"),
        Column("material", "material"),
        Column("stock mm", "stock", "g"),
        Column("pick mm", lambda kind: f"{kind.pick:g}" if picks else "-"),
        Column("spark-out", "sparkout"),
        Column("width x length mm", lambda kind: f"{kind.width:g} x {kind.length:g}"),
        Column("Ra limit um", lambda kind: f"{kind.roughness_limit:g}" if kind.roughness_limit > 0.0 else "-"),
        Column("tolerance um", lambda kind: f"{kind.tolerance:g}" if kind.tolerance > 0.0 else "-"),
        Column("rise limit K", lambda kind: task.limits(kind).rise, "g"),
        Column("scrap $", "scrap", "g"),
        Column("", _part_of),
    )
    return table_of(columns, task.kinds).markdown()


def _part_of(kind: Kind) -> str:
    return "whole part" if kind.starts_part and kind.ends_part else "starts a part" if kind.starts_part else "ends it"


def drawn_table(task: Task) -> str:
    """Return the table of random draws at reset; "" for none."""
    spread, start = task.spread, task.start
    rows: list[tuple[str, str, str]] = []
    if task.orders is not None:
        rows.append(("order", "1 block kind", f"equally likely, 1 to {task.orders.most_parts} parts"))
    if spread.stock > 0.0:
        least = ", ".join(f"{value:g}" for value in sorted({kind.least_stock for kind in task.kinds}))
        rows.append(("part", "stock over nominal", f"normal, 1 ± {spread.stock:g}, at least {least}"))
    if spread.gauge > 0.0:
        rows.append(("part", "error of the pre-gauged stock", f"normal, ± {1000.0 * spread.gauge:g} um"))
    lot = "lot (an order)" if task.orders else "lot"
    if spread.lot_probability > 0.0:
        rows.append((lot, "whether a part begins a new one", f"with probability {spread.lot_probability:.3g}"))
    if spread.part_roughness > 0.0:
        rows.append(("part", "roughness scale, of every part", _log_normal(spread.part_roughness)))
    rows += [(lot, text, _log_normal(getattr(spread, name))) for name, text in LOTS.items() if getattr(spread, name)]
    rows += [
        ("episode", text, _log_normal(getattr(spread, name))) for name, text in EPISODE.items() if getattr(spread, name)
    ]
    if spread.coolant_ageing > 0.0:
        low, high = (task.setup.coolant_ageing * (1.0 + sign * spread.coolant_ageing) for sign in (-1.0, 1.0))
        rows.append(("episode", "log convection lost with a part", f"uniform, {low:g} to {high:g}"))
    if spread.diamond_flat > 0.0:
        rows.append(("episode", "wear flat of the diamond", f"uniform, 0 to {spread.diamond_flat:g} mm"))
    if start.executions_left is not None:
        low, high = start.executions_left
        rows.append(("episode", "dress executions left on the wheel", f"uniform, {low:g} to {high:g}"))
    if task.due is not None:
        low, high = task.due.slack
        text = f"uniform, {low:g} to {high:g} (nominal: E {task.due.speed:g} mm/min, no dress)"
        rows.append(("due date", "time to it over the nominal time of the work", text))
    return table_of(("for each", "drawn", "distribution"), rows).markdown() if rows else ""


def _log_normal(sigma: float) -> str:
    return f"log-normal factor, sigma {sigma:g}, cut at {CUT:g} sigma"


def reward_table(costs: Mapping[str, RewardSpan], unit: float) -> str:
    """Return a table of the terms of the reward, with their lowest and highest value in a step; `unit` is in $."""
    rows = [
        (f"`{name}`", MEANINGS[name], f"{-span.most / unit:.2f}", f"{0.0 - span.least / unit:.2f}")
        for name, span in costs.items()
    ]
    return table_of(("term", "minus, over the reference cost", "worst", "best"), rows).markdown()


RANGE_NOTE = (
    f"The ends are bounds with the default arguments and no reset options; they count stock up to {STOCK_SIGMAS:g} "
    f"standard deviations and wear down to {100.0 * WORST_WEAR:g} % of the reference G-ratio."
)

"""A sweep as a table for the terminal, and as plain data for JSON."""

from collections.abc import Callable, Sequence
from dataclasses import asdict
from typing import Any

from grind_env.data_table import Column, Table, table_of
from grind_env.message_text import printable
from grind_env.shop.dress_interval import DressInterval
from grind_env.shop.sweep.study import JUDGED_LOTS, RISK, Sweep, SweepPoint, best_of_each
from grind_env.shop.trials import lots_text


def _where(name: str, form: str) -> Callable[[SweepPoint], str]:
    """Return the function that writes a setting; its text is empty if the program lacks the setting."""
    return lambda point: f"{getattr(point, name):{form}}" if getattr(point, name) else ""


def _limits(point: SweepPoint) -> str:
    share = max(point.of_limits.values())
    return "kept" if point.keeps_limits else f"{point.worst_limit} {100.0 * share:.0f} %"


COLUMNS = {
    "E": Column("E", "E", ".0f", "mm/min", right=True),
    "every": Column("every", _where("every", ""), unit="{counted}s", right=True),
    "lead": Column("lead", _where("lead", ".3f"), unit="mm/rev", right=True),
    "depth": Column("depth", _where("depth", ".4f"), unit="mm", right=True),
    "cost": Column("cost", "cost.value", ".3f", "$", right=True),
    "seconds": Column("time", "seconds", ".1f", "s", right=True),
    "Ra": Column("Ra", "Ra", ".2f", "µm", right=True),
    "power": Column("power", "power", ".2f", "kW", right=True),
    "rise": Column("rise", "rise", ".0f", "K", right=True),
    "highest_rise": Column(
        "highest\nrise",
        lambda point: f"{point.highest_rise:.0f}" if point.highest_rise != point.rise else "",
        unit="K",
        right=True,
    ),
    "size_error": Column("abs.\nsize", "size_error", ".1f", "µm", right=True),
    "scrap": Column("scrap", "scrap", ".1f", "%", right=True, factor=100.0),
    "limits": Column("limits", _limits, right=True),
}

#: columns that are left out of a table of several rows if all rows have the same value
VARIED = ("E", "every", "lead", "depth")


def tables_of(found: Sweep) -> list[Table]:
    """Return the unchanged program, the best point of each dress interval, and the grid of lead and depth."""
    tables = [_table("as it is", [found.own], found.counted)]
    grids = (
        (found.speeds, "every", "the best E of each dress interval", "over E"),
        (found.dresses, "lead", "the best depth of each dress lead", "over depth"),
    )
    for points, name, of_each, over in grids:
        best = best_of_each(points, name)
        if points:
            tables.append(_table(of_each if len(best) > 1 else over, best if len(best) > 1 else points, found.counted))
    return tables


def points_table(found: Sweep) -> Table:
    """Return a table with a row for each point of the sweep, the unchanged program first."""
    return _table("", [found.own, *found.speeds, *found.dresses], found.counted)


def sentences(found: Sweep) -> list[str]:
    """Return the best setting, and how flat the valley is."""
    best, said = found.best, list(found.remarks)
    if found.plant:
        said.append(f"simulated on {printable(found.plant)}, an out-of-model machine")
    if found.calibration is None:
        said.append("not calibrated: the result depends on the machines that were drawn; repeat with another --seed")
    if any(point.every for point in found.speeds):
        point = min((each for each in found.intervals if each.keeps_limits), key=lambda each: each.cost, default=None)
        first, last = found.valley
        if point is not None:
            valley = f"intervals of {first} to {last}" if first != last else "no other"
            said.append(
                f"best interval within the limits: {DressInterval(point.every, found.counted)} with E{point.E:.0f}, "
                f"{point.cost.value:.3f} $ a part; {valley} within 2 %"
            )
    for name, point in found.refused.items():
        cost, share = f"{_settings(point, found)} would cost {point.cost.value:.3f} $", point.of_limits[name]
        if name == RISK:
            allowed, more = (100.0 * (each * found.most_risk - 1.0) for each in (1.0, share))
            said.append(
                f"too risky: {cost}, but on 5 of 100 machines at least {more:.0f} % more than the program as it is; "
                f"{allowed:.0f} % is accepted"
            )
        else:
            said.append(f"the limit of {name} binds: {cost}, but parts reach {100.0 * share:.0f} % of it")
    for name, setting in {"E": f"E{best.E:.0f}", "every": f"a dress every {best.every} {found.counted}s"}.items():
        swept = {getattr(each, name) for each in found.speeds}
        if len(swept) > 1 and getattr(best, name) == max(swept):
            said.append(f"{setting} is the end of the range")
    if not best.keeps_limits:
        said.append("no point of the sweep keeps all limits without too much risk")
    saved = found.own.cost.value - best.cost.value
    said.append(
        f"cheapest: {best.cost.value:.3f} $ a part ({best.cost.low:.3f} to {best.cost.high:.3f}), "
        f"{saved:.3f} $ less than the program as it is; {lots_text(found.lots)}, batches of {found.parts} "
        f"{found.counted}s (--parts); cost and saving are then of {JUDGED_LOTS} new lots"
    )
    return said


def as_data(found: Sweep) -> dict[str, Any]:
    """Return the sweep in JSON types."""
    same = "program", "parts", "lots", "calibration", "most_risk", "counted"
    return {
        **{name: getattr(found, name) for name in same},
        **({"plant": found.plant} if found.plant else {}),
        "own": _data(found.own),
        "speeds": [_data(point) for point in found.speeds],
        "dresses": [_data(point) for point in found.dresses],
        "best": _data(found.best),
        "valley": list(found.valley) if found.speeds else None,
        "remarks": list(found.remarks),
    }


def _data(point: SweepPoint) -> dict[str, Any]:
    return asdict(point) | {"cost": point.cost._asdict(), "keeps_limits": point.keeps_limits}


def _table(title: str, points: Sequence[SweepPoint], counted: str) -> Table:
    columns = []
    for name, column in COLUMNS.items():
        texts = {column.cell(point, 0).text for point in points}
        if texts != {""} and not (name in VARIED and len(points) > 1 and len(texts) == 1):
            columns.append(column._replace(unit=column.unit.format(counted=counted)))
    return table_of(columns, points, title)


def _settings(point: SweepPoint, found: Sweep) -> str:
    """Return E and dress interval of a point as text, with lead and depth if they differ from the program's."""
    own, said = found.own, [f"E{point.E:.0f}"]
    said += [f"a dress {DressInterval(point.every, found.counted)}"] if point.every else []
    said += [f"lead {point.lead:.3f} mm"] if point.lead != own.lead else []
    said += [f"depth {point.depth:.4f} mm"] if point.depth != own.depth else []
    return ", ".join(said)

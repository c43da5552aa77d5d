"""Promises of the shop tools on out-of-model machines, and how far the tools keep them."""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple, TypeAlias

import numpy as np

from agents.plants.study_machines import KEPT_OUT
from agents.plants.trials import Found, PlantsTrial
from grind_env.array_types import Array
from grind_env.plants.plant_names import MODEL

OWN_FAMILY = MODEL.name
Rows: TypeAlias = Sequence[tuple[PlantsTrial, Found]]


class Bound(NamedTuple):
    """Promise that a number is at most, or at least, another number."""

    what: str
    found: float
    asked: float
    at_least: bool = False

    @property
    def kept(self) -> bool:
        return self.found >= self.asked if self.at_least else self.found <= self.asked


def promises(found: Mapping[PlantsTrial, Found]) -> list[tuple[str, Bound]]:
    """Return the promises that the results can judge, each with its question."""
    asked = list[tuple[str, Bound]]()
    for question, judged in JUDGED.items():
        rows = [(cell, numbers) for cell, numbers in found.items() if cell.question == question]
        if not rows:
            continue
        others = [row for row in rows if row[0].machine.family != OWN_FAMILY]
        own = [row for row in rows if row[0].machine.family == OWN_FAMILY]
        asked += [(question, each) for each in judged(others, own) if np.isfinite(each.found)]
    return asked


def column(rows: Rows, name: str) -> Array:
    """Return a number of each cell; NaN for a cell without it."""
    return np.array([numbers.get(name, np.nan) for _, numbers in rows])


def worst_family(rows: Rows, number: Callable[[Rows], float]) -> float:
    """Return the highest value of a number among the families; NaN without rows."""
    families = dict.fromkeys(cell.machine.family for cell, _ in rows)
    found = (number([row for row in rows if row[0].machine.family == family]) for family in families)
    return max(found, default=np.nan)


def _mean(values: Array) -> float:
    return float(values.mean()) if values.size else math.nan


def _median(values: Array) -> float:
    return float(np.median(values)) if values.size else math.nan


def _most(values: Array) -> float:
    return float(np.nanmax(values)) if np.isfinite(values).any() else np.nan


def _calibrate(others: Rows, own: Rows) -> list[Bound]:
    def over(rows: Rows) -> float:
        return _mean(column(rows, "error")) / _mean(column(rows, "regression"))

    return [
        Bound("error over the error of the power law, worst family", worst_family(others, over), 1.0),
        Bound("error over the error of the power law, machine is the model", over(own) if own else np.nan, 0.5),
    ]


def _optimise(others: Rows, own: Rows) -> list[Bound]:
    cost, original = column(others, "calibrated_cost"), column(others, "original")
    low, high = column(others, "calibrated_low"), column(others, "calibrated_high")
    scrap, scrap_before = column(others, "calibrated_scrap"), column(others, "original_scrap")
    plain, known = column(others, "uncalibrated_cost"), np.isfinite(cost)
    gain, best = (original - cost)[known], (original - column(others, "known_cost"))[known]
    own_gain = column(own, "original") - column(own, "calibrated_cost")
    own_best = column(own, "original") - column(own, "known_cost")
    return [
        Bound(
            "calibrated: share of costs within the promised interval",
            _mean(((cost >= low) & (cost <= high))[known]),
            0.8,
            True,
        ),
        Bound("calibrated: width of the interval over the cost, median", _median(((high - low) / cost)[known]), 0.25),
        Bound(
            "calibrated: scrap above 1 % and above the original program, worst, %",
            100.0 * _most(scrap - np.maximum(scrap_before, 0.01)),
            0.0,
        ),
        Bound("calibrated: cost over the original program, worst", _most(cost / original), 1.05),
        Bound("calibrated: cost over the original program, mean", _mean((cost / original)[known]), 1.0),
        # where the program at hand scraps all parts, one machine outweighs all others
        Bound("calibrated: saving over that with the machine as model, sums", _mean(gain) / _mean(best), 0.5, True),
        Bound("calibrated: the same ratio, mean", _mean(gain[best > 0.0] / best[best > 0.0]), 0.5, True),
        Bound("calibrated, machine is the model: the same ratio, sums", _mean(own_gain) / _mean(own_best), 0.9, True),
        Bound("uncalibrated: scrap, worst, %", 100.0 * _most(column(others, "uncalibrated_scrap")), 2.0),
        Bound(
            "uncalibrated: scrap above 2 % and above the original program, worst, %",
            100.0 * _most(column(others, "uncalibrated_scrap") - np.maximum(scrap_before, 0.02)),
            0.0,
        ),
        Bound("uncalibrated: cost over the original program, worst", _most(plain / original), 1.5),
        Bound("uncalibrated: cost over the original program, mean", _mean(plain / original), 1.0),
        Bound("uncalibrated: share of machines with a cost 5 % higher", _mean(plain > 1.05 * original), 0.0),
    ]


def _advise(others: Rows, own: Rows) -> list[Bound]:
    cost, plan = column(others, "adviser_cost"), column(others, "plan_cost")

    def over(rows: Rows) -> float:
        return _mean(column(rows, "adviser_cost")) / _mean(column(rows, "floor_cost"))

    def given_away(what: str) -> float:
        program, trusting, adviser = (column(own, f"{who}_{what}") for who in ("program", "trusting", "adviser"))
        return 100.0 * _most((adviser - trusting) / (program - trusting))

    return [
        Bound("cost over an adviser without a model, worst family", worst_family(others, over), 1.05),
        Bound("cost over the best of 15 fixed plans, mean", _mean(cost / plan), 1.15),
        Bound("cost over the best of 15 fixed plans, worst machine", _most(cost / plan), 1.5),
        Bound("scrap, worst machine, %", 100.0 * _most(column(others, "adviser_scrap")), 3.0),
        Bound("blocks above the power limit after a reading above it", _most(column(others, "adviser_in_a_row")), 0.0),
        Bound(
            "parts beyond size or Ra after a reading beyond it, worst machine",
            _most(column(others, "adviser_parts_in_a_row")),
            0.0,
        ),
        Bound("saving lost by the guard on the model, %", given_away("cost"), 10.0),
        Bound("saving lost by the guard on the model from part 15 on, %", given_away("late"), 3.0),
    ]


def _robust(others: Rows, own: Rows) -> list[Bound]:
    over = column(others, "robust_cost") / column(others, "plan_cost")
    return [
        Bound("cost over the best of 15 fixed plans, mean", _mean(over), 1.15),
        Bound("cost over the best of 15 fixed plans, worst machine", _most(over), 1.5),
        Bound("scrap, worst machine, %", 100.0 * _most(column(others, "robust_scrap")), 3.0),
    ]


JUDGED = {"calibrate": _calibrate, "optimise": _optimise, "advise": _advise, "robust": _robust}
COLUMNS = {
    "calibrate": ("error", "catalogue", "regression"),
    "optimise": ("original", "uncalibrated_cost", "calibrated_cost", "known_cost", "calibrated_scrap", "refused"),
    "advise": ("program_cost", "plan_cost", "floor_cost", "trusting_cost", "adviser_cost", "adviser_scrap"),
    "robust": ("plan_cost", "robust_cost", "robust_scrap"),
}


def family_rows(found: Mapping[PlantsTrial, Found], question: str) -> list[tuple[str, ...]]:
    """Return a line per family, with means over its machines."""
    rows = [(cell, numbers) for cell, numbers in found.items() if cell.question == question]
    lines = []
    for family in dict.fromkeys(cell.machine.family for cell, _ in rows):
        mine = [row for row in rows if row[0].machine.family == family]
        values = [_mean(column(mine, name)) for name in COLUMNS[question]]
        # a robust agent is trained, and a search without a calibration judged, on machines of all families
        out = family in KEPT_OUT and question in ("calibrate", "advise")
        name = f"{family} (held out)" if out else family
        lines.append((name, f"{len(mine)}", *(f"{value:.3g}" for value in values)))
    return lines

"""Bounds on each reward term of a step, computed from a task.

The bounds are computed, not observed: from the slowest and the fastest table, the least and the most stock, no dress
and as many as the task allows, no stall of the spindle and one, a good part and scrap. Two bounds need an assumption:
the normal distribution of stock is unbounded (`STOCK_SIGMAS`), and no bound on the wear of a wheel is known
(`WORST_WEAR`).
"""

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

from grind_env.control.cycle_formulas import motion_time
from grind_env.envs.cost import reward_terms
from grind_env.envs.tasks import Kind, Task
from grind_env.process.cost import MOST_HANDOVER_DRESSES

STOCK_SIGMAS = 6.0  #: number of standard deviations of stock within the bounds; one part in a billion has more
WORST_WEAR = 0.01  #: least G-ratio within the bounds, as a share of the reference G-ratio of wheel and material

MEANINGS = {
    "time": "hourly rate x time of strokes, dresses, loading, wheel change and stall",
    "wheel": "price x wheel volume, worn and dressed off",
    "dress": "price of the dresser x executions",
    "scrap": "price of scrap x probability that the finished part is scrap",
    "handover": "with the last block: executions that would make the wheel sharp",
    "late": "hourly price x lateness at a due date",
    "change": "price of a new wheel",
}


class RewardSpan(NamedTuple):
    """Least and greatest value of a quantity."""

    least: float
    most: float


def stock_span(task: Task, kind: Kind) -> RewardSpan:
    """Return the stock of a block, mm, in whole um as it is drawn."""
    spread = STOCK_SIGMAS * task.spread.stock if kind.starts_part else 0.0
    least = max(kind.least_stock, 1.0 - spread) if spread > 0.0 else 1.0
    ends = (math.floor(1000.0 * kind.stock * share + 0.5) / 1000.0 for share in (least, 1.0 + spread))
    return RewardSpan(*ends)


def stroke_times(task: Task) -> dict[str, RewardSpan]:
    """Return the time of a G82 block of each kind, s, without its dresses and with loading."""
    low, high = task.action.speed_ends
    spans = {}
    for kind in task.kinds:
        stock = stock_span(task, kind)
        # a faster table than this spends more time on acceleration than it saves
        optimum = 60.0 * math.sqrt(task.machine.acceleration * task.stroke_length(kind))
        fastest = min(max(low, optimum), high)
        thick = replace(kind, stock=stock.most)
        spans[kind.name] = RewardSpan(
            task.nominal_seconds(replace(kind, stock=stock.least), fastest),
            max(task.nominal_seconds(thick, low), task.nominal_seconds(thick, high)),
        )
    return spans


def infeed_times(task: Task) -> dict[str, RewardSpan]:
    """Return the time of a G81 block of each kind, s, without its dresses: loading, infeed, strokes waited for."""
    machine, executions = task.machine, task.action.executions
    feed = task.infeed / 60.0
    spans = {}
    for kind in task.kinds:
        stock, load = stock_span(task, kind), task.setup.load if kind.starts_part else 0.0
        stroke = _stroke(task, kind)
        # at least half of the stroke in which the infeed ends, then one stroke at full depth and the spark-out
        end = 1.5 + kind.sparkout
        # the control waits for a reversal point after every infeed
        waiting = (end + 1.5 + executions) * stroke.most + (executions + 1.0) * feed / machine.acceleration
        least = load + stock.least / feed + end * stroke.least
        spans[kind.name] = RewardSpan(least, load + stock.most / feed + waiting)
    return spans


def cost_spans(task: Task, times: Mapping[str, RewardSpan]) -> dict[str, RewardSpan]:
    """Return the cost of a step, $, by term of the reward; `times` are those of blocks without dresses, s, by kind."""
    rates, most = task.rates, float(task.action.executions)
    per_second = rates.hourly / 3600.0
    dressed = 0.5 * task.execution_depth * math.pi * task.wheel.diameter * task.wheel.width
    execution = per_second * task.dress_seconds + rates.wheel * dressed + rates.dress
    change = task.wheel_change
    stops = most * task.dress_seconds + task.machine.stall_time
    longest = {name: span.most + stops for name, span in times.items()}
    spans = {
        "time": RewardSpan(
            per_second * min(span.least for span in times.values()),
            per_second * (max(longest.values()) + (change.seconds if change else 0.0)),
        ),
        "wheel": RewardSpan(0.0, rates.wheel * (most * dressed + max(_worn(task, kind) for kind in task.kinds))),
        "dress": RewardSpan(0.0, rates.dress * most),
        "scrap": RewardSpan(0.0, max(kind.scrap for kind in task.kinds)),
        "handover": RewardSpan(0.0, MOST_HANDOVER_DRESSES * execution),
    }
    if task.due is not None:
        due = task.due
        behind = max(longest[kind.name] - due.slack[0] * task.nominal_seconds(kind, due.speed) for kind in task.kinds)
        spans["late"] = RewardSpan(0.0, due.late / 3600.0 * task.blocks * behind)
    if change is not None:
        spans["change"] = RewardSpan(0.0, change.price)
    return {name: spans[name] for name in reward_terms(task)}


def reward_span(task: Task, costs: Mapping[str, RewardSpan]) -> RewardSpan:
    """Return the lowest and highest reward of a step, rounded outwards to hundredths."""
    worst = -sum(span.most for span in costs.values()) / task.reference_cost
    best = -sum(span.least for span in costs.values()) / task.reference_cost
    return RewardSpan(math.floor(100.0 * worst) / 100.0, math.ceil(100.0 * best) / 100.0)


def _stroke(task: Task, kind: Kind) -> RewardSpan:
    """Return the time of a stroke with its reversal dwell, s, at the fastest and at the slowest table."""
    machine, distance = task.machine, task.stroke_length(kind)
    slowest, fastest = (motion_time(distance, speed / 60.0, machine.acceleration) for speed in task.action.speed_ends)
    return RewardSpan(fastest + machine.reversal_dwell, slowest + machine.reversal_dwell)


def _worn(task: Task, kind: Kind) -> float:
    """Return the most wheel volume that a block wears off, mm3."""
    p = task.parameters(kind)
    return stock_span(task, kind).most * kind.width * kind.length / (WORST_WEAR * p.Gref)

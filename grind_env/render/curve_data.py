"""Curves of a record for any drawing library: quantities stroke by stroke, or many strokes as bands.

The axis counts strokes, not time: each stroke is one step, and a dress has no width, however long it takes.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from grind_env.array_types import Array
from grind_env.control.cycle_formulas import DEPTH_TOLERANCE
from grind_env.machine.job import Job
from grind_env.machine.record import GrindingRecord
from grind_env.process.cost import NO_LIMIT, Limits

#: mm; below this depth of cut the burn ratio means nothing, because the specific energy is that of rubbing
SPARKING = 0.001

MOST_STROKES = 600  #: most strokes that are drawn one by one; more strokes are drawn in groups

MOST_GROUPS = 300  #: most groups in a picture of bands

MANY_PARTS = 20  #: number of parts from which on groups are made of parts, not of strokes

BLUE, ORANGE, GREEN, RED, GREY = "#1f5f8b", "#d9822b", "#2e8b57", "#b5322b", "#8a8a8a"
INK, GRID, PAPER = "#1d2329", "#e3e3e3", "#ffffff"
SHADE = "#efe7da"  #: background of strokes that spark out


class Limit(NamedTuple):
    """A line across a panel; `value` is in the unit of the panel."""

    value: float
    text: str


class Span(NamedTuple):
    """Successive strokes of one execution of a block."""

    first: int  #: index of the first stroke, from 0
    after: int  #: index after the last stroke
    label: str  #: N word or line of the block: `N50`, `line 7`


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Curve:
    """A quantity of a run."""

    title: str  #: name of the quantity
    unit: str  #: unit of the values
    color: str  #: colour of the quantity in all pictures
    low: Array  #: lowest value in each group, in `unit`; for single strokes `low`, `mean` and `high` are equal
    mean: Array  #: mean of each group, in `unit`
    high: Array  #: highest value in each group, in `unit`
    limits: tuple[Limit, ...] = ()  #: lines to be drawn with the curve
    downwards: bool = False  #: whether larger values are drawn lower, as for a depth

    @property
    def span(self) -> tuple[float, float]:
        """Lowest and highest value of the axis, which always includes zero and the limits."""
        values = [0.0, *(limit.value for limit in self.limits)]
        for side in (self.low, self.high):
            if np.isfinite(side).any():
                values += [float(np.nanmin(side)), float(np.nanmax(side))]
        low, high = min(values), max(values)
        room = 0.15 * (high - low) or 1.0
        return low - room if low < 0.0 else low, high + room


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Picture:
    """All curves of a run over one axis."""

    axis: str  #: what the axis counts: `stroke` or `part`
    at: Array  #: middle of each group on the axis, in numbers of strokes or parts
    edges: Array  #: begin of each group and end of the last one, in numbers of strokes or parts, for step curves
    banded: bool  #: whether a group is more than one stroke or part, so that a curve is a band
    curves: tuple[Curve, ...]  #: curves from top to bottom
    breaks: tuple[int, ...] = ()  #: places before which curves are interrupted, by dresses and new parts
    #: place on the axis and duration, s, of each dress, if strokes are drawn one by one
    dresses: tuple[tuple[float, float], ...] = ()
    spans: tuple[Span, ...] = ()  #: the blocks, if strokes are drawn one by one
    parts: tuple[tuple[int, int], ...] = ()  #: first stroke and number of each part, if strokes are drawn one by one
    spark_out: Array | None = None  #: whether each stroke sparks out, if strokes are drawn one by one


def picture(record: GrindingRecord) -> Picture:
    """Return the curves of a record."""
    strokes, parts = record.strokes, record.parts
    by_part = strokes.size > MOST_STROKES and parts.size >= MANY_PARTS
    values = _of_parts(record) if by_part else _of_strokes(record)
    count = parts.size if by_part else strokes.size
    most = MOST_GROUPS if by_part or count > MOST_STROKES else count
    size = math.ceil(count / most)
    starts = np.arange(0, count, size)
    edges = np.append(starts, count) + 0.5
    shown = Picture(
        axis="part" if by_part else "stroke",
        at=0.5 * (edges[:-1] + edges[1:]),
        edges=edges,
        banded=size > 1,
        curves=tuple(_grouped(curve, starts) for curve in values),
    )
    if by_part or shown.banded:
        return shown
    changes = np.flatnonzero(np.diff(strokes["part"])) + 1
    return replace(
        shown,
        breaks=tuple(np.union1d(record.dresses["after"], changes).astype(int).tolist()),
        dresses=tuple((float(dress["after"]) + 0.5, float(dress["seconds"])) for dress in record.dresses),
        spans=tuple(spans(record)),
        parts=tuple((int(np.argmax(strokes["part"] == part)), int(part)) for part in parts["part"]),
        spark_out=sparks_out(record),
    )


def spans(record: GrindingRecord) -> list[Span]:
    """Return the executions of blocks in the order in which they were run."""
    rows = record.executions
    ends = (rows["first"] + rows["strokes"]).tolist()
    return [
        Span(first, after, block_name(record, line))
        for first, after, line in zip(rows["first"].tolist(), ends, rows["line"].tolist(), strict=True)
    ]


def block_name(record: GrindingRecord, line: int) -> str:
    """Return the name of the block in a line, for pictures and tables."""
    block = record.blocks.get(line, line)
    return f"line {line}" if block == line else f"N{block}"


def sparks_out(record: GrindingRecord) -> Array:
    """Return whether each stroke sparks out, shape (strokes,): grinds at a depth that was ground before.

    In a cycle that plunges, these are the last L of the traverses at full depth. In a cycle that the program feeds,
    these are the strokes before which there was no infeed.
    """
    strokes = record.strokes
    found = np.zeros(strokes.size, dtype=bool)
    for span in spans(record):
        Z = strokes["Z"][span.first : span.after]
        plan = record.cycles.get(int(strokes["line"][span.first]))
        if plan is not None and plan.plunges:
            at_depth = int((Z[-1] - DEPTH_TOLERANCE <= Z).sum())
            found[span.after - at_depth * plan.spark_out // (1 + plan.spark_out) : span.after] = True
        elif not strokes["groove"][span.first]:
            found[span.first + 1 : span.after] = np.abs(np.diff(Z)) <= DEPTH_TOLERANCE
    return found


def depth_lag(record: GrindingRecord) -> Array:
    """Return the lag of the mean ground depth behind the programmed depth after each stroke, um, shape (strokes,).

    At the end of a finished part the lag is the mean size error.
    """
    # a program may come back to the part at a station
    order = np.argsort(record.strokes["part"], kind="stable")
    strokes = record.strokes[order]
    ground = [record.job.of_part(number).part for number in record.parts["part"].tolist()]
    areas = np.array([part.width * part.length for part in ground])
    removed = strokes["ae"] * strokes["b"] * strokes["Lw"] / areas[strokes["part"] - 1]
    total = np.cumsum(removed)
    firsts = np.searchsorted(strokes["part"], strokes["part"])
    before = np.where(firsts > 0, total[firsts - 1], 0.0)
    deepest = np.empty(strokes.size)
    for first in np.unique(firsts):
        of_part = slice(first, first + int((firsts == first).sum()))
        deepest[of_part] = np.maximum.accumulate(strokes["Z"][of_part])
    found = np.empty(strokes.size)
    found[order] = 1000.0 * (deepest - (total - before))
    return found


def _of_strokes(record: GrindingRecord) -> list[Curve]:
    strokes = record.strokes
    burn = np.where(strokes["ae"] >= SPARKING, strokes["burn_ratio"], np.nan)
    curves = [
        replace(_curve("programmed depth", "µm", BLUE, 1000.0 * strokes["Z"]), downwards=True),
        _curve("depth of cut", "µm", BLUE, 1000.0 * strokes["ae"]),
        *_loads(strokes["power"], strokes["T"], burn, strokes["A"], strokes["Ra"], record.job),
    ]
    if not strokes["groove"].any():
        curves.append(_size("ground behind the program, mean", depth_lag(record), record.job))
    return curves


def _of_parts(record: GrindingRecord) -> list[Curve]:
    strokes, parts = record.strokes[np.argsort(record.strokes["part"], kind="stable")], record.parts
    firsts = np.searchsorted(strokes["part"], parts["part"])
    lasts = np.append(firsts[1:], strokes.size) - 1
    loads = _loads(
        parts["peak_power"],
        np.maximum.reduceat(strokes["T"], firsts),
        np.maximum.reduceat(np.where(strokes["ae"] >= SPARKING, strokes["burn_ratio"], 0.0), firsts),
        strokes["A"][lasts],
        parts["Ra"],
        record.job,
        "highest ",
    )
    size = _size("largest size error", parts["worst_error"], record.job)
    return [*loads, size, _curve("wheel diameter lost", "mm", GREY, strokes["ds"][0] - strokes["ds"][lasts])]


def _loads(
    power: Array, rise: Array, burn: Array, flats: Array, roughness: Array, job: Job, which: str = ""
) -> list[Curve]:
    limits = _common_limits(job)

    def limited(name: str, unit: str, form: str, scale: float = 1.0) -> tuple[Limit, ...]:
        value = getattr(limits, name)
        return (Limit(scale * value, f"limit {scale * value:{form}} {unit}"),) if value > NO_LIMIT else ()

    return [
        _curve(f"{which}power above idle", "kW", ORANGE, 0.001 * power, limited("power", "kW", ".2f", 0.001)),
        _curve(f"{which}temperature rise", "K", RED, rise, limited("rise", "K", ".0f")),
        _curve(f"{which}burn ratio", "-", GREY, burn, (Limit(1.0, "burn threshold"),)),
        _curve("wear-flat area", "%", GREEN, 100.0 * flats),
        _curve("roughness Ra", "µm", BLUE, roughness, limited("roughness", "µm", "g")),
    ]


def _common_limits(job: Job) -> Limits:
    """Return the limits that all parts share; a limit that differs between parts becomes `NO_LIMIT`."""
    every = {job.limits, *(job.of_part(number).limits for number in range(1, len(job.part_stations or job.parts) + 1))}
    return Limits(*(values[0] if len(set(values)) == 1 else NO_LIMIT for values in zip(*every, strict=True)))


def _size(title: str, values: Array, job: Job) -> Curve:
    size = _common_limits(job).size
    limits = (Limit(size, f"limit {size:g} µm"), Limit(-size, f"limit -{size:g} µm")) if size > NO_LIMIT else ()
    return _curve(title, "µm", GREEN, values, limits)


def _curve(title: str, unit: str, color: str, values: Array, limits: tuple[Limit, ...] = ()) -> Curve:
    return Curve(title=title, unit=unit, color=color, low=values, mean=values, high=values, limits=limits)


def _grouped(curve: Curve, starts: Array) -> Curve:
    """Return a curve with low, mean and high of groups of successive values; `starts` are their first indices."""
    values = curve.mean
    if len(starts) == len(values):
        return curve
    known = np.isfinite(values)
    counts = np.maximum(np.add.reduceat(known.astype(float), starts), 1.0)
    low = np.minimum.reduceat(np.where(known, values, np.inf), starts)
    high = np.maximum.reduceat(np.where(known, values, -np.inf), starts)
    mean = np.add.reduceat(np.where(known, values, 0.0), starts) / counts
    none = ~np.isfinite(low)
    return replace(
        curve, low=np.where(none, np.nan, low), mean=np.where(none, np.nan, mean), high=np.where(none, np.nan, high)
    )


def labelled_every(count: int, most: int) -> int:
    """Return k, 1, 2 or 5 times a power of ten, so that every k-th of `count` labels is at most `most` labels."""
    least, decade = max(math.ceil(count / most), 1), 1
    while 5 * decade < least:
        decade *= 10
    return next(step * decade for step in (1, 2, 5) if step * decade >= least)


def joined_runs(values: Sequence[bool] | Array) -> list[tuple[int, int]]:
    """Return runs of true values, shape (N,): first index, and the index after the last."""
    padded = np.concatenate([[False], np.asarray(values, dtype=bool), [False]])
    changes = np.flatnonzero(np.diff(padded.astype(int)))
    return list(zip(changes[::2].tolist(), changes[1::2].tolist(), strict=True))

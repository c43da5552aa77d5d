"""The time of a dress program with other passes, feed or infeed.

The result equals the time that the control needs for the program with these words:

- The feed of the passes stands in one F: every feed move that runs at it runs at the other one.
- The infeed before each pass changes in proportion, in the move after which the wheel is at the diamond.
- What is done from one pass to the next is left out or repeated as often as there are fewer or more passes; if it does
  not come back by itself, it goes the other way each time, and so does the only pass of a program.
- The moves after the last pass go to the coordinates to which they went, along the axes that they move.

Arcs and dwells take the time that they take. The way back is the control's (22-11).
"""

from itertools import pairwise
from typing import Any, TypeAlias

import numpy as np

from grind_env.arrays import Table
from grind_env.control import Arc, Control, Dwell, Line, Motion, Rapid, Source
from grind_env.control.dressing import REMEMBERED
from grind_env.kernel import entry
from grind_env.machine.axes import cross_axis, plunge_axis
from grind_env.machine.dress.program import STEP, DressRun
from grind_env.machine.loops.rules import motion_time

Legs: TypeAlias = tuple[list[Table], list[Table]]
"""Points of N executions from the first begin to the last end, mm, each of shape (N, 3), and speeds between them, mm/s,
each of shape (N,); 0 along an arc."""


def dress_seconds(run: DressRun, control: Control, passes: Table, feed: Table, depth: Table) -> Table:
    """Time of an execution with other numbers than the program's own, s; exactly its own with its own.

    Passes, their feed in mm/s and their mean infeed in mm have shape (N,), as the result has.
    """
    plan = run.plan
    own = _seconds(run, control, plan.passes, np.array([plan.feed]), np.array([plan.depth]))
    seconds = np.empty(len(passes))
    for count in np.unique(passes).tolist():
        rows = passes == count
        seconds[rows] = plan.seconds + (_seconds(run, control, int(count), feed[rows], depth[rows]) - own)
    return seconds


def _seconds(run: DressRun, control: Control, passes: int, feed: Table, depth: Table) -> Table:
    out = _way_out(run, control, passes, feed, depth)
    back = _way_back(run, control, out, feed)
    seconds = np.zeros(len(feed))
    for points, rates in (out, back):
        for (begin, end), rate in zip(pairwise(points), rates, strict=True):
            add_times(np.sqrt(((end - begin) ** 2).sum(axis=1)), rate, control.acceleration, seconds)
    return seconds


@entry
def add_times(ways: Any, rates: Any, acceleration: float, seconds: Any) -> None:
    """Add the times of motions from rest to rest, s; ways in mm, rates in mm/s, the latter 0 where no time counts."""
    for k in range(ways.size):
        if ways[k] > 0.0 and rates[k] > 0.0:
            seconds[k] += motion_time(ways[k], rates[k], acceleration)


def _legs(run: DressRun) -> tuple[list[Motion], list[int]]:
    moves = [
        k
        for k, motion in enumerate(run.motions)
        if motion.source is not Source.RETRACE and not isinstance(motion, Dwell)
    ]
    return [run.motions[k] for k in moves], [moves.index(k) for k in run.strokes]


def _way_out(run: DressRun, control: Control, passes: int, feed: Table, depth: Table) -> Legs:
    legs, strokes = _legs(run)
    plunge, cross = plunge_axis(run.axis), cross_axis(run.axis)
    infeeds = [k for k, leg in enumerate(legs) if abs(leg.end[plunge] - leg.start[plunge]) >= STEP]
    first = max([k for k in infeeds if k < strokes[0]], default=strokes[0])
    steps = [range(begin, end + 1) for begin, end in zip([first, *(k + 1 for k in strokes)], strokes, strict=False)]
    points, rates = [np.tile(np.array(legs[0].start), (len(feed), 1))], list[Table]()

    def move(leg: Motion, end: Table) -> None:
        points.append(end)
        rates.append(_rate(leg, run, control, feed))

    def ways(step: range) -> Table:
        return np.array([np.subtract(legs[k].end, legs[k].start) for k in step])

    for leg in legs[:first]:
        move(leg, points[-1] + np.subtract(leg.end, leg.start))
    for number in range(passes):
        step = steps[min(number, len(steps) - 1)]
        way = ways(step)
        if abs(way[:, cross].sum()) >= STEP:
            way[:, cross] *= (-1.0) ** max(number + 1 - len(steps), 0)
        infeed = max([k for k in infeeds if k in step], default=None)
        deeper = way[:, plunge].sum() * (depth / run.plan.depth - 1.0)
        for k, each in zip(step, way, strict=True):
            end = points[-1] + each
            if k == infeed:
                end[:, plunge] += deeper
            move(legs[k], end)
    for leg in legs[strokes[-1] + 1 :]:
        moved = np.not_equal(leg.end, leg.start)
        move(leg, np.where(moved, leg.end, points[-1]))
    return points, rates


def _way_back(run: DressRun, control: Control, out: Legs, feed: Table) -> Legs:
    (legs, _), (gone, rates) = _legs(run), out
    retrace = [motion for motion in run.motions if motion.source is Source.RETRACE]
    linked = not (len(retrace) <= min(len(legs), REMEMBERED) and legs[len(retrace) - 1].end == legs[-1].end)
    remembered = len(retrace) - linked
    most = REMEMBERED if remembered == len(legs) else remembered
    arcs = [k for k, rate in enumerate(rates) if not rate.any()]
    remembered = min([most, len(rates), *arcs])
    link = _rate(retrace[0] if linked else legs[-1], run, control, feed)
    return [gone[-1], *gone[remembered::-1]], [link, *reversed(rates[:remembered])]


def _rate(leg: Motion, run: DressRun, control: Control, feed: Table) -> Table:
    if isinstance(leg, Rapid):
        return np.full(len(feed), control.rapid_feed / 60.0)
    if isinstance(leg, Arc):
        return np.zeros(len(feed))
    assert isinstance(leg, Line)
    own = leg.feed / 60.0
    return feed if own == run.plan.feed else np.full(len(feed), own)

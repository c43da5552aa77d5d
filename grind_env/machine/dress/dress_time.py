"""The time of a dress program with other passes, feed or infeed.

The result equals the time that the control needs for the program with these words:

- One F word gives the feed of the passes: every feed move with this feed gets the new feed.
- The infeed before each pass changes in proportion, in the move after which the wheel is at the diamond.
- The step from one pass to the next is left out or repeated for fewer or more passes. If a step does not come back to
  its start, its direction alternates. The only pass of a program alternates, too.
- The moves after the last pass end at the same coordinates, along the axes that they move.

The times of arcs and dwells do not change. The way back is that of the control (22-11).
"""

from itertools import pairwise
from typing import Any, TypeAlias

import numpy as np

from grind_env.array_types import Table
from grind_env.control import Arc, Control, Dwell, Line, Motion, Rapid, Source
from grind_env.control.dress_retrace import REMEMBERED
from grind_env.kernel import entry
from grind_env.machine.axis_roles import cross_axis, plunge_axis
from grind_env.machine.dress.dress_run import STEP, DressRun
from grind_env.machine.loops.compiled_motion import motion_time

#: points of N executions from start to end, mm, each of shape (N, 3), and speeds between them, mm/s, each of shape
#: (N,); 0 along an arc
Legs: TypeAlias = tuple[list[Table], list[Table]]


def dress_seconds(run: DressRun, control: Control, passes: Table, feed: Table, depth: Table) -> Table:
    """Return the times of executions with other numbers, s; exactly the program's time with its own numbers.

    Number of passes, their feed, mm/s, their mean infeed, mm, and the result have shape (N,).
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
    """Add the times of motions from rest to rest, s; ways in mm, rates in mm/s; a rate of 0 adds no time."""
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

    for leg in legs[:first]:
        move(leg, points[-1] + np.subtract(leg.end, leg.start))
    for number in range(passes):
        step = steps[min(number, len(steps) - 1)]
        way = np.array([np.subtract(legs[k].end, legs[k].start) for k in step])
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

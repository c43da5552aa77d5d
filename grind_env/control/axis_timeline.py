"""Times and positions of the axes: program motions and picks, with reciprocation beside them.

The other axes are moved by at most one program motion, or by the picks of one cycle, one after another. Strokes
follow each other by themselves. Positions are computed only for the moments that events show.
"""

import itertools
import math
from collections import deque
from collections.abc import Generator, Iterator
from dataclasses import dataclass
from typing import Any

from grind_env.control import events
from grind_env.control.control_settings import Control
from grind_env.control.cycle_formulas import INSTANT, motion_time, pick_begin
from grind_env.control.errors import ControlError, Place
from grind_env.control.execution_limits import BlockBudget
from grind_env.control.motion_profile import ramp_time, travelled
from grind_env.control.path_geometry import Circular, Path, Straight
from grind_env.control.reciprocation import Reciprocation, Underway


@dataclass(frozen=True, slots=True)
class Moving:
    """A motion along a path from rest to rest; speed is mm/s."""

    path: Path
    begin: float
    finish: float
    speed: float
    acceleration: float

    def at(self, time: float) -> events.Position:
        length = self.path.length
        if time >= self.finish or length == 0.0:
            return self.path.end
        return self.path.point(travelled(time - self.begin, length, self.speed, self.acceleration) / length)


class Timeline:
    """Positions of the axes over time."""

    def __init__(self, control: Control, budget: BlockBudget) -> None:
        self.control, self.budget = control, budget
        self.time = 0.0  # time up to which the program is executed, s
        self.position = control.start  # position of the axes or, beside reciprocation, their target
        self.reciprocation: Reciprocation | None = None  # None while no axis reciprocates, and during a dress
        self.table_held = False  # whether the table waits at a reversal for an operator's dress, until all axes stand
        self.dress_postponed = False  # whether an operator's dress waits for the end of a program motion
        self.inch = False  # units in force, for output
        self.infeed_shift = 0.0  # shift of the plunge coordinates by the dresses of the cycle, mm
        self.share, self.dwell = 1.0, control.reversal_dwell  # share of E that the table reaches; rest at a reversal, s
        # axes that cycles have moved along strokes or crossovers; their end depends on the words of these cycles
        self.led_by_cycles: set[int] = set()
        self._motion: Moving | None = None
        self._picks: deque[Moving] = deque()
        self._requests = deque(control.operator_dress_at)

    def rate(self, feed: float | None) -> float:
        """Return the feed of a motion, mm/min, with the operator's override and up to the maximum feed (12-60)."""
        control = self.control
        return control.rapid_feed if feed is None else min(feed * control.panel.override, control.maximum_feed)

    def table_rate(self, table: Reciprocation) -> float:
        return self.rate(table.feed) * self.share

    @property
    def requested(self) -> bool:
        return self.control.panel.dress_requested or bool(self._requests)

    def wait(self, time: float) -> Iterator[events.Event]:
        """Hold before a motion that would begin at `time`, as long as the operator holds the axes (PD-16)."""
        cause = self.control.panel.holding
        if cause is not None:
            yield events.Hold(time, cause)
        if self.control.panel.holding is not None:
            raise ControlError(
                "hold", f"the axes are on hold by {cause}; call resume() or override() before taking another event"
            )

    def duration(self, path: Path, feed: float | None) -> float:
        return motion_time(path.length, self.rate(feed) / 60.0, self.control.acceleration)

    def braked(self, path: Path, feed: float | None, elapsed: float) -> float:
        """Return the fraction of a path at which the axes stop if they brake `elapsed` s after its begin."""
        length, speed, acceleration = path.length, self.rate(feed) / 60.0, self.control.acceleration
        done = travelled(elapsed, length, speed, acceleration)
        pace = min(speed, acceleration * elapsed)
        return min((done + 0.5 * pace * pace / acceleration) / length, 1.0)

    def move(
        self,
        place: Place,
        path: Path,
        feed: float | None,
        source: events.Source,
        *,
        dwell: float = 0.0,
        groove: tuple[int, int] | None = None,
    ) -> Iterator[events.Event]:
        """Move along a path at `feed`, mm/min or None for a rapid, or dwell, s; the table reciprocates meanwhile.

        `groove` is the axis and the number of the groove if the motion is the infeed of a groove.
        """
        yield from self.wait(self.time)
        rate = self.rate(feed)
        seconds = self.duration(path, feed) if path.length > 0.0 else dwell
        if (table := self.reciprocation) is not None:
            speed, way = self.table_rate(table) / 60.0, abs(table.primary - table.secondary)
            stroke = motion_time(way, speed, self.control.acceleration) + self.dwell
            self.budget.foresee(seconds // stroke - 1, place)
        begin, finish = self.time, self.time + seconds
        start = self._shown(begin)
        self._motion = Moving(path, begin, finish, rate / 60.0, self.control.acceleration)
        yield from self._reciprocate(finish)
        end = self._shown(finish)
        self.time, self.position, self._motion = finish, path.end, None
        if self.reciprocation is not None:
            self._settle_axis(self.reciprocation)
        frame: dict[str, Any] = {
            "start": start,
            "end": end,
            "begin": begin,
            "seconds": seconds,
            "block": place.block,
            "line": place.line,
            "source": source,
            "inch": self.inch,
        }
        if path.length == 0.0:
            yield events.Dwell(**frame)
        elif feed is None:
            yield events.Rapid(**frame)
        elif isinstance(path, Circular):
            yield events.Arc(**frame, feed=rate, centre=path.centre, rotation=path.rotation, plane=path.plane)
        elif groove is not None:
            yield events.Infeed(**frame, feed=rate, axis=groove[0], groove=groove[1])
        else:
            yield events.Line(**frame, feed=rate, reciprocating=self.reciprocation is not None)

    def finish_stroke(self) -> Generator[events.Event, None, Underway]:
        table = self._table()
        yield from self.wait(self.time)
        stroke = table.underway or self._set_out(table)
        yield from self._reciprocate(stroke.finish)
        self.time = stroke.finish
        return stroke

    def reach_reversal(self) -> Iterator[events.Event]:
        table = self._table()
        if table.at_reversal:
            yield from self._hold(table)
        else:
            yield from self.finish_stroke()

    def pick(self, stroke: Underway, kind: str, axis: int, target: float, feed: float) -> Iterator[events.Event]:
        """Start a pick as the axis decelerates at the end of `stroke` (PD-22), after the last pick."""
        yield from self.wait(self.time)
        table = self._table()
        acceleration = self.control.acceleration
        rate = self.rate(feed)
        ramp = ramp_time(stroke.length, stroke.feed / 60.0, acceleration)
        picked = self._picks[-1].finish if self._picks else -math.inf
        begin = pick_begin(stroke.begin, stroke.travel, ramp, picked)
        while self._picks and self._picks[0].finish <= stroke.begin:
            self._picks.popleft()
        path = Straight(self.position, events.placed(self.position, {axis: target}))
        seconds = motion_time(path.length, rate / 60.0, acceleration)
        self._picks.append(Moving(path, begin, begin + seconds, rate / 60.0, acceleration))
        self.position = path.end
        yield events.Pick(
            start=path.start,
            end=path.end,
            begin=begin,
            seconds=seconds,
            block=table.plan.block,
            line=table.plan.line,
            source=events.Source.CYCLE,
            inch=self.inch,
            axis=axis,
            feed=rate,
            kind=kind,
        )

    def settle(self) -> None:
        table = self._table()
        self.time = max(self.time, table.free_at, *(pick.finish for pick in self._picks))
        self._picks.clear()
        table.free_at = self.time

    def acknowledge(self) -> None:
        while self._requests and self._requests[0] <= self.time:
            self._requests.popleft()
        self.control.panel.dress_requested = False
        self.table_held = self.dress_postponed = False

    def late_requests(self) -> Iterator[str]:
        for time in self._requests:
            yield (
                f"the dress asked for at {time:g} s is not made, for no stroke of a cycle comes after that: the "
                f"program ends at {self.time:.1f} s; ask for it before"
            )

    def _shown(self, time: float) -> events.Position:
        position = self.position if self._motion is None else self._motion.at(time)
        return self._with_table(position, time)

    def _true(self, time: float) -> events.Position:
        """Return the position of all axes at a time, picks under way included."""
        if not self._picks:
            return self._shown(time)
        position = self._picks[0].path.start
        for pick in itertools.takewhile(lambda pick: pick.begin <= time, self._picks):
            position = pick.at(time)
        return self._with_table(position, time)

    def _with_table(self, position: events.Position, time: float) -> events.Position:
        table = self.reciprocation
        if table is None:
            return position
        here = table.underway.coordinate(time) if table.underway else table.coordinate
        return events.placed(position, {table.axis: here})

    def _reciprocate(self, until: float) -> Iterator[events.Event]:
        """Make the strokes that end by `until`, s; no stroke begins at `until` itself."""
        table = self.reciprocation
        while table is not None and not self.table_held:
            stroke = table.underway
            if stroke is None:
                if table.free_at >= until - INSTANT:
                    return
                yield from self.wait(table.free_at)
                stroke = self._set_out(table)
            if stroke.middle is None and stroke.middle_time <= until:
                stroke.middle = self._true(stroke.middle_time)
            if stroke.finish > until + INSTANT:
                return
            yield self._arrive(table, stroke)
            yield from self._hold(table)

    def _set_out(self, table: Reciprocation) -> Underway:
        self.budget.spend(table.place)
        rate = self.table_rate(table)
        return table.begin(self._shown(table.free_at), rate, self.control.acceleration, self.dwell)

    def _arrive(self, table: Reciprocation, stroke: Underway) -> events.Stroke:
        end = self._shown(stroke.finish)
        table.arrive()
        self._settle_axis(table)
        assert stroke.middle is not None  # the middle is passed before the end
        return events.Stroke(
            start=stroke.start,
            middle=stroke.middle,
            end=end,
            begin=stroke.begin,
            seconds=stroke.travel + self.dwell,
            block=table.plan.block,
            line=table.plan.line,
            source=events.Source.CYCLE,
            inch=self.inch,
            axis=table.axis,
            feed=stroke.feed,
            number=table.count if table.in_cycle else None,
            cycle=table.plan,
        )

    def _hold(self, table: Reciprocation) -> Iterator[events.Event]:
        """Keep the table at the reversal if the operator has asked for a dress before the end of the stroke (22-11).

        During a program motion the table goes on; at rest, it would let the wheel feed into one end of the part
        (ruling 13).
        """
        panel, motion, requests = self.control.panel, self._motion, self._requests
        moving = motion is not None and motion.path.length > 0.0 and motion.finish > table.free_at + INSTANT
        while (panel.dress_requested or (requests and requests[0] <= table.free_at)) and not self.table_held:
            if table.plan.program is None:
                if panel.dress_requested:
                    panel.dress_requested = False
                else:
                    requests.popleft()
                yield events.Message(table.free_at, "no dress program")
            elif moving:
                self.dress_postponed = True
                return
            else:
                self.table_held = True

    def _settle_axis(self, table: Reciprocation) -> None:
        self.position = events.placed(self.position, {table.axis: table.coordinate})

    def _table(self) -> Reciprocation:
        assert self.reciprocation is not None  # called by cycles only
        return self.reciprocation

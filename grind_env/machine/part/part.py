"""One part on the machine: its surface in strips across, and its final result."""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from grind_env.array_types import Array
from grind_env.control import Infeed
from grind_env.control.cycle_formulas import DEPTH_TOLERANCE
from grind_env.machine.dress.dress_run import NO_DRESS, DressPlan
from grind_env.machine.dress.mounted_wheel import Mount
from grind_env.machine.job import Job, Part, PartConditions, Setup, Stage
from grind_env.machine.loops.strip_stroke import Strips
from grind_env.machine.loops.stroke_totals import NOTHING, count_dress, count_stroke
from grind_env.machine.loops.zone_layout import strip_centres, strip_zones
from grind_env.machine.part.compiled_strokes import Dressed, GroundLength, passes_of
from grind_env.machine.part.coverage import Coverage
from grind_env.machine.part.gauging import Surface, counted_rise, gauge
from grind_env.machine.part.groove_cuts import NO_CUT, GrooveCut, Grooves
from grind_env.machine.part.stroke_record import PartVerdict, table_of
from grind_env.machine.part.unsimulated_cuts import Unjudged
from grind_env.process.cost import STALL, Limits, expenses, passed_limits, survival, volume_left
from grind_env.process.stroke_types import StrokeParameters

SLOWED = 1.001  #: least ratio of the torque to the torque at the power limit with which a spindle has slowed noticeably

ANYWHERE = -1  #: station number of a part that lies at no station, or has not been met


class StageResult(NamedTuple):
    """Values of a part at the end of a stage, with its limits; the fields are the arguments of `passed_limits`."""

    rise: float  #: highest temperature rise that counts, K
    torque: float  #: ratio of the highest torque to the stall torque
    Ra: float
    worst_error: float
    limits: Limits

    @property
    def passed(self) -> tuple[str, ...]:
        return passed_limits(*self)


class PartRun:
    """A part from its loading to the loading of the next part."""

    def __init__(
        self,
        number: int,
        job: Job,
        conditions: PartConditions,
        began: float,
        *,
        new_wheel: bool = False,
        station: int = ANYWHERE,
    ) -> None:
        if conditions.part is not None:
            job = replace(job, part=conditions.part)
        self.number, self.job, self.began = number, job, began  # time of the job at which its loading began, s
        self.station, self.is_met = station, False  # from 0, `ANYWHERE` before one is met; whether strokes have met it
        self.spent = 0.0  # s of work before `began`, where the program has been at other stations
        self.conditions = conditions
        self.stock = job.part.stock if conditions.stock is None else conditions.stock
        self._new_wheel = new_wheel
        self.p = self.nominal
        self.cutting = False  # whether its first cycle or stroke has begun, which ends the loading
        self.deepest = 0.0  # deepest programmed depth so far, mm
        self.ended: list[StageResult] = []  # the stages that have ended
        self.unjudged: tuple[Unjudged, ...] = ()  # why it is not judged; empty if it is
        self.infeeds, self.tally = 0, NOTHING  # tally of strokes, infeeds and dresses; peak load since the last stage
        self._centres = strip_centres(job.part.across, job.part.width)
        self._strips = strip_zones(self._centres)
        self._S, self._Rs, self._reached = self._strips.T[:3]
        self._coverage = Coverage(job.part.start, job.part.length, self._centres.size)
        self._grooves = Grooves(job.part.surface, job.part.length, job.setup.wheel.width)
        self._plunges: list[tuple[float, float]] = []
        self._earlier_power = 0.0  # peak load in earlier stages, W
        # in the last stroke or infeed at full depth: wear of the wheel that was not yet gauged, growth of the part, mm
        self._wear = self._grown = 0.0
        self._left, self._excess = math.inf, 0.0  # wheel volume in the tally when the wheel is used up, and excess, mm3

    @property
    def nominal(self) -> StrokeParameters:
        return self.conditions.parameters(self.job.parameters, new_wheel=self._new_wheel)

    @property
    def description(self) -> str:
        return "the part" if self.station == ANYWHERE else f"the part of station {self.job.stations[self.station].name}"

    @property
    def strokes(self) -> int:
        """Return the number of strokes of the table so far, including those beside the part."""
        return int(self.tally.strokes) - self.infeeds

    def grind(
        self,
        rows: Array,
        first_ends: tuple[float, float],
        ends: tuple[float, float],
        edges: Strips,
        turns: tuple[float, float],
        acceleration: float,
        mount: Mount,
        due: Sequence[int] = (),
        dress: DressPlan = NO_DRESS,
    ) -> tuple[Array, NDArray[np.bool_]]:
        """Pass over the part once or many times; `due` lists the number of strokes before each dress.

        `rows`, dtype `STROKE_ROW`, have time, seconds, E and Z; the results of strokes are written. `first_ends` are
        the reversal points of the first stroke, mm; `edges` cross coordinates of the wheel's edge on the minus side;
        `turns` are the reversal points of the cycle, mm; `acceleration` is that of the table, mm/s2.
        Returns the dresses, shape (dresses, fields of `Dressed`), and whether each stroke has gone deeper than any
        before it at some place.
        """
        first, last = self._under(edges)
        first_way = self._way(first_ends)
        later_way = self._way(ends) if rows.size > 1 else first_way
        plunged = np.empty(rows.size, np.bool_)
        dressed = np.empty((len(due), len(Dressed._fields)))
        wheel, self.tally, memory_time = passes_of(self.job.process)(
            mount.present(self.p),
            self._strips,
            abs(turns[0] - turns[1]),
            self.job.part.off(*turns),
            acceleration,
            self._coverage.written(),
            table_of(rows),
            first_way,
            later_way,
            first,
            last,
            plunged,
            np.array(due, np.int64),
            dress,
            dressed,
            self.job.part.width,
            self.p,
            self.tally,
            mount.own,
            mount.memory_time,
        )
        mount.set_wheel(wheel, memory_time)
        Z, over = rows["Z"], rows["Lw"] > 0.0
        self.deepest = max((self.deepest, *Z[over].tolist()))
        # a part may cool below a wheel that goes no deeper: the last stroke that cut decides
        finishing = np.flatnonzero(over & (self.deepest - DEPTH_TOLERANCE <= Z) & (rows["ae"] > 0.0))
        if finishing.size:
            last_one = rows[finishing[-1]]
            self._wear, self._grown = float(last_one["W"] - last_one["dw"]), float(last_one["grown"])
        self._plunges += zip(Z[plunged].tolist(), rows["T"][plunged].tolist(), strict=True)
        if not (first_way.is_full_length and later_way.is_full_length):
            for k in np.flatnonzero(over).tolist():
                if not (later_way if k else first_way).is_full_length:
                    self._coverage.add(int(first[k]), int(last[k]), ends if k else first_ends, float(Z[k]))
        return dressed, plunged

    def _way(self, ends: tuple[float, float]) -> GroundLength:
        part = self.job.part
        Lw = max(min(max(ends), part.start + part.length) - max(min(ends), part.start), 0.0)
        return GroundLength(Lw, self._coverage.is_full_length(ends))

    def reached(self, edges: tuple[float, float], ends: tuple[float, float]) -> float:
        """Return the least depth that strokes have reached in the area that a wheel sweeps on the part, mm.

        The wheel moves between two `edges`, cross coordinates on the minus side, and two `ends` along the table, mm.
        """
        return self._coverage.least_between(*self._swept(edges), ends)

    def left_at(self, edges: tuple[float, float], ends: tuple[float, float]) -> float:
        """Return the least depth of the surface in the area that a wheel sweeps, mm; arguments as of `reached`.

        The surface is less deep than the strokes, because wheel and machine yield.
        """
        first, last = self._swept(edges)
        return min(self._coverage.least_between(first, last, ends), float(self._S[first:last].min()))

    def _swept(self, edges: tuple[float, float]) -> tuple[int, int]:
        first, last = int(self._under(min(edges))[0]), int(self._under(max(edges))[1])
        first = min(first, len(self._centres) - 1)  # the nearest strip for a wheel over no middle of a strip
        return first, max(last, first + 1)

    def _under(self, edge: Any) -> tuple[Any, Any]:
        return self._centres.searchsorted(edge), self._centres.searchsorted(edge + self.job.setup.wheel.width)

    def infeed(self, mount: Mount, event: Infeed) -> GrooveCut:
        """Make an infeed into a groove; the cut is empty for a turning tool, above the surface or in the air."""
        self.infeeds += 1
        grinds, wear = self.job.setup.grooving_wheel and not self.stalled, mount.present(self.p).W
        cut = self._grooves.grind(mount, event, self.p) if grinds else NO_CUT
        if cut.plunged:
            self._wear, self._grown = wear, cut.grown
        self.tally = count_stroke(
            self.tally, cut.stroke, event.seconds, 0.0, cut.plunged, False, False, self.p.stall_time
        )
        return cut

    @property
    def stalled(self) -> bool:
        return self.tally.peak_torque >= STALL

    def end_stage(self) -> None:
        if not self.cutting or len(self.ended) == len(self.job.part.stages):
            return
        asked = self.job.part.stages[len(self.ended)]
        self.ended.append(self._result(asked, self._surface(asked.stock), self.job.limits_at(asked)))
        self._earlier_power = max(self._earlier_power, self.tally.peak_load)
        # gauging does not undo a stall
        torque = self.tally.peak_torque if self.stalled else 0.0
        self.tally = self.tally._replace(peak_load=0.0, peak_torque=torque)
        for plunges in (self._plunges, *(groove.plunges for groove in self._grooves)):
            plunges.clear()

    def change_wheel(self) -> None:
        self._new_wheel = True
        self.p = self.nominal

    def find_wheel(self, diameter: float) -> None:
        """Begin a part or a cycle with a wheel of this diameter, mm, which limits the wear."""
        self._excess = self._beyond_wheel()
        self._left = self._off() + volume_left(diameter, self.job.setup.wheel.width)

    def _off(self) -> float:
        return self.tally.worn + self.tally.dressed_off

    def _beyond_wheel(self) -> float:
        """Return the excess over the volume of the wheel, mm3."""
        return self._excess + max(self._off() - self._left, 0.0)

    def take_up(self, setup: Setup) -> bool:
        if setup is self.job.setup:
            return False
        self.job = replace(self.job, setup=setup)
        self.p = self.nominal
        return True

    def dress(self, seconds: float, removed: float) -> None:
        self.tally = count_dress(self.tally, seconds, removed)

    @property
    def missed(self) -> bool:
        return self.infeeds > 0 and self.job.setup.grooving_wheel and not tuple(self._grooves)

    @property
    def left(self) -> float:
        return self.stock - float(self._ground()[0].mean())

    @property
    def last_stage(self) -> StageResult:
        """Return the last stage as it is now, with the heat of plunges that is not ground off again."""
        return self._result(self.job.part, self._surface(self.stock), self.job.limits)

    def _result(self, asked: Stage | Part, found: Surface, limits: Limits) -> StageResult:
        every = asked.rise_allowance > 0.0
        grooves = (counted_rise(groove.plunges, groove.reached[0], every) for groove in self._grooves)
        rise = max((counted_rise(self._plunges, self.deepest, every), *grooves))
        return StageResult(rise, self.tally.peak_torque, found.Ra, found.worst_error, limits)

    def _ground(self) -> tuple[Strips, Strips, Strips]:
        """Return depth, mm, roughness, um, and deepest programmed depth, mm, of the strips that are judged.

        Without any stroke, the grooves are judged.
        """
        grooves = () if self.strokes else tuple(self._grooves)
        if not grooves:
            return self._S, self._Rs, self._reached
        S, Rs, reached = zip(*((groove.S, groove.Rs, groove.reached) for groove in grooves), strict=True)
        return np.concatenate(S), np.concatenate(Rs), np.concatenate(reached)

    @property
    def size_shares(self) -> tuple[float, float, float, float]:
        """Return the mean size error in um, split: wheel wear, growth, deflection, depth left by the program."""
        S, _, reached = self._ground()
        growth = -1000.0 * self._grown
        missed = 1000.0 * float(reached.mean() - S.mean()) - growth
        wear = min(1000.0 * self._wear, max(missed, 0.0))
        return wear, growth, missed - wear, 1000.0 * (self.stock - float(reached.mean()))

    def _surface(self, stock: float) -> Surface:
        S, Rs, _ = self._ground()
        return gauge(S, Rs, stock, self._coverage.least() if self.strokes else None)

    def row(self) -> tuple[float, ...]:
        job, tally, found, last = self.job, self.tally, self._surface(self.stock), self.last_stage
        unground = 0.0 if self.infeeds and not self.strokes else self._coverage.unground
        earlier = math.prod((survival(*each) for each in self.ended), start=1.0)
        good = 0.0 if unground > 0.0 or self.unjudged else earlier * survival(*last)
        spent = expenses(self.spent, self._off() - self._beyond_wheel(), tally.dresses, job.rates)
        costs = *spent, job.part.scrap_cost * (1.0 - good)
        return (
            self.number,
            self.spent,
            self.strokes,
            self.infeeds,
            int(tally.dresses),
            self.stock,
            found.S,
            found.size_error,
            found.taper,
            found.worst_error,
            *self.size_shares,
            unground,
            found.Ra,
            min(max(self._earlier_power, tally.peak_load), self.p.power),
            max(each.torque for each in (*self.ended, last)),
            last.rise,
            max(each.rise for each in (*self.ended, last)),
            tally.burn_ratio,
            tally.worn,
            tally.dressed_off,
            earlier,
            *PartVerdict(good, *costs, sum(costs)),
        )

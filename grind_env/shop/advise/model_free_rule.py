"""The rule that advises E and D without a model, from readings of this machine.

    ln P = c + f ln E + g ln(V' + 10)   peak power of a kind of block, by recursive least squares
    Ra ~ E^0.5, size ~ E                of finished parts
    P / E^0.5                           heat of the work (Jaeger: heat flows off as the root of the table speed)

If there is a model, the rule takes one number from it: the burn ratio of a block per watt.

A dress is due when the next part takes longer than the mean time of the parts since the last dress, with the time of
that dress (renewal: Malkin and Guo, Grinding Technology, 2008, section 12.3), or when readings ask for it.
"""

import math
from dataclasses import dataclass, field
from statistics import NormalDist
from typing import NamedTuple

import numpy as np

from grind_env.envs.block_kind_rows import KindRow
from grind_env.envs.job.job_simulation import JobSimulation
from grind_env.envs.job.program_outline import JobChoice
from grind_env.policies.choices import nearest_speed
from grind_env.policies.scripted.empirical_rule import INTERVAL, usual_volumes
from grind_env.policies.scripted.learned_laws import AIM, LEAST_EXPONENT, SCATTER, WORN_IN, PartLaw, PowerLaw

SHARE = 0.92  #: share of the power limit that is planned to be used
#: greatest factor on E from block to block of a kind: as a rule, and if all readings are below `EASY` of their limits.
#: Sizes must then be below `EASY_SIZE` times `EASY` of their limit, because all blocks of a part add to them
STEP, EASY_STEP, EASY, EASY_SIZE = 1.25, 1.5, 0.5, 0.7
SIZE_AIM = 0.5  #: mean share of the size tolerance to aim at; gauges drift, too
NEAR = 0.75  #: share of a limit of size or Ra above which no block of the part becomes faster
#: burn ratio that the model allows. Factors from a heat to the allowed heat: of the first part, if above this ratio, of
#: a part that did not burn, and of a part that burnt
HEAT, ROOM, FURTHER, BACK = 0.78, 1.25, 1.1, 0.88
COOLS = 0.6  #: exponent of power over E from which on a slower table is cooler
#: factors on E: beyond a limit, after a burn, and from block to block after a burn. Factor by which the bound on E
#: rises with every further block of its kind
SLOWER, BURNT_SLOWER, BURNT_STEP, FORGIVEN = 0.9, 0.8, 1.05, 1.005
#: volume between two dresses over the conductivity of the work; half as much again, because every part has readings
USUAL_INTERVAL = 1.5 * INTERVAL
REGAINED = 1.02  #: factor by which a reduced dress volume grows back with every good part
#: standard deviation of the logarithm of the burn ratio at which parts burn; greatest number of such deviations that
#: counts; number of readings in the running mean of the scatter
UNSURE, SUREST, MEMORY = 0.4, 6.0, 8.0
MOST_EXECUTIONS = 2
OVERLOAD = 1.2  #: ratio of power to its limit above which two dress executions are made
#: a slower table is kept if power falls below this share of its former value within this number of blocks
LOWERED, BLOCKS = 0.98, 3


class BlockReadings(NamedTuple):
    """Readings of a block as ratios to their limits; None if not read."""

    peak: float = 0.0  #: peak power, W; 0 if not read
    size: float | None = None  #: size of the part that the block finished; negative if too much was ground
    Ra: float | None = None
    Ra_before: float | None = None  #: Ra of the part before
    burn: bool | None = None


class Reduction(NamedTuple):
    """Slower table whose effect is still awaited, for `blocks` blocks."""

    speed: float  #: former E, mm/min
    power: float  #: former peak power, W
    blocks: int


@dataclass
class Rule:
    """Rule for one machine, block by block, from a freshly dressed wheel on."""

    simulation: JobSimulation  #: simulation of the program
    step: float = STEP  #: greatest factor on E from block to block of a kind
    reason: str = field(init=False, default="")  #: reason of the last decision

    def __post_init__(self) -> None:
        """Begin with the E of the program."""
        branches, rows = self.simulation.branches, self.simulation.kinds.tolist()
        self.rows, self.kind_of = [KindRow(*row) for row in rows], branches.kind_of_row.tolist()
        assert branches.own_speeds is not None
        self.own = np.asarray(branches.own_speeds, float)
        kinds = len(self.own)
        self.power, self.volumes = PowerLaw(kinds), usual_volumes(self.simulation, USUAL_INTERVAL)
        # the heat at which the work burns is taken from the catalogue, not from a calibration
        self.heat_factor = self.simulation.job.part.material.heat_factor
        self.volumes *= self.heat_factor
        self.usual_volumes = self.volumes.copy()
        one = np.ones(1)
        self.roughness = PartLaw(1, one, exponent=0.5, usual=0.5, memory=8.0)
        self.size = PartLaw(1, one, exponent=1.0, usual=0.25, memory=2.0, aim=SIZE_AIM)
        self.speeds, self.tried, self.ceiling = self.own.copy(), self.own.copy(), np.full(kinds, np.inf)
        self.peaks, self.heat, self.last_heat, self.worn, self.good_heat = np.zeros((5, kinds))
        self.squares = np.full(kinds, SCATTER**2)
        self.allowed, self.burnt = np.full((2, kinds), np.inf)
        """Allowed heat and heat known to burn, for each kind: burn ratio, or W / (mm/min)^0.5 without a model."""
        self.reductions: dict[int, Reduction] = {}
        self.without_effect: set[int] = set()
        self.modelled, self.slows = self.simulation.compiled, False
        self.size_ratio, self.limit_ratio, self.finish, self.wanted, self.why = 0.0, 0.0, 1.0, 0.0, ""
        self.dressing = branches.dress_price / branches.second_price
        self.scrap = self.simulation.job.part.scrap_cost / branches.second_price
        self.seconds_since_dress, self.parts_since_dress = self.dressing, 0
        self.volume_before, self.volume_at_start, self.executions_due = 0.0, 0.0, 0.0

    def decide(self, number: int, volume: float) -> JobChoice:
        """Return E, mm/min, and D of a block; `volume` is the volume ground since the dress before it, mm3/mm."""
        block, ground = self.simulation.blocks[number], self.ground(number)
        self.volume_before = volume
        if block.starts_part:
            self.volume_at_start = volume
            asked = (self.wanted or float(self.pays(number, volume))) if volume > 0.0 else 0.0
            self.executions_due = self.executions(number, asked) if asked else 0.0
        D = self.executions_due if block.takes_dresses else 0.0
        self.executions_due -= D
        E, self.reason = self.fastest(number, volume + ground / (D + 1.0))
        if D:
            self.reason = f"dress: {self.why}"
        elif self.simulation.task.action.speed_ends[1] < E:
            self.reason = "E is at its upper bound"
        return JobChoice(float(nearest_speed(self.simulation.task, np.array([E]))[0]), int(D))

    def executions(self, number: int, asked: float) -> float:
        """Return the fewest dress executions with which the part stays cool, or those asked for if none are enough."""
        first, *later = self.simulation.branches.part_from(number)
        for D in np.arange(asked, max(MOST_EXECUTIONS, self.simulation.blocks[number].plan.dresses) + 1.0):
            worn = self.ground(first) / (D + 1.0)
            hot = self.is_hot(first, worn)
            for each in later:
                worn += self.ground(each)
                hot |= self.is_hot(each, worn)
            if not hot:
                return float(D)
        return asked

    def is_hot(self, number: int, volume: float) -> bool:
        """Return whether a block would come nearer to burning than is allowed."""
        E = self.fastest(number, volume)[0]
        return bool(self.peaks[self.kind_of[number]] > 0.0 and self.heat_left(number, E, volume) < 0.0)

    def pays(self, number: int, volume: float) -> bool:
        """Return whether a dress pays before the part that begins with a block."""
        stay, fresh, new, risk, hot, over, dull = 0.0, 0.0, 0.0, 0.0, False, False, False
        worn, first = volume, self.ground(number)
        for each in self.simulation.branches.part_from(number):
            worn, new = worn + self.ground(each), new + self.ground(each)
            k, E = self.kind_of[each], self.fastest(each, worn)[0]
            stay, fresh = stay + self.seconds(each, E), fresh + self.seconds(each, self.fastest(each, new)[0])
            hot |= self.is_hot(each, worn)
            over |= bool(self.peaks[k] and self.expected(each, E, worn) + SCATTER > np.log(self.rows[each].power))
            dull |= bool(worn > self.volumes[k])
            # a dress before the next part lies in the middle of its first block
            risk = max(risk, self.risk(each, worn + 0.5 * first * (each == number)))
        left = self.simulation.parts - self.simulation.blocks[number].part
        k, n = self.kind_of[number], max(self.parts_since_dress, 1)
        slower = stay > self.seconds_since_dress / n and (stay - fresh) * left > self.dressing
        self.slows = longer = over or (self.parts_since_dress > 0 and slower)
        # beyond the usual volume only if one dress fewer in n (n + 1) parts, or in all parts left, is worth the risk
        dull &= risk >= 1.0 or risk * self.scrap > self.dressing * max(left / (n * (n + 1)), 1.0 / left)
        duller = 100.0 * np.expm1(self.power.found[k, 2] * np.log((worn + WORN_IN) / (new + WORN_IN)))
        self.why = f"power {duller:+.0f} % since the last dress"
        if not longer:
            self.why = "the wheel would come near burning" if hot else f"{worn:.0f} mm3/mm since the last dress"
        return bool(longer or hot or dull)

    def fastest(self, number: int, volume: float) -> tuple[float, str]:
        """Return the fastest E, mm/min, of a block that ends `volume` (mm3/mm) after the dress, and why no faster."""
        k, last = self.kind_of[number], self.speeds[self.kind_of[number]]
        if self.peaks[k] == 0.0:
            return min(last, self.ceiling[k]), "E stays until the power of this block is read"
        limit, rate = self.rows[number].power, self.power.found[k, 1]
        power = (np.log(SHARE * limit) - self.expected(number, last, volume)) / max(rate, LEAST_EXPONENT)
        heat = self.heat_left(number, last, volume) / (rate - 0.5) if rate > COOLS else np.inf
        # forecasts do not slow the table below the program's E: a dress costs less, and slow tables burn
        slowest = np.log(min(self.own[k], last) / last)
        power, heat = max(power, 0.0 if k in self.without_effect else slowest), max(heat, slowest)
        easy = max(self.limit_ratio, self.size_ratio / EASY_SIZE, self.peaks[k] / limit) < EASY
        step = max(self.step, EASY_STEP) if easy else self.step
        step = step if np.isinf(self.burnt[k]) else min(step, BURNT_STEP)
        rises = ("E rises step by step", step * self.tried[k])
        # a fast roughing leaves more to the finish; Ra depends on the finish alone, once the finish is slower for it
        smooth, right = (float(law.speed(np.zeros(1, np.int64))[0]) for law in (self.roughness, self.size))
        finishes = self.simulation.blocks[number].finished > 0
        ratio = self.limit_ratio if finishes or smooth >= 1.0 else self.size_ratio
        if ratio > NEAR:
            rises = (f"size or Ra is at {100.0 * ratio:.0f} % of its limit", last)
        smooth, right = max(smooth, SLOWER) * self.own[k] if finishes else np.inf, max(right, SLOWER) * self.own[k]
        bounds = {
            f"power {100.0 * self.peaks[k] / limit:.0f} % of its limit": last * np.exp(min(power, 5.0)),
            "faster would come near burning": last * np.exp(min(heat, 5.0)),
            "faster would be too rough": smooth,
            "faster would leave too much stock": right,
            rises[0]: rises[1],
            "faster came beyond a limit": self.ceiling[k],
        }
        why = min(bounds, key=lambda name: bounds[name])
        return float(bounds[why]), why

    def ground(self, number: int) -> float:
        """Return the volume that a block grinds, mm3 per mm of width."""
        return self.rows[number].length * self.rows[number].stock

    def ground_by_part(self, number: int) -> float:
        """Return the volume that all blocks of a part grind, mm3 per mm of width."""
        return sum(self.ground(each) for each in self.part_of(number))

    def part_of(self, number: int) -> range:
        """Return the numbers of all blocks of a block's part."""
        first = number
        while not self.simulation.blocks[first].starts_part:
            first -= 1
        return self.simulation.branches.part_from(first)

    def seconds(self, number: int, E: float) -> float:
        """Return the time of a block, s."""
        return float(self.simulation.branches.seconds(np.array([number]), np.array([E]))[0])

    def expected(self, number: int, E: float, volume: float) -> float:
        """Return the logarithm of the expected peak power of a block, W."""
        level, rate, dulling = self.power.found[self.kind_of[number]]
        return float(level + rate * np.log(E) + dulling * np.log(volume + WORN_IN))

    def power_at(self, number: int, choice: JobChoice) -> float | None:
        """Return the expected peak power of a block, W; None if no power of its kind was read."""
        if self.peaks[self.kind_of[number]] == 0.0:
            return None
        worn = self.volume_before + self.ground(number) / (choice.executions + 1.0)
        return float(np.exp(self.expected(number, choice.speed, worn)))

    def heat_left(self, number: int, E: float, volume: float) -> float:
        """Return the logarithm of the allowed heat over the expected heat."""
        k = self.kind_of[number]
        last = self.speeds[k]
        more = self.expected(number, E, volume) - self.expected(number, last, self.worn[k]) - 0.5 * np.log(E / last)
        return float(np.log(self.allowed[k] / self.last_heat[k]) - more)

    def risk(self, number: int, volume: float) -> float:
        """Return the probability that a block burns at its last E if it has not burnt after a smaller volume."""
        k = self.kind_of[number]
        if self.good_heat[k] == 0.0 or (self.volumes < self.usual_volumes).any():
            return 1.0
        hotter = float(np.log(self.allowed[k] / self.good_heat[k])) - self.heat_left(number, self.speeds[k], volume)
        scatter, normal = math.sqrt(self.squares[k]), NormalDist()
        beyond = hotter * normal.cdf(hotter / scatter) + scatter * normal.pdf(hotter / scatter)  # mean excess
        proved = min(math.log(self.good_heat[k] / self.heat_factor) / UNSURE, SUREST) if self.modelled else 0.0
        return beyond * normal.pdf(proved) / (UNSURE * normal.cdf(-proved))

    def learn(
        self, number: int, choice: JobChoice, readings: BlockReadings, volume: float, burn_per_watt: float
    ) -> None:
        """Learn from the readings of a block; `volume` is after it, mm3/mm; `burn_per_watt` is 0 without a model."""
        k, block, (E, D) = self.kind_of[number], self.simulation.blocks[number], choice
        # executions are spread evenly over a block: the wheel is dullest before the first one or after the last
        worn = max(self.volume_before + self.ground(number) / (D + 1.0), volume) if D else volume
        self.speeds[k] = E
        if D:
            self.seconds_since_dress, self.parts_since_dress, self.wanted = D * self.dressing, 0, 0.0
        self.seconds_since_dress += self.seconds(number, E)
        self.parts_since_dress += block.starts_part
        if readings.peak > 0.0:
            self._learn_power(number, choice, readings.peak, worn, burn_per_watt)
        if block.finished:
            self._learn_part(number, readings, worn)

    def _learn_power(self, number: int, choice: JobChoice, peak: float, worn: float, burn_per_watt: float) -> None:
        k, limit, (E, D), every = self.kind_of[number], self.rows[number].power, choice, np.ones(len(self.own))
        self.power.learn(peak * every, E * every, worn * every, np.arange(len(every)) == k)
        if self.peaks[k] > 0.0:
            self.squares[k] += ((np.log(peak) - self.power.expected[k]) ** 2 - self.squares[k]) / MEMORY
        heat = burn_per_watt * peak if self.modelled else peak / np.sqrt(E)
        if self.peaks[k] == 0.0:
            self.allowed[k] = HEAT if self.modelled and heat < HEAT else ROOM * heat
        heat = self.last_heat[k] = heat or self.last_heat[k] or self.allowed[k]
        self.heat[k], self.peaks[k], self.worn[k] = max(heat, self.heat[k]), peak, worn
        self.tried[k] = max(self.tried[k], E) if peak < limit and np.isinf(self.burnt[k]) else E
        self.ceiling[k] *= FORGIVEN
        if (before := self.reductions.pop(k, None)) is not None and peak >= LOWERED * before.power:
            if before.blocks > 1:
                self.reductions[k] = before._replace(blocks=before.blocks - 1)
            else:  # the slower table has not helped: back to the faster one
                self.without_effect.add(k)
                self.ceiling[k], self.tried[k] = np.inf, max(self.tried[k], before.speed)
                self.speeds[k] = before.speed
        if peak <= limit:
            return
        self._ask(2.0 if peak > OVERLOAD * limit and D else 1.0, f"power at {100.0 * peak / limit:.0f} % of its limit")
        if self.volume_before <= self.ground_by_part(number) and k not in self.without_effect:  # the wheel was sharp
            self.ceiling[k] = SLOWER * min(E, self.ceiling[k])
            self.reductions.setdefault(k, Reduction(E, peak, BLOCKS))

    def _learn_part(self, number: int, readings: BlockReadings, worn: float) -> None:
        k, none, one = self.kind_of[number], np.zeros(1, np.int64), np.ones(1, bool)
        made = self.speeds[k] / self.own[k]
        ratios = []
        for law, ratio, speed in (
            (self.roughness, readings.Ra_before, self.finish),
            (self.roughness, readings.Ra, made),
            (self.size, None if readings.size is None else abs(readings.size), made),
        ):
            if ratio is not None:
                law.learn(np.array([ratio]), none, np.array([speed]), one)
                ratios.append(ratio)
        self.finish, self.limit_ratio = made, max(ratios, default=self.limit_ratio)
        self.size_ratio = self.size_ratio if readings.size is None else abs(readings.size)
        if readings.size is not None and (readings.size > NEAR or readings.size < -AIM):
            self._ask(1.0, "the size of the last part")
        if readings.burn is not None:
            self._learn_burn(number, burnt=readings.burn)
        self.heat[:] = 0.0
        self.volumes = np.minimum(REGAINED * self.volumes, self.usual_volumes)
        if readings.burn or (readings.size is not None and (readings.size > 1.0 or readings.size < -AIM)):
            self.volumes = np.minimum(self.volumes, AIM * max(worn, 1.0))

    def _learn_burn(self, number: int, *, burnt: bool) -> None:
        kinds = [*dict.fromkeys(self.kind_of[each] for each in self.part_of(number))]
        if burnt:  # the burn comes from a block that was hotter than in any good part
            kinds = [k for k in kinds if self.heat[k] > self.good_heat[k]] or kinds
        for k in kinds:
            if burnt:
                self.burnt[k] = min(self.burnt[k], BACK * self.heat[k]) if self.heat[k] else self.burnt[k]
            else:
                self.allowed[k] = max(self.allowed[k], FURTHER * self.heat[k])
                self.good_heat[k] = max(self.good_heat[k], self.heat[k])
            self.allowed[k] = min(self.allowed[k], self.burnt[k])
        if burnt:
            self._ask(1.0, "the last part burnt")
            if self.volume_at_start <= self.ground_by_part(number):  # a sharp wheel burns because of E
                self.ceiling[kinds] = BURNT_SLOWER * np.minimum(self.speeds[kinds], self.ceiling[kinds])

    def _ask(self, executions: float, why: str) -> None:
        """Ask for a dress before the next part."""
        if executions > self.wanted:
            self.wanted, self.why = executions, why

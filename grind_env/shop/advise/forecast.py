"""Why: what is believed of the wheel, and what the coming block would come to with it."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from grind_env.belief.wheel import WheelBelief
from grind_env.envs.job.simulation import JobSimulation
from grind_env.envs.model import MemberModel
from grind_env.envs.tables import KindRow, ShopMemory
from grind_env.machine.loops.tally import Tally
from grind_env.policies.columns import AREA, COST, LOADING
from grind_env.policies.scripted.rules import LOADED_AREA, REFERENCE_AREA

PARTS_AHEAD = 5
"""Parts over which what a dress saves is counted."""
SHARP, DULL = 0.8, 1.6
"""Wear-flat area over that of a wheel at which rules have their stated E."""
LEAST_SAVING = 0.005
"""$; less is told as nothing."""
POWER = KindRow._fields.index("power")
PEAK = Tally._fields.index("peak_load")
SURVIVAL = ShopMemory._fields.index("survival")


class Forecast(NamedTuple):
    """What is believed before a block, and expected of it."""

    dullness: float
    """Mean of the wear-flat area, loading included, share of the wheel's surface."""
    dullness_spread: float
    """Standard deviation, like the next two of that name."""
    growth: float
    """Factor on how fast wheel and lot dull, 1 for usual ones."""
    growth_spread: float
    """Logarithmic."""
    power: float
    """Highest load of the coming block at its E and D, W."""
    power_spread: float
    power_limit: float
    """What the spindle has above idle, W."""
    executions: int
    """D of it."""
    dresses: int
    """Executions whose price and saving follow; 0 where the block can have none."""
    dress_cost: float
    """$."""
    dress_saving: float
    """What the parts ahead cost less with it now than with it one part later, or not at all after the last one, $."""
    parts: int
    """How many they are."""


class Forecaster:
    """Follows wheel and lot of one episode by an ensemble, as `grind_env.belief` does.

    Raises:
        BeliefError: the control has to execute the program, which no ensemble can.
    """

    def __init__(self, simulation: JobSimulation) -> None:
        self.simulation, self.model = simulation, MemberModel(simulation)
        self.belief = WheelBelief(self.model)
        self.belief.begin(1)

    def update(self, observation: NDArray[np.float32]) -> None:
        """Take in the observation before a block, shape (1, entries)."""
        self._believed = self.belief.update(observation)

    def forecast(self, block: int, speed: float, executions: int) -> Forecast:
        """What is believed, and what E (mm/min) and D make of it; `block` is the number of the coming one, from 0."""
        simulation, wheels = self.simulation, self.belief.wheels[0]
        area = wheels[:, AREA] + LOADED_AREA * wheels[:, LOADING]
        outlines = simulation.blocks
        first, last_part = outlines[block], min(outlines[block].part + PARTS_AHEAD, simulation.parts) - 1
        ahead = [number for number in range(block, len(outlines)) if outlines[number].part <= last_part]
        peak, cost = self._grind(ahead, speed, executions)
        tried = max(executions, 1) if first.takes_dresses else 0
        saved, price = 0.0, tried * simulation.branches.dress_price
        if tried:
            # what a policy weighs is when to dress, and not whether
            later = next((k for k in ahead if outlines[k].part > first.part and outlines[k].takes_dresses), -1)
            now = cost if executions else self._grind(ahead, speed, tried)[1]
            saved = self._grind(ahead, speed, tried, later)[1] - now
        return Forecast(
            dullness=float(area.mean()),
            dullness_spread=float(area.std()),
            growth=float(np.exp(self._believed.growth[0])),
            growth_spread=float(self._believed.growth_spread[0]),
            power=float(peak.mean()),
            power_spread=float(peak.std()),
            power_limit=float(simulation.kinds[block, POWER]),
            executions=executions,
            dresses=tried,
            dress_cost=price,
            dress_saving=saved,
            parts=last_part - first.part + 1,
        )

    def _grind(
        self, blocks: list[int], speed: float, executions: int, dressed: int | None = None
    ) -> tuple[NDArray[np.float64], float]:
        """Highest load of each member in the first of these blocks, W, and mean cost of all, $.

        Args:
            blocks: numbers.
            speed: E of the first one and of those with the same text, mm/min.
            executions: D of one block; that of all others is 0.
            dressed: number of that block, the first one if None; -1 for none of them.
        """
        belief, outlines = self.belief, self.simulation.blocks
        members = np.arange(belief.size)
        branches = belief.members.pick(members)
        self.model.write_factors(branches, members, belief.factors()[0])
        branches.memory[:] = 0.0
        branches.memory[:, SURVIVAL] = 1.0
        dressed = blocks[0] if dressed is None else dressed
        total, peak = 0.0, np.zeros(belief.size)
        text = outlines[blocks[0]].block.source.text
        for number in blocks:
            first, outline = number == blocks[0], outlines[number]
            E = speed if outline.block.source.text == text else outline.plan.feed
            choice = np.full(belief.size, E), np.full(belief.size, float(executions * (number == dressed)))
            outcomes, tallies = self.model.simulation.step(branches, *choice)
            total += float(outcomes[:, COST].mean())
            peak = tallies[:, PEAK].copy() if first else peak
        return peak, total


def sentences(seen: Forecast, *, weighed: bool = True) -> list[str]:
    """A forecast as sentences; `weighed` says whether it is what the advice rests on, and the model not in doubt."""
    relative = seen.dullness / REFERENCE_AREA
    state = "sharp" if relative < SHARP else "dull" if relative > DULL else "neither sharp nor dull"
    slow, fast = (seen.growth * np.exp(sign * seen.growth_spread) for sign in (-1.0, 1.0))
    dulling = f"{seen.growth:.1f} times as fast as usual ({slow:.1f} to {fast:.1f})"
    by = "" if weighed else "by the model, which is in doubt, "
    said = [
        f"{by}the wheel is believed {state}: wear flats {100.0 * seen.dullness:.2f} % of it, "
        f"+/- {100.0 * seen.dullness_spread:.2f}; it dulls {dulling}",
        f"expected power {seen.power / 1000.0:.2f} kW +/- {seen.power_spread / 1000.0:.2f} at this E, "
        f"the spindle has {seen.power_limit / 1000.0:.2f} kW",
    ]
    if seen.dresses and weighed:
        times = "a dress" if seen.dresses == 1 else f"{seen.dresses} dress executions"
        parts = "this part" if seen.parts == 1 else f"these {seen.parts} parts"
        when = "now rather than one part later" if seen.parts > 1 else "now"
        worth = f"{'saves' if seen.dress_saving > 0.0 else 'loses'} about {abs(seen.dress_saving):.2f} $"
        if abs(seen.dress_saving) < LEAST_SAVING:
            worth = "saves nothing"
        # what advises may look further ahead than this
        otherwise = abs(seen.dress_saving) >= LEAST_SAVING and (seen.dress_saving > 0.0) != (seen.executions > 0)
        but = ": what advises counts more than these" if otherwise else ""
        said.append(f"{times} costs {seen.dress_cost:.2f} $, and {when} {worth} over {parts}, E being the same{but}")
    return said

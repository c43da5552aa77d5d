"""Rehearsal: a batch on a simulated machine with E and D of any decider; its cost and its readings."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from grind_env.array_types import Array
from grind_env.envs.cost import Outcome
from grind_env.envs.job.job_simulation import JobSimulation
from grind_env.envs.job.program_outline import JobChoice
from grind_env.process.cost import NO_LIMIT, survival
from grind_env.shop.advise.adviser import Adviser
from grind_env.shop.advise.operator_readings import MachineReadings

#: seeds, the same for all compared batches: of lots, stocks and noise, and with it of the parts that burn
LOTS, BURNS = 1, 2
COST, GOOD, RISE = (Outcome._fields.index(name) for name in ("cost", "good", "rise"))

#: function that chooses E and D of a block from its number, from 0, and the readings of the block before
Decide = Callable[[int, MachineReadings | None], JobChoice]


@dataclass(frozen=True, slots=True, kw_only=True)
class BatchResult:
    """Result of a batch."""

    cost: Array  #: cost of each part, including scrap, $
    scrap: Array  #: probability that each part is scrap
    speeds: Array  #: E of each block, mm/min
    executions: Array  #: D of each block
    readings: tuple[MachineReadings, ...]  #: readings of each block


def as_programmed(simulation: JobSimulation) -> Decide:
    """Return a decider that keeps E and D of the program."""
    plans = [block.plan for block in simulation.blocks]
    return lambda number, _: JobChoice(plans[number].feed, int(plans[number].dresses))


def advised(adviser: Adviser) -> Decide:
    """Return a decider that follows an adviser."""

    def decide(number: int, readings: MachineReadings | None) -> JobChoice:
        if readings is not None:
            adviser.take(readings)
        assert adviser.advice is not None
        return JobChoice(adviser.advice.speed, adviser.advice.executions)

    return decide


def ground(simulation: JobSimulation, decide: Decide, seed: int = LOTS) -> BatchResult:
    """Simulate a batch block by block and return its result."""
    episodes = simulation.start([np.random.default_rng(seed)])
    job, blocks = simulation.job, simulation.blocks
    cost, scrap = np.zeros((2, simulation.parts))
    # a part of which half are burnt is read as burnt in half of the batches
    chances = np.random.default_rng((seed, BURNS)).random(simulation.parts)
    speeds, executions = np.zeros((2, len(blocks)))
    all_readings, readings, heat = list[MachineReadings](), None, 0.0
    for number, block in enumerate(blocks):
        choice = decide(number, readings)
        outcomes, _ = simulation.step(episodes, np.array([choice.speed]), np.array([float(choice.executions)]))
        cost[block.part] += outcomes[0, COST]
        scrap[block.part] = 1.0 - outcomes[0, GOOD]
        heat = max(0.0 if block.starts_part else heat, float(outcomes[0, RISE]))
        readings = read(simulation, simulation.observe(episodes), number)
        if block.finished:
            limits = job.of_part(block.part + 1).limits._replace(roughness=NO_LIMIT, size=NO_LIMIT)
            readings = replace(readings, burn=bool(chances[block.part] > survival(heat, 0.0, 0.0, 0.0, limits)))
        speeds[number], executions[number] = choice
        all_readings.append(readings)
    return BatchResult(cost=cost, scrap=scrap, speeds=speeds, executions=executions, readings=tuple(all_readings))


def read(simulation: JobSimulation, observation: NDArray[np.float32], number: int) -> MachineReadings:
    """Return the readings of a block as an operator would type them, from the observation after it."""
    seen = {name: float(value[0]) for name, value in simulation.read(observation).items()}
    first, mean, peak = (seen[name] or None for name in ("first_power", "mean_power", "peak_power"))
    readings = MachineReadings(first_power=first, mean_power=mean, peak_power=peak)
    if not simulation.blocks[number].finished:
        return readings
    gauged = round(seen["parts_since_gauged"]) == 1 and seen["roughness"] > 0.0
    return replace(
        readings,
        size_error=seen["size_error"],
        diameter=seen["diameter"],
        new_lot=seen["new_lot"] > 0.5,
        Ra_before=seen["roughness"] * simulation.job.limits.roughness if gauged else None,
    )

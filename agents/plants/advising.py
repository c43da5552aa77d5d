"""Cost of a batch on a machine with an adviser, with the best fixed plan, and with an adviser without a model."""

from collections.abc import Callable, Mapping, Sequence
from itertools import product, repeat
from statistics import mean

import numpy as np

from agents.plants.study_machines import PARTS, StudyMachine
from grind_env.envs.job.job_simulation import JobSimulation
from grind_env.envs.job.loading import load_simulation
from grind_env.envs.job.program_outline import JobChoice
from grind_env.shop.advise.adviser import Adviser, policy_for
from grind_env.shop.advise.adviser_policy import AdviserPolicy
from grind_env.shop.advise.rehearsal import LOTS, BatchResult, Decide, advised, as_programmed, ground
from grind_env.training.baselines import EVERY, RATIOS, Programmed

EARLY = 14  #: number of first parts in which an adviser still has few readings


def answer(machine: StudyMachine, episodes: int, *_: object) -> dict[str, float]:
    """Return means of batches with the program, the best fixed plan and three advisers, on the same lots."""
    simulation = machine.simulation(PARTS)
    model = load_simulation(str(machine.program.path), str(machine.program.job), PARTS, 1.0, "measured")
    policy = policy_for(None, model)
    assert isinstance(policy, AdviserPolicy) and policy.model is not None
    alone = policy.model
    deciders: dict[str, Callable[[], Decide]] = {
        "program": lambda: as_programmed(simulation),
        "floor": lambda: advised(Adviser(model, AdviserPolicy(None))),
        "trusting": lambda: advised(Adviser(model, alone)),
        "adviser": lambda: advised(Adviser(model, policy)),
    }
    found = {who: batches(simulation, decider, episodes) for who, decider in deciders.items()}
    return means_of({"program": found.pop("program"), "plan": best_plan(simulation, episodes), **found}, simulation)


def plans(simulation: JobSimulation) -> list[Decide]:
    """Return 15 fixed plans, from which `best_plan` chooses."""
    return [_decide(Programmed(*plan), simulation) for plan in product(RATIOS, EVERY)]


def best_plan(simulation: JobSimulation, episodes: int) -> list[BatchResult]:
    """Return the batches of the fixed plan that costs least in these batches."""
    planned = [batches(simulation, repeat(plan).__next__, episodes) for plan in plans(simulation)]
    return min(planned, key=lambda found: float(np.mean([each.cost.mean() for each in found])))


def _decide(plan: Programmed, simulation: JobSimulation) -> Decide:
    plan.begin(simulation, 1)
    return lambda number, readings: JobChoice(float(plan.speeds[number]), int(plan.executions[number]))


def batches(simulation: JobSimulation, decider: Callable[[], Decide], episodes: int) -> list[BatchResult]:
    """Grind batches, each with its own decider, on the same lots."""
    return [ground(simulation, decider(), LOTS + number) for number in range(episodes)]


def numbers_of(batch: BatchResult, simulation: JobSimulation) -> dict[str, float]:
    """Return the numbers of a batch for the tables; `late` is the mean cost of a part from the 15th on, $."""
    job, lowest = simulation.job, simulation.task.action.speed_ends[0]
    power = np.array([(each.peak_power or 0.0) / job.limits.power for each in batch.readings])
    # for each part: the larger of size error and Ra over its limit, and whether E is least and the wheel is dressed
    gauged, slowest = np.zeros(simulation.parts), np.zeros(simulation.parts, bool)
    for number, (block, readings) in enumerate(zip(simulation.blocks, batch.readings, strict=True)):
        slowest[block.part] = batch.speeds[number] <= lowest and batch.executions[number] > 0
        if readings.size_error is not None and job.part.tolerance > 0.0:
            gauged[block.part] = abs(readings.size_error) / job.part.tolerance
        if readings.Ra_before is not None and block.part > 0 and job.limits.roughness > 0.0:
            gauged[block.part - 1] = max(gauged[block.part - 1], readings.Ra_before / job.limits.roughness)
    beyond, off = power > 1.0, gauged > 1.0
    return {
        "cost": float(batch.cost.mean()),
        "late": float(batch.cost[EARLY:].mean()),
        "scrap": float(batch.scrap.mean()),
        "in_a_row": float((beyond[1:] & beyond[:-1]).sum()),
        "parts_in_a_row": float((off[1:] & off[:-1] & ~slowest[1:]).sum()),
        "dresses": float(batch.executions.sum()),
    }


def means_of(found: Mapping[str, Sequence[BatchResult]], simulation: JobSimulation) -> dict[str, float]:
    """Return the means of `numbers_of` over the batches of each decider, such as `adviser_cost`."""
    numbers = {who: [numbers_of(batch, simulation) for batch in of] for who, of in found.items()}
    return {f"{who}_{what}": mean(each[what] for each in of) for who, of in numbers.items() for what in of[0]}

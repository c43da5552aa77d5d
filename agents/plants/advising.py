"""Cost of a batch on a machine with an adviser, with the best fixed plan, and with an adviser without a model."""

from collections.abc import Callable
from itertools import product, repeat

from agents.plants.batch_costs import batches, cost_of
from agents.plants.study_machines import PARTS, StudyMachine
from grind_env.envs.job.job_simulation import JobSimulation
from grind_env.envs.job.loading import load_simulation
from grind_env.envs.job.program_outline import JobChoice
from grind_env.shop.advise.adviser import Adviser, policy_for
from grind_env.shop.advise.adviser_policy import AdviserPolicy
from grind_env.shop.advise.rehearsal import BatchResult, Decide, advised, as_programmed
from grind_env.training.baselines import EVERY, RATIOS, Programmed


def advise_on(machine: StudyMachine, episodes: int) -> dict[str, list[BatchResult]]:
    """Return batches with the program, the best fixed plan and three advisers, on the same lots."""
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
    return {"program": found.pop("program"), "plan": best_plan(simulation, episodes), **found}


def plans(simulation: JobSimulation) -> list[Decide]:
    """Return 15 fixed plans, from which `best_plan` chooses."""
    return [_decide(Programmed(*plan), simulation) for plan in product(RATIOS, EVERY)]


def best_plan(simulation: JobSimulation, episodes: int) -> list[BatchResult]:
    """Return the batches of the fixed plan that costs least in these batches."""
    planned = [batches(simulation, repeat(plan).__next__, episodes) for plan in plans(simulation)]
    return min(planned, key=cost_of)


def _decide(plan: Programmed, simulation: JobSimulation) -> Decide:
    plan.begin(simulation, 1)
    return lambda number, readings: JobChoice(float(plan.speeds[number]), int(plan.executions[number]))

"""What an adviser makes of a batch on a machine, beside the best of fixed plans and an adviser without a model."""

from collections.abc import Callable

from agents.plants.floor import ModelFreeAdviser
from agents.plants.machines import StudyMachine
from agents.plants.plans import best_plan
from agents.plants.shift import PARTS, BatchResult, Decide, batches
from grind_env.envs.job.loading import load_simulation
from grind_env.envs.job.outline import JobChoice
from grind_env.envs.job.simulation import JobSimulation
from grind_env.policies.guard import Guarded
from grind_env.policies.policy import Policy
from grind_env.shop.advise.adviser import Adviser, policy_for
from grind_env.shop.advise.readings import Readings


def advised(model: JobSimulation, policy: Policy) -> Decide:
    """What `grind advise` says, which is followed."""
    adviser = Adviser(model, policy)

    def decide(number: int, readings: Readings | None) -> JobChoice:
        if readings is not None:
            adviser.take(readings)
        assert adviser.advice is not None
        return JobChoice(adviser.advice.speed, adviser.advice.executions)

    return decide


def advise_on(machine: StudyMachine, episodes: int, parts: int = PARTS) -> dict[str, list[BatchResult]]:
    """Batches with the adviser, with the one without a model, and with the best fixed plan, on the same lots."""
    simulation = machine.simulation(parts)
    model = load_simulation(str(machine.program.path), str(machine.program.job), parts, 1.0, "measured")
    deciders: dict[str, Callable[[], Decide]] = {
        "program": lambda: lambda k, _: JobChoice(*own(simulation, k)),
        "floor": lambda: ModelFreeAdviser(model),
        "trusting": lambda: advised(model, trusting(model)),
        "adviser": lambda: advised(model, policy_for(None, model)),
    }
    found = {who: batches(simulation, decider, episodes) for who, decider in deciders.items()}
    return {"program": found.pop("program"), "plan": best_plan(simulation, episodes), **found}


def trusting(model: JobSimulation) -> Policy:
    """The default policy without its guard."""
    policy = policy_for(None, model)
    return policy.policy if isinstance(policy, Guarded) else policy


def own(simulation: JobSimulation, number: int) -> tuple[float, int]:
    """E and D of the program itself."""
    plan = simulation.blocks[number].plan
    return plan.feed, int(plan.dresses)

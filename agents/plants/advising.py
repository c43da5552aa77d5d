"""What an adviser makes of a batch on a machine, beside the best of fixed plans and an adviser without a model."""

from collections.abc import Callable

from agents.plants.floor import ModelFreeAdviser
from agents.plants.machines import PARTS, StudyMachine
from agents.plants.plans import best_plan
from grind_env.envs.job.loading import load_simulation
from grind_env.shop.advise.adviser import Adviser, policy_for
from grind_env.shop.advise.lead import AdviserPolicy
from grind_env.shop.advise.rehearsal import BatchResult, Decide, advised, as_programmed, batches


def advise_on(machine: StudyMachine, episodes: int, parts: int = PARTS) -> dict[str, list[BatchResult]]:
    """Grind batches with the adviser, with the one without a model, and by the best fixed plan, on the same lots."""
    simulation = machine.simulation(parts)
    model = load_simulation(str(machine.program.path), str(machine.program.job), parts, 1.0, "measured")
    policy = policy_for(None, model)
    assert isinstance(policy, AdviserPolicy) and policy.model is not None
    alone = policy.model
    deciders: dict[str, Callable[[], Decide]] = {
        "program": lambda: as_programmed(simulation),
        "floor": lambda: ModelFreeAdviser(model),
        "trusting": lambda: advised(Adviser(model, alone)),
        "adviser": lambda: advised(Adviser(model, policy)),
    }
    found = {who: batches(simulation, decider, episodes) for who, decider in deciders.items()}
    return {"program": found.pop("program"), "plan": best_plan(simulation, episodes), **found}

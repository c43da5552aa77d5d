"""What an adviser makes of a batch on a machine, beside the best of fixed plans and an adviser without a model."""

from agents.plants.floor import Floor
from agents.plants.machines import PARTS, Machine
from agents.plants.plans import plans
from grind_env.envs.job.loading import load_simulation
from grind_env.shop.advise.adviser import Adviser, policy_for
from grind_env.shop.advise.lead import AdviserPolicy
from grind_env.shop.advise.rehearsal import Shift, advised, as_programmed, ground


def advise_on(machine: Machine, parts: int = PARTS) -> dict[str, Shift]:
    """Grind a batch with the adviser, with the one without a model, and by the best fixed plan, on the same lots."""
    simulation = machine.simulation(parts)
    model = load_simulation(str(machine.program.path), str(machine.program.job), parts, 1.0, "measured")
    policy = policy_for(None, model)
    assert isinstance(policy, AdviserPolicy) and policy.model is not None
    planned = [ground(simulation, plan) for plan in plans(simulation)]
    return {
        "program": ground(simulation, as_programmed(simulation)),
        "plan": min(planned, key=lambda shift: shift.mean_cost),
        "floor": ground(simulation, Floor(model)),
        "trusting": ground(simulation, advised(Adviser(model, policy.model))),
        "adviser": ground(simulation, advised(Adviser(model, policy))),
    }

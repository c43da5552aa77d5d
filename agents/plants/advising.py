"""What an adviser makes of a batch on a machine, beside the best of fixed plans and an adviser without a model."""

from agents.benchmark.plan import PUBLIC, ROBUST
from agents.plants.floor import Floor
from agents.plants.machines import Machine, Program
from agents.plants.plans import plans
from agents.plants.shift import PARTS, Choice, Decide, Shift, ground
from grind_env.envs.job.loading import load_simulation
from grind_env.envs.job.simulation import JobSimulation
from grind_env.policies.guard import Guarded
from grind_env.policies.held import on
from grind_env.policies.learned.saved import load_policy
from grind_env.policies.policy import Policy
from grind_env.policies.problem import find_problem
from grind_env.shop.advise.adviser import Adviser, policy_for
from grind_env.shop.advise.readings import Readings


def advised(model: JobSimulation, policy: Policy) -> Decide:
    """What `grind advise` says, which is followed."""
    adviser = Adviser(model, policy)

    def decide(number: int, readings: Readings | None) -> Choice:
        if readings is not None:
            adviser.take(readings)
        assert adviser.advice is not None
        return Choice(adviser.advice.speed, adviser.advice.executions)

    return decide


def advise_on(machine: Machine, parts: int = PARTS) -> dict[str, Shift]:
    """A batch with the adviser, a robust agent, one without a model, and the best fixed plan, on the same lots."""
    simulation = machine.simulation(parts)
    model = load_simulation(str(machine.program.path), str(machine.program.job), parts, 1.0, "measured")
    planned = [ground(simulation, plan) for plan in plans(simulation)]
    return {
        "program": ground(simulation, lambda k, _: Choice(*own(simulation, k))),
        "plan": min(planned, key=lambda shift: shift.mean_cost),
        "floor": ground(simulation, Floor(model)),
        "trusting": ground(simulation, advised(model, trusting(model))),
        "adviser": ground(simulation, advised(model, policy_for(None, model))),
        "robust": ground(simulation, advised(model, robust(machine.program, model, parts))),
    }


def trusting(model: JobSimulation) -> Policy:
    """The default policy without its guard."""
    policy = policy_for(None, model)
    return policy.policy if isinstance(policy, Guarded) else policy


def robust(program: Program, model: JobSimulation, parts: int) -> Policy:
    """A GRU that was trained for the program on public machines of all families, one in every batch; it is kept."""
    from agents.learning.plain import plain_agent  # torch takes seconds to load

    problem = find_problem(str(program.path), str(program.job), parts)
    return load_policy(plain_agent(on(problem, PUBLIC), ROBUST, "gru", 0, fresh=False), simulation=model)


def own(simulation: JobSimulation, number: int) -> tuple[float, int]:
    """E and D of the program itself."""
    plan = simulation.blocks[number].plan
    return plan.feed, int(plan.dresses)

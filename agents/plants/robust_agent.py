"""Cost of a batch with an agent that was trained for the program on other machines of all families."""

from pathlib import Path

from agents.benchmark.agent_training import plain_agent
from agents.benchmark.plan import PUBLIC, ROBUST
from agents.plants.advising import best_plan
from agents.plants.batch_costs import batches
from agents.plants.study_machines import PARTS, StudyMachine
from grind_env.envs.job.loading import load_simulation
from grind_env.policies.learned.saved import load_policy
from grind_env.policies.nominal_model import on
from grind_env.policies.problem_lookup import find_problem
from grind_env.shop.advise.adviser import Adviser
from grind_env.shop.advise.rehearsal import BatchResult, advised
from grind_env.training.gru_ppo import Settings


def robust_on(machine: StudyMachine, folder: Path, episodes: int) -> dict[str, list[BatchResult]]:
    """Return batches with a robust agent in `grind advise`, and with the best fixed plan, on the same lots.

    The agent is trained on public machines, another one in every batch, unless its file is in the folder.
    """
    program, job = (str(path.absolute()) for path in machine.program.files)
    problem = find_problem(program, job, PARTS)
    agent = plain_agent(on(problem, PUBLIC), ROBUST, Settings(), 0, folder)
    simulation, model = machine.simulation(PARTS), load_simulation(program, job, PARTS, 1.0, "measured")
    robust = batches(simulation, lambda: advised(Adviser(model, load_policy(agent, simulation=model))), episodes)
    return {"plan": best_plan(simulation, episodes), "robust": robust}

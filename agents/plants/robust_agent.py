"""Cost of a batch with an agent that was trained for the program on other machines of all families."""

from pathlib import Path

from agents.benchmark.agent_training import plain_agent
from agents.benchmark.plan import PUBLIC, ROBUST
from agents.plants.advising import batches, best_plan, means_of
from agents.plants.study_machines import PARTS, StudyMachine
from grind_env.envs.job.loading import load_simulation
from grind_env.policies.learned.saved import load_policy
from grind_env.policies.nominal_model import on
from grind_env.policies.problem_lookup import find_problem
from grind_env.shop.advise.adviser import Adviser
from grind_env.shop.advise.rehearsal import advised
from grind_env.training.gru_ppo import Settings


def answer(machine: StudyMachine, episodes: int, runs: Path) -> dict[str, float]:
    """Return means of batches with a robust agent in `grind advise`, and with the best fixed plan, on the same lots.

    The agent is trained on public machines, another one in every batch, unless its file is in the folder `runs`.
    """
    program, job = (str(path.absolute()) for path in machine.program.files)
    problem = find_problem(program, job, PARTS)
    agent = plain_agent(on(problem, PUBLIC), ROBUST, Settings(), 0, runs)
    simulation, model = machine.simulation(PARTS), load_simulation(program, job, PARTS, 1.0, "measured")
    robust = batches(simulation, lambda: advised(Adviser(model, load_policy(agent, simulation=model))), episodes)
    return means_of({"plan": best_plan(simulation, episodes), "robust": robust}, simulation)

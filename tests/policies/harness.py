"""Helpers that the tests of policies share."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from agents.tuning.tunable_parameters import RULES, from_vector, vector_size
from grind_env.envs.blocks.task_simulation import BlockSimulation
from grind_env.envs.simulation import Simulation
from grind_env.envs.tasks import Task, load_task
from grind_env.policies.learned.agent_spaces import LearnerForm
from grind_env.policies.learned.network import Network
from grind_env.policies.planners.known_state import ModelPredictive
from grind_env.policies.policy import Policy
from grind_env.policies.problem_lookup import Problem, find_problem
from grind_env.policies.registry import TUNED, UNIFORM_PLANS, UNTUNED
from grind_env.policies.tuned_parameters import arguments


def simulated(task: str) -> Simulation:
    """Return the simulation of a task with measured observations."""
    return BlockSimulation(load_task(task))


def observation(simulation: Simulation, **values: float) -> NDArray[np.float32]:
    """Return one scaled observation of these readings in physical units; other readings are 0."""
    return np.array([[(values.get(e.name, 0.0) - e.offset) / e.scale for e in simulation.entries]], np.float32)


def decide(policy: Policy, simulation: Simulation, *observations: Any) -> list[tuple[float, float]]:
    """Return E (mm/min) and D of one episode after each of its observations."""
    policy.begin(simulation, 1)
    decisions = [policy.act(seen, None) for seen in observations]
    return [(float(d.speeds[0]), float(d.executions[0])) for d in decisions]


@dataclass(frozen=True)
class Changed(Problem):
    """Problem with another task than the task of its name."""

    task: Task | None = None

    def simulation(self) -> Simulation:
        assert self.task is not None
        whole = Problem(self.name, self.id, self.arguments).simulation()
        return type(whole)(self.task)


def changed(problem: Problem, **fields: Any) -> Problem:
    """Return the problem with a task that differs in these fields."""
    return Changed(problem.name, problem.id, problem.arguments, replace(problem.simulation().task, **fields))


def shortened(name: str, blocks: int) -> Simulation:
    """Return the simulation of a problem with fewer blocks."""
    whole = find_problem(name).simulation()
    return type(whole)(replace(whole.task, blocks=blocks))


def network_of(
    simulation: Simulation, form: LearnerForm, *, lstm: int = 0, hidden: tuple[int, ...] = (128, 128)
) -> Network:
    """Return a network for a simulation."""
    view = form.view(simulation)
    entries, outputs = view.observation_space.shape[0], int(view.action_space.nvec.sum())
    return Network(family="gru", entries=entries, lstm=lstm, hidden=hidden, outputs=outputs, activation="tanh")


def untuned(name: str, simulation: Simulation) -> Any:
    """Return the named policy with the start parameters of its tuning."""
    if name in UNTUNED:
        return UNTUNED[name]()
    if name in UNIFORM_PLANS:
        return TUNED[name](E=12_000.0, D=1, every=2)
    if name == "mpc":
        return ModelPredictive(untuned("full_state_rule", simulation), horizon=2)
    coefficients = RULES[name]
    start = np.zeros(vector_size(coefficients, simulation.task))
    return TUNED[name](**arguments(from_vector(coefficients, simulation.task, start)))

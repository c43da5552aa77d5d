"""What a learned agent does over what it believes of the wheel: maps of E and D."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from grind_env.arrays import Array
from grind_env.envs.episodes import Episodes
from grind_env.envs.memory import belief_entries
from grind_env.envs.simulation import Simulation
from grind_env.errors import GrindError
from grind_env.policies.choices import Decision
from grind_env.policies.evaluation import episode_seeds, run_seeds
from grind_env.policies.learned.network import LearnedPolicy, best_actions
from grind_env.policies.learned.view import FEATURE_BOUND, LEAST_AREA
from grind_env.policies.naming import chosen_policy
from grind_env.policies.policy import Policy, Sees
from grind_env.policies.problem import Problem, find_problem
from grind_env.policies.scripted.rules import REFERENCE_AREA
from grind_env.render.figures import new_figure
from grind_env.render.style import PAGE, paper_style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

HEIGHT = 2.7
"""in."""
GRID = 80
"""Points along each side of a map."""
SHARE = 0.5
"""% of the visited states that lie beyond each end of an axis."""
MOST_MARKED = 400
"""Visited states that are marked."""
NAMES = tuple(entry.name for entry in belief_entries())
AREA, GROWTH = NAMES.index("belief_wear_flat"), NAMES.index("belief_growth")


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class PolicyMap:
    """E, m/min, and D of an agent, shape (growths, areas); `visited` are states that it got into, shape (states, 2)."""

    policy: str
    problem: str
    areas: Array
    growths: Array
    speeds: Array
    executions: Array
    visited: Array


class _Recorder:
    """An agent that is watched: what it sees before each block."""

    sees: Sees = "measurements"

    def __init__(self, agent: LearnedPolicy) -> None:
        self.agent, self.name = agent, agent.name
        self.features: list[NDArray[np.float32]] = []

    def begin(self, simulation: Simulation, episodes: int) -> None:
        self.agent.begin(simulation, episodes)

    def act(self, observation: NDArray[np.float32], episodes: Episodes | None) -> Decision:
        self.features.append(self.agent.view.features(observation))
        return _decision(self.agent, self.features[-1])


def policy_map(policy: Policy | str | None, problem: Problem | str, *, episodes: int = 32) -> PolicyMap:
    """Ask an agent for E and D on a grid of beliefs.

    Everything else that it sees is what goes with these two numbers on average: the linear regression of each feature
    on them, over the states of some evaluation episodes. In a task with several kinds of block it is a mixture of them.

    Raises:
        GrindError: there is no such problem or policy, or the policy is no agent that sees a belief alone.
    """
    problem = problem if isinstance(problem, Problem) else find_problem(problem)
    simulation = problem.simulation()
    agent = chosen_policy(policy, simulation) if policy is None or isinstance(policy, str) else policy
    if not isinstance(agent, LearnedPolicy) or agent.actor.network.lstm or agent.form.memory != "belief":
        raise GrindError(
            f"{agent.name} has no map over a belief: name a learned agent that sees one and remembers nothing else"
        )
    watched = _Recorder(agent)
    run_seeds(watched, simulation, episode_seeds("evaluation", episodes))
    seen = np.concatenate(watched.features).astype(np.float64)
    first = seen.shape[1] - len(NAMES) - 1
    scale = belief_entries()[AREA].scale
    visited = np.stack([scale * seen[:, first + AREA], seen[:, first + GROWTH]], axis=1)
    ends = np.percentile(visited, [SHARE, 100.0 - SHARE], axis=0)
    areas, growths = (np.linspace(low, high, GRID) for low, high in ends.T)
    places = np.stack([each.ravel() for each in np.meshgrid(areas, growths)], axis=1)
    features = _with_one(places) @ np.linalg.lstsq(_with_one(visited), seen, rcond=None)[0]
    features = np.clip(features, seen.min(axis=0), seen.max(axis=0))
    features[:, first + AREA], features[:, first + GROWTH] = places[:, 0] / scale, places[:, 1]
    features[:, -1] = np.log(np.maximum(places[:, 0], LEAST_AREA) / REFERENCE_AREA)
    decided = _decision(agent, np.clip(features, -FEATURE_BOUND, FEATURE_BOUND).astype(np.float32))
    shape = GRID, GRID
    return PolicyMap(
        policy=agent.name,
        problem=problem.name,
        areas=areas,
        growths=growths,
        speeds=0.001 * decided.speeds.reshape(shape),
        executions=decided.executions.reshape(shape),
        visited=visited,
    )


def policy_map_figure(found: PolicyMap) -> "Figure":
    """Draw E and D side by side, with states that the agent got into as dots."""
    with paper_style():
        from matplotlib.colors import BoundaryNorm
        from matplotlib.ticker import MaxNLocator

        figure = new_figure(PAGE, HEIGHT)
        left, right = figure.subplots(1, 2, sharex=True, sharey=True)
        x, y = 100.0 * found.areas, np.exp(found.growths)
        levels = MaxNLocator(8).tick_values(found.speeds.min(), found.speeds.max())
        filled = left.contourf(x, y, found.speeds, levels=levels, cmap="cividis")
        left.contour(x, y, found.speeds, levels=levels, colors="white", linewidths=0.4)
        figure.colorbar(filled, ax=left, label="E, m/min")
        numbers = np.arange(found.executions.max() + 2.0) - 0.5
        shades = right.pcolormesh(
            x, y, found.executions, cmap="cividis_r", norm=BoundaryNorm(numbers, 256), rasterized=True
        )
        figure.colorbar(shades, ax=right, label="D, dress executions", ticks=numbers[:-1] + 0.5)
        marked = found.visited[:: max(len(found.visited) // MOST_MARKED, 1)]
        for axes in (left, right):
            axes.plot(100.0 * marked[:, 0], np.exp(marked[:, 1]), ".", ms=2.0, mfc="white", mec="black", mew=0.25)
            axes.set(xlim=(x[0], x[-1]), ylim=(y[0], y[-1]), xlabel="believed wear-flat area, %")
        left.set_ylabel("believed factor on its growth")
    return figure


def _with_one(places: Array) -> Array:
    return np.column_stack([places, np.ones(len(places))])


def _decision(agent: LearnedPolicy, features: NDArray[np.float32]) -> Decision:
    values, _ = agent.actor.outputs(features, agent.actor.begin(len(features)))
    return agent.view.decide(best_actions(agent.view.action_space, values))

"""How good an agent in training is, on validation episodes."""

import numpy as np
from numpy.typing import NDArray
from stable_baselines3.common.base_class import BaseAlgorithm

from grind_env.envs.episodes import Episodes
from grind_env.envs.simulation import Simulation
from grind_env.errors import GrindError
from grind_env.policies.choices import Decision
from grind_env.policies.evaluation import episode_seeds, roll_out, run_seeds, start_episodes
from grind_env.policies.held import model_beside
from grind_env.policies.learned.view import Actions, LearnerView, MemoryKind
from grind_env.policies.policy import Policy, Sees
from grind_env.policies.problem import Problem
from grind_env.policies.registry import FIXED_PLANS, make_policy, policy_names
from grind_env.scores import reference

EPISODES = 64


class LiveAgent:
    """An agent in training as a policy that takes its most likely action."""

    sees: Sees = "measurements"

    def __init__(self, model: BaseAlgorithm, memory: MemoryKind, actions: Actions) -> None:
        self.name = "agent in training"
        self.model, self.memory, self.actions = model, memory, actions

    def begin(self, simulation: Simulation, episodes: int) -> None:
        """That many episodes begin."""
        self.view = LearnerView(simulation, self.memory, self.actions)
        self.view.begin(episodes)
        self.first = np.ones(episodes, bool)
        self.state: tuple[NDArray[np.float32], ...] | None = None

    def act(self, observation: NDArray[np.float32], episodes: Episodes | None) -> Decision:
        """Decide the coming block."""
        features = self.view.features(observation)
        actions, self.state = self.model.policy.predict(features, self.state, self.first, deterministic=True)
        self.first = np.zeros(len(observation), bool)
        return self.view.decide(np.asarray(actions))


class Validation:
    """Scores an agent on validation episodes.

    Args:
        problem: what is ground.
        episodes: how many.
    """

    def __init__(self, problem: Problem, episodes: int = EPISODES) -> None:
        self.simulation, self.seeds = problem.simulation(), episode_seeds("validation", episodes)
        self.fixed, self.least, self.model = np.nan, np.nan, model_beside(problem)
        if self.model is not None:
            return
        try:
            scale = reference(problem.id)
            names = [name for name in policy_names(self.simulation) if name in FIXED_PLANS]
            plans = [make_policy(name, self.simulation) for name in names]
        except GrindError:
            return
        self.fixed = min(float(run_seeds(plan, self.simulation, self.seeds).cost.mean()) for plan in plans)
        self.least = self.fixed * scale.J_plan / scale.J_fix

    def score(self, agent: Policy) -> tuple[float, float]:
        """Mean cost of an episode in $, and an estimate of the normalised score.

        The fixed plan is run on the same episodes. What the planner, too slow for that, would save of its cost is taken
        from the reference scores; the score is NaN in a problem that has none, and on machines that are not
        the model.
        """
        begun = start_episodes(self.simulation, self.seeds)
        cost = float(roll_out(agent, self.simulation, begun, self.model).cost.mean())
        return cost, 100.0 * (self.fixed - cost) / (self.fixed - self.least)

"""The environment in which agents are trained, and what it notes meanwhile: costs, decisions, and time spent."""

import time
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray
from stable_baselines3.common.vec_env.base_vec_env import VecEnvObs, VecEnvStepReturn

from grind_env.arrays import Table
from grind_env.envs.learning import WORST_REWARD, eased
from grind_env.envs.tables import Outcome, reward_terms
from grind_env.envs.tasks import Task
from grind_env.envs.vector_env import GrindVectorEnv
from grind_env.policies.held import model_beside
from grind_env.policies.learned.view import FORMS, Actions, LearnerView, MemoryKind
from grind_env.policies.problem import Problem
from grind_env.sb3.adapter import SB3VecEnv

BURN, COST, FINISHED, GOOD = (Outcome._fields.index(name) for name in ("burn_ratio", "cost", "finished", "good"))
BURNT = 1.0
"""Burn ratio above which a block has burnt."""


@dataclass(slots=True)
class Notes:
    """What has been noted since the notes were last taken."""

    blocks: int = 0
    totals: Table = field(default_factory=lambda: np.zeros(len(Outcome._fields)))
    """Sum of every field of `Outcome`."""
    burnt: int = 0
    speeds: list[Table] = field(default_factory=list)
    """E of every block, mm/min."""
    executions: list[Table] = field(default_factory=list)
    """D of every block."""

    def note(self, outcomes: Table, choice: tuple[Table, ...]) -> None:
        """Note a step of all environments."""
        self.blocks += len(outcomes)
        self.totals += outcomes.sum(axis=0)
        self.burnt += int(np.count_nonzero(outcomes[:, BURN] > BURNT))
        self.speeds.append(choice[0])
        self.executions.append(choice[1])

    def metrics(self, task: Task) -> dict[str, float]:
        """Means by name: terms of the reward a block, $ a finished part, decisions, shares of blocks and parts."""
        blocks, finished = max(self.blocks, 1), max(self.totals[FINISHED], 1.0)
        terms = reward_terms(task)
        speeds, executions = np.concatenate(self.speeds) / 1000.0, np.concatenate(self.executions)
        return {
            **{f"reward/{name}": -float(self.totals[k]) / blocks / task.reference_cost for name, k in terms.items()},
            "cost/part": float(self.totals[COST] / finished),
            "parts/scrap_share": float(1.0 - self.totals[GOOD] / finished),
            "blocks/burnt_share": self.burnt / blocks,
            "actions/E_mean": float(speeds.mean()),
            "actions/E_deviation": float(speeds.std()),
            "actions/D_mean": float(executions.mean()),
            "actions/dress_share": float((executions > 0.0).mean()),
        }


class LearnerVecEnv(SB3VecEnv):
    """N episodes of a problem as a learner sees them, with a reward made easier to learn.

    Args:
        problem: what is ground.
        envs: number of episodes side by side.
        memory: what the features remember.
        actions: form of the actions.
        split: that the contexts of all episodes are drawn from.
        worst_reward: rewards below are cut, so that one scrapped part does not drown an update.
    """

    env: GrindVectorEnv

    def __init__(
        self,
        problem: Problem,
        envs: int,
        memory: MemoryKind = "belief",
        actions: Actions = "grid",
        split: str = "inner",
        worst_reward: float = WORST_REWARD,
    ) -> None:
        env = problem.make_vec(envs, action=FORMS[actions], autoreset_mode="SameStep")
        # it holds for all later episodes
        env.reset(options={"split": split})
        self.notes = Notes()
        self.view = LearnerView(model_beside(problem) or env.simulation, memory, actions)
        self.worst_reward = worst_reward
        self.seconds = {"environment": 0.0, "features": 0.0}
        """Wall time spent in steps of the environment, and on the features."""
        super().__init__(env)
        self.observation_space = self.view.observation_space
        self.action_space = self.view.action_space

    def reset(self) -> VecEnvObs:
        """Start an episode in every environment."""
        observations = super().reset()
        self.view.begin(self.num_envs)
        return self.view.features(np.asarray(observations))

    def step_wait(self) -> VecEnvStepReturn:
        """Step. The reward is one more than the environment's, so that the best fixed plan earns about 0."""
        begin = time.perf_counter()
        observations, rewards, done, infos = super().step_wait()
        self.notes.note(*self.env.last)
        stepped = time.perf_counter()
        features = self._features(np.asarray(observations), done, infos)
        self.seconds["environment"] += stepped - begin
        self.seconds["features"] += time.perf_counter() - stepped
        return features, eased(rewards, self.worst_reward), done, infos

    def take_notes(self) -> Notes:
        """The notes, which begin anew."""
        notes, self.notes = self.notes, Notes()
        return notes

    def _features(
        self, observations: NDArray[np.float32], done: NDArray[np.bool_], infos: list[dict[str, Any]]
    ) -> NDArray[np.float32]:
        """The features, and those of the last observation of the episodes that are over, which begin anew."""
        if not done.any():
            return self.view.features(observations)
        last = observations.copy()
        for i in np.flatnonzero(done):
            last[i] = infos[i]["terminal_observation"]
        features = self.view.features(last)
        for i in np.flatnonzero(done):
            infos[i]["terminal_observation"] = features[i].copy()
        self.view.restart(done)
        features[done] = self.view.features(observations, done)[done]
        return features

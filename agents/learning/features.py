"""How a learning agent sees a task and how it acts.

It sees the measured observation and, beside it, the estimates of sharpness and lot severity that the scripted
rules use; memory of the lot is what a single observation lacks. It acts on a grid: E in geometric steps and D, as
`MultiDiscrete`, because a policy over whole numbers of dresses should not be a Gaussian.
"""

from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray
from stable_baselines3.common.vec_env.base_vec_env import VecEnvObs, VecEnvStepReturn

from agents.learning.sb3_adapter import SB3VecEnv
from agents.policy import Array, Decision, speed_grid
from agents.scripted.estimator import MEMORY, LotMemory, SharpnessEstimator
from agents.scripted.rules import REFERENCE_AREA
from grind_env.envs.observations import bounds, readings
from grind_env.envs.tasks import Task
from grind_env.envs.vector_env import GrindVectorEnv

SPEEDS = 24
"""Steps of E over the speed range of a task: about 10 % each where it spans a decade."""

ESTIMATES = 4
"""Features beside the measured observation."""

FEATURE_BOUND = 30.0

BLOCKS_KNOWN = LotMemory._fields.index("blocks")


class LearnerView:
    """Features and action grid of N episodes of a task."""

    def __init__(self, task: Task) -> None:
        self.estimator = SharpnessEstimator(task)
        self.speeds: Array = speed_grid(task, SPEEDS)
        self.action_space = spaces.MultiDiscrete([len(self.speeds), task.action.executions + 1])
        entries = len(bounds(readings(task, full=False))[0])
        self.observation_space = spaces.Box(-FEATURE_BOUND, FEATURE_BOUND, (entries + ESTIMATES,), np.float32)

    def begin(self, n: int) -> None:
        """N episodes begin."""
        self.estimator.begin(n)

    def restart(self, mask: NDArray[np.bool_]) -> None:
        """The episodes in `mask`, shape (N,), begin anew."""
        self.estimator.restart(mask)

    def features(self, observation: NDArray[np.float32]) -> NDArray[np.float32]:
        """Features, shape (N, entries + ESTIMATES), of the measured observation before a block."""
        estimate = self.estimator.update(observation)
        extra = np.stack(
            [
                np.log(estimate.wear_flat / REFERENCE_AREA),
                estimate.severity,
                np.minimum(self.estimator.memory[:, BLOCKS_KNOWN], MEMORY) / MEMORY,
                np.log1p(estimate.volume / 50.0),
            ],
            axis=1,
        )
        return np.concatenate([observation, extra.astype(np.float32)], axis=1)

    def decide(self, actions: NDArray[np.int64]) -> Decision:
        """E in mm/min and D of grid actions, shape (N, 2)."""
        return Decision(self.speeds[actions[:, 0]], actions[:, 1].astype(np.float64))


class LearnerVecEnv(SB3VecEnv):
    """The training environment: features, grid actions, and a reward made easier to learn.

    Args:
        env: vector environment in SAME_STEP mode.
        worst_reward: rewards below are cut, so that one scrapped part does not drown an update.
    """

    def __init__(self, env: GrindVectorEnv, worst_reward: float) -> None:
        self.view = LearnerView(env.task)
        self.worst_reward = worst_reward
        super().__init__(env)
        self.observation_space = self.view.observation_space
        self.action_space = self.view.action_space

    def reset(self) -> VecEnvObs:
        """Start an episode in every environment."""
        observations = super().reset()
        self.view.begin(self.num_envs)
        return self.view.features(np.asarray(observations))

    def step_async(self, actions: NDArray[Any]) -> None:
        """Keep the actions for `step_wait`, as the environment wants them."""
        decision = self.view.decide(actions)
        super().step_async(self.env.codec.encode(decision.speeds, decision.executions))

    def step_wait(self) -> VecEnvStepReturn:
        """Step. The reward is one more than the environment's, so that the best fixed plan earns about 0."""
        observations, rewards, done, infos = super().step_wait()
        for i in np.flatnonzero(done):
            last = infos[i]["terminal_observation"]
            infos[i]["terminal_observation"] = np.concatenate([last, np.zeros(ESTIMATES, np.float32)])
        self.view.restart(done)
        return (
            self.view.features(np.asarray(observations)),
            np.maximum(rewards + np.float32(1.0), np.float32(self.worst_reward)),
            done,
            infos,
        )

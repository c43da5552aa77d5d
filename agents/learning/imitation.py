"""Behaviour cloning of the planner, and PPO that goes on from there.

The expert sees the true episode, the student what a machine measures, so the student cannot do as the expert does: it
can only learn what is best on average where its measurements are the same. After the first round the student
grinds the episodes, and the expert says what it would have done (DAgger: Ross, Gordon, Bagnell, AISTATS 2011), so that
the student is taught in the states that it gets into.

Of every choice of the grid the planner says what it would cost, and the student is fitted to what its own choices are
expected to cost (AggreVaTe: Ross, Bagnell, arXiv:1406.5979, 2014): what is best on average may be nobody's best choice,
and a slip that scraps a part is worse than one that costs a second. A fit of that alone gets stuck early, so it begins
as a fit to the probabilities exp(-cost / temperature).

With foresight the costs are those of the stocks, lots and due dates that do come. The student, who cannot see them,
learns the mean over all futures, and that can be much more than the cost of the mean future: a late order costs, an
early one earns nothing. Where the two are alike, the cost of the mean future is the better label, for it varies less.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import torch
from gymnasium import spaces
from numpy.typing import NDArray
from stable_baselines3 import PPO
from stable_baselines3.common.buffers import RolloutBuffer
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.vec_env import VecEnv

from agents.learning.training_env import LearnerVecEnv
from grind_env.arrays import Array
from grind_env.envs.episodes import Episodes
from grind_env.envs.simulation import Simulation
from grind_env.envs.tasks import Task
from grind_env.policies.choices import Decision, all_choices
from grind_env.policies.planners.known_state import FullStateRule, ModelPredictive
from grind_env.policies.policy import reveal
from grind_env.policies.tuned import ConfigError, tuned_arguments

Loss = Callable[[torch.Tensor, torch.Tensor, float], torch.Tensor]
"""Of features, targets and the share of the fit that is done."""

BATCH = 1024
EPOCHS = 30
LEARNING_RATE = 1e-3
"""Of cloning; it falls linearly."""
LAST_RATE = 0.02
"""Its last share."""
COST_WEIGHT = 20.0
"""Weight of the expected cost, which grows from 0, beside the cross-entropy, whose weight falls from 1."""
LEAST_CROSS_ENTROPY = 0.1
"""It ends here, so that the student stays soft enough to explore."""
WORST = 10.0
"""Costs of a block above the best choice that are told apart."""
GREEDY = 0.5
"""Share of the student's decisions in its own episodes that are its likeliest ones; it draws the others."""


@dataclass
class CostPlanner(ModelPredictive):
    """The planner, asked for the cost of every choice instead of the cheapest."""

    def costs(self, episodes: Episodes, choices: Decision) -> Array:
        """$ up to the horizon of every choice for the coming block.

        Args:
            episodes: N of them, as `reveal` shows them to a planner.
            choices: E and D, each shape (choices,).

        Returns:
            Shape (N, choices).
        """
        n, count, last = len(episodes.block), len(choices.speeds), self._last_block()
        # as the planner does: the wheel left behind is charged where the tape ends
        here = episodes.window(episodes.tape, np.arange(n), self.block, last + 1 - self.block)
        branches = here.pick(np.repeat(np.arange(n), count))
        cost = self._step(branches, Decision(*(np.tile(values, n) for values in choices)))
        for block in range(self.block + 1, last + 1):
            cost += self._step(branches, self.rule.read(branches, self.simulation.task.blocks - block))
        self.block += 1
        return np.asarray(cost.reshape(n, count))


@dataclass
class Teacher:
    """Says how good every choice would have been.

    Args:
        simulation: of what is ground.
        levels: number of levels of E on the student's grid.
        horizon: blocks that the planner looks ahead; 0 for the rule on the true state, which is quick.
        temperature: of the labels, in costs of a block of the best fixed plan.
        foresight: whether it foresees what comes, or expects what the state lets one expect.
    """

    simulation: Simulation
    levels: int
    horizon: int
    temperature: float
    foresight: bool
    rule: FullStateRule = field(init=False)
    task: Task = field(init=False)

    def __post_init__(self) -> None:
        self.task = self.simulation.task
        self.rule = FullStateRule(**tuned_arguments("full_state_rule", self.task))
        self.planner = CostPlanner(self.rule, horizon=self.horizon)
        self.choices = all_choices(self.task, self.levels)

    def begin(self, n: int) -> None:
        """N episodes begin."""
        self.planner.begin(self.simulation, n)

    def labels(self, episodes: Episodes) -> Array:
        """How much worse than the best choice every other one is, in costs of a block of the best fixed plan.

        Shape (N, levels, most executions + 1), cut at `WORST`.
        """
        shown = reveal("future" if self.foresight else "state", self.simulation, episodes)
        assert shown is not None
        if self.horizon == 0:
            return self._of_rule(self.rule.act(np.empty((0, 0), np.float32), shown))
        costs = self.planner.costs(shown, self.choices).reshape(len(shown.block), self.levels, -1)
        worse = (costs - costs.min(axis=(1, 2), keepdims=True)) / self.task.reference_cost
        return np.asarray(np.minimum(worse, WORST), np.float32)

    def _of_rule(self, decision: Decision) -> Array:
        """As if probabilities followed from costs: E between two levels has a share of each, in ln E."""
        grid = np.log(np.unique(self.choices.speeds))
        wanted = np.clip(np.log(decision.speeds), grid[0], grid[-1])
        # straight lines from 1 at a level to 0 at its neighbours
        shares = np.stack([np.interp(wanted, grid, row) for row in np.eye(len(grid))], axis=1)
        executions = np.arange(self.task.action.executions + 1.0) == decision.executions[:, None]
        likely = shares[:, :, None] * executions[:, None, :]
        worse = self.temperature * -np.log(np.maximum(likely, np.finfo(np.float64).tiny))
        return np.asarray(np.minimum(worse, WORST), np.float32)


class ClonedPPO(PPO):
    """PPO whose first steps are cloning: after them it trains as ever, and it clones only if there are no more.

    Every round of cloning grinds one episode in each environment, and then fits the actor to all that was labelled so
    far, and the critic to what the round earned.

    Args:
        policy: name of the policy class.
        env: with grid actions.
        labels: environment steps that are labelled; rounded up to whole rounds.
        horizon: see `Teacher`.
        temperature: see `Teacher`.
        foresight: 1 for a `Teacher` with foresight, else 0.
        arguments: of PPO.

    Raises:
        ConfigError: if the actions are no grid.
    """

    def __init__(
        self,
        policy: str,
        env: LearnerVecEnv,
        *,
        labels: int = 40_000,
        horizon: int = 10,
        temperature: float = 0.1,
        foresight: int = 0,
        **arguments: Any,
    ) -> None:
        if not isinstance(env.action_space, spaces.MultiDiscrete):
            raise ConfigError("cloning labels a grid of E and D: set actions to 'grid'")
        super().__init__(policy, env, **arguments)
        self.labels = labels
        levels = int(env.action_space.nvec[0])
        self.teacher = Teacher(env.env.simulation, levels, int(horizon), float(temperature), bool(foresight))
        self.features: list[Array] = []
        self.labelled: list[Array] = []
        self.returns = np.empty(0, np.float32)
        self.noise = np.random.default_rng(self.seed)

    def collect_rollouts(
        self, env: VecEnv, callback: BaseCallback, rollout_buffer: RolloutBuffer, n_rollout_steps: int
    ) -> bool:
        """Collect a round of labels, or what PPO collects."""
        if self.num_timesteps >= self.labels:
            self.features, self.labelled, self.returns = [], [], np.empty(0, np.float32)
            return super().collect_rollouts(env, callback, rollout_buffer, n_rollout_steps)
        assert isinstance(env, LearnerVecEnv)
        callback.on_rollout_start()
        features, labelled, earned = [], [], []
        self.teacher.begin(env.num_envs)
        for _ in range(self.teacher.task.blocks):
            seen = np.asarray(self._last_obs, np.float32)
            features.append(seen)
            worse = self.teacher.labels(env.env.episodes)
            labelled.append(worse)
            actions = self._draw(seen) if self.features else cheapest(worse)
            observations, rewards, dones, _ = env.step(actions)
            self._last_obs, self._last_episode_starts = np.asarray(observations), dones
            earned.append(rewards)
            self.num_timesteps += env.num_envs
            callback.update_locals(locals())
            if not callback.on_step():
                return False
        for k in reversed(range(len(earned) - 1)):
            earned[k] = earned[k] + self.gamma * earned[k + 1]
        self.features.append(np.concatenate(features))
        self.labelled.append(np.concatenate(labelled))
        self.returns = np.concatenate(earned).astype(np.float32)
        callback.on_rollout_end()
        return True

    def train(self) -> None:
        """Fit actor and critic to the labels, or update them as PPO does."""
        if not self.features:
            super().train()
            return
        named = list(self.policy.named_parameters())
        actor = [values for name, values in named if "value" not in name]
        critic = [values for name, values in named if "value" in name]
        cost = self._fit(actor, np.concatenate(self.features), np.concatenate(self.labelled), self._actor_loss)
        error = self._fit(critic, self.features[-1], self.returns, self._critic_loss)
        self.logger.record("cloning/actor_loss", cost)
        self.logger.record("cloning/critic_loss", error)

    def _fit(self, parameters: list[Any], features: Array, targets: Array, loss_of: Loss) -> float:
        """Fit parameters by Adam; the mean loss of the last epoch."""
        optimiser = torch.optim.Adam(parameters)
        n = len(features)
        batches = max(n // BATCH, 1)
        x, y = torch.as_tensor(features), torch.as_tensor(targets)
        for epoch in range(EPOCHS):
            losses = []
            for k, chosen in enumerate(np.array_split(self.noise.permutation(n), batches)):
                done = (epoch + k / batches) / EPOCHS
                for group in optimiser.param_groups:
                    group["lr"] = LEARNING_RATE * max(1.0 - done, LAST_RATE)
                rows = torch.as_tensor(chosen)
                loss = loss_of(x[rows], y[rows], done)
                optimiser.zero_grad()
                torch.autograd.backward([loss])
                optimiser.step()
                losses.append(loss.item())
        return float(np.mean(losses))

    def _actor_loss(self, features: torch.Tensor, worse: torch.Tensor, done: float) -> torch.Tensor:
        """Cross-entropy to the labels, and ever more the expected cost of what the student would do."""
        speeds, executions = self._log_probabilities(features)
        likely = torch.softmax(-worse.flatten(1) / self.teacher.temperature, dim=1).reshape(worse.shape)
        entropy = -(likely.sum(dim=2) * speeds).sum(dim=1) - (likely.sum(dim=1) * executions).sum(dim=1)
        cost = (speeds.exp()[:, None] @ worse @ executions.exp()[:, :, None])[:, 0, 0]
        return (max(1.0 - done, LEAST_CROSS_ENTROPY) * entropy + done * COST_WEIGHT * cost).mean()

    def _critic_loss(self, features: torch.Tensor, returns: torch.Tensor, done: float) -> torch.Tensor:
        return torch.nn.functional.mse_loss(self.policy.predict_values(features)[:, 0], returns)

    def _log_probabilities(self, features: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        """Of the levels of E and of every D."""
        parts: Any = self.policy.get_distribution(features).distribution
        speeds, executions = (part.logits for part in parts)
        return speeds, executions

    def _draw(self, features: Array) -> NDArray[np.int64]:
        """The student's actions, `GREEDY` of them the likeliest ones."""
        with torch.no_grad():
            known = [part.numpy() for part in self._log_probabilities(torch.as_tensor(features))]
        draws = self.noise.random((len(features), 1)) >= GREEDY
        # the largest of log probabilities with Gumbel noise is a draw
        noisy = [part + draws * self.noise.gumbel(size=part.shape) for part in known]
        return np.stack([part.argmax(axis=1) for part in noisy], axis=1)


def cheapest(worse: Array) -> NDArray[np.int64]:
    """The best choice of each label, shape (N, 2)."""
    best = worse.reshape(len(worse), -1).argmin(axis=1)
    return np.stack(np.unravel_index(best, worse.shape[1:]), axis=1)

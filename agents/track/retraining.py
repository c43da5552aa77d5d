"""Policies of the track that train `robust` further: on the log of the machine, or on a model that is fitted to it."""

from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from agents.track.learning_policies import Trained
from agents.track.model_fit import CONSTANTS, changed, fitted
from grind_env.envs.episode_state import Episodes
from grind_env.envs.space_metadata import Standard
from grind_env.envs.vector_env import GrindVectorEnv
from grind_env.policies.choices import Decision
from grind_env.policies.learned.network import LearnedPolicy, best_actions
from grind_env.policies.problem_lookup import Problem, find_problem
from grind_env.policies.track import TrackShift
from grind_env.training.gru_ppo import Agent, Settings, acting_part, likelihood, policy_of, take_over, train

MOMENT = 2  #: number of shifts after which the model is fitted and the agent trained on it
#: settings of the further training: the critic alone for 31,000 of the steps
FURTHER = Settings(steps=200_000, envs=64, learning_rate=1e-3, critic_first=8, guess=0.0)
#: settings of fine-tuning: discount per block, clip of PPO, learning rate and number of gradient steps after a shift,
#: and divergence from `robust` beyond which no step is made
GAMMA, CLIP, LEARNING_RATE, GRADIENT_STEPS, BOUND = 0.9, 0.2, 3e-4, 20, 0.1
#: temperature of the drawn actions. On eight public machines, draws at 1 cost more than the agent learned from them
TEMPERATURE = 0.3


@dataclass(frozen=True)
class FittedProblem(Problem):
    """Problem for training, with constants of its model moved by `z` standard deviations."""

    z: tuple[float, ...] = ()

    def make_vec(self, num_envs: int, **arguments: Any) -> GrindVectorEnv:
        model: Any = self.make().unwrapped
        full = arguments.pop("observation") == "full"
        return GrindVectorEnv(changed(model.simulation, np.array(self.z), full=full), num_envs, **arguments)


@dataclass
class RobustCalibrated(Trained):
    """Agent `robust`, trained further on a model that is fitted to the first shifts."""

    name: ClassVar[str] = "robust_calibrated"
    shifts: list[TrackShift] = field(default_factory=list, repr=False)

    def learn(self, shift: TrackShift) -> None:
        self.shifts.append(shift)
        if len(self.shifts) == MOMENT:
            z = fitted(self.model, self.shifts, np.zeros(len(CONSTANTS)))
            usual = find_problem(self.model.task.name)
            problem = FittedProblem(usual.name, usual.id, usual.arguments, tuple(z.tolist()))
            actor = self.agent.actor
            settings = replace(FURTHER, units=actor.network.lstm, hidden=actor.network.hidden)
            self.agent = policy_of(*train(problem, settings, 0, actor=actor), problem, "gru")


@dataclass
class FineTuned(Trained):
    """Agent `robust` with drawn actions, trained after every shift towards actions that were followed by less cost.

    The training follows the clipped policy gradient of PPO on all shifts so far, as if the present agent had drawn
    their actions. A bound limits the divergence from `robust`.
    """

    name: ClassVar[str] = "fine_tuned"
    #: observations, actions and costs of the blocks of each shift
    shifts: list[tuple[Any, ...]] = field(default_factory=list, repr=False)
    rng: np.random.Generator = field(default_factory=lambda: np.random.default_rng(0), repr=False)
    robust: Agent | None = field(default=None, repr=False)

    def act(self, observation: NDArray[np.float32], episodes: Episodes | None) -> Decision:
        agent = self.agent
        logits, agent.state = agent.actor.outputs(agent.view.features(observation), agent.state)
        # the largest is a draw from the softmax of logits / temperature
        drawn = logits + TEMPERATURE * self.rng.gumbel(size=logits.shape)
        decision: Decision = agent.view.decide(best_actions(agent.view.action_space, drawn))
        return decision

    def learn(self, shift: TrackShift) -> None:
        agent = self.agent
        self.robust = self.robust or in_torch(agent)
        cost = shift.cost / self.model.task.reference_cost
        log = shift.observations[:-1], agent.view.codec.encode(shift.speeds, shift.executions), np.float32(cost)
        self.shifts.append(log)
        learner = in_torch(agent)
        improve(learner, self.robust, *(torch.as_tensor(np.stack(each, 1)) for each in zip(*self.shifts, strict=True)))
        self.agent = replace(agent, actor=acting_part(learner, unscaled(agent)))


def unscaled(agent: LearnedPolicy) -> Standard:
    """Return the scale that leaves features unchanged."""
    return Standard((0.0,) * agent.actor.network.entries, (1.0,) * agent.actor.network.entries)


def in_torch(agent: LearnedPolicy) -> Agent:
    """Return the acting part of an agent in PyTorch, on unscaled features."""
    network, choices = agent.actor.network, agent.view.action_space.nvec.tolist()
    found = Agent(network.entries, 1, choices, Settings(units=network.lstm, hidden=network.hidden))
    take_over(found, agent.actor, unscaled(agent))
    return found


def cost_ahead(cost: Tensor) -> Tensor:
    """Return the discounted mean cost of each block and all later blocks, shape (blocks, N)."""
    ahead, later, weight = torch.zeros_like(cost), torch.zeros_like(cost[0]), 0.0
    for k in reversed(range(len(cost))):
        # a sum would be low at the end of a shift, where few blocks are ahead
        later, weight = cost[k] + GAMMA * later, 1.0 + GAMMA * weight
        ahead[k] = later / weight
    return ahead


def improve(learner: Agent, robust: Agent, seen: Tensor, actions: Tensor, cost: Tensor) -> None:
    """Make gradient steps towards the actions of N shifts that were followed by less cost.

    Args:
        learner: agent that is changed in place.
        robust: agent from which the learner must not diverge.
        seen: features before every block, shape (blocks, N, entries).
        actions: actions of every block, shape (blocks, N, 2).
        cost: cost of every block over the reference cost, shape (blocks, N).
    """
    ahead = cost_ahead(cost)
    gain = (ahead.mean() - ahead) / (ahead.std() + 1e-8)
    # the hidden state is unknown here
    shown, begun = torch.cat([seen, torch.zeros(*cost.shape, 1)], -1), torch.zeros(cost.shape)
    state = torch.zeros(1, cost.shape[1], learner.gru.hidden_size if learner.gru is not None else 0)
    with torch.no_grad():
        before = robust(shown, state, begun)[0]
        chances = likelihood(learner(shown, state, begun)[0], actions)
    optimiser = torch.optim.Adam(learner.parameters(), LEARNING_RATE)
    for _ in range(GRADIENT_STEPS):
        logs = learner(shown, state, begun)[0]
        away = sum((log.exp() * (log - old)).sum(-1).mean() for log, old in zip(logs, before, strict=True))
        if away > BOUND:
            break
        ratio = (likelihood(logs, actions) - chances).exp()
        loss = -torch.minimum(ratio * gain, ratio.clamp(1.0 - CLIP, 1.0 + CLIP) * gain).mean()
        optimiser.zero_grad()
        torch.autograd.backward(loss)
        optimiser.step()

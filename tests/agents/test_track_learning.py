"""Policies of the track that learn on a machine, each tested on a case with a known answer."""

from typing import Any

import numpy as np
import pytest
import torch

from agents.track import retraining
from agents.track.adapter_registry import ADAPTERS, make_adapter
from agents.track.learning_policies import ForgetfulRl2, LearningRule, Rl2
from agents.track.model_fit import CONSTANTS, changed
from agents.track.retraining import TEMPERATURE, FineTuned, FittedProblem, RobustCalibrated, cost_ahead
from grind_env.envs.simulation import Simulation
from grind_env.envs.space_metadata import Standard
from grind_env.policies.evaluation import episode_seeds, run_seeds
from grind_env.policies.learned.network import LearnedPolicy
from grind_env.policies.nominal_model import model_of
from grind_env.policies.problem_lookup import find_problem
from grind_env.policies.scripted.empirical_rule import EmpiricalRule
from grind_env.policies.track import TrackMachine, TrackShift
from grind_env.process.stroke_types import StrokeParameters
from grind_env.training.gru_ppo import Agent, Settings, acting_part, form_of, policy_of, train
from tests.agents.test_track_fitting import ROUGH, ground

PLATES = find_problem("power_limited")
MODEL = model_of(PLATES)
ENTRIES, CHOICES = len(MODEL.entries), form_of("gru").view(MODEL).action_space.nvec.tolist()
PLAIN = Standard((0.0,) * ENTRIES, (1.0,) * ENTRIES)
SHORT = Settings(steps=960, envs=4, rollout=60, minibatches=1, epochs=1, guess=0.0)


def some_agent() -> LearnedPolicy:
    """Return a random agent whose decisions depend on its observations."""
    torch.manual_seed(1)
    agent = Agent(ENTRIES, 1, CHOICES, Settings(units=8, hidden=(8,)))
    with torch.no_grad():
        for values in agent.parameters():
            values += 0.3 * torch.randn_like(values)
    return LearnedPolicy(acting_part(agent, PLAIN), PLATES.name, form_of("gru"), "some")


def logits(policy: Any, seen: np.ndarray) -> np.ndarray:
    """Return the outputs of the policy's network for the next observation."""
    said: np.ndarray = policy.agent.actor.outputs(seen[None], policy.agent.state)[0]
    return said


def test_rl2_keeps_its_state_between_shifts_and_forgetful_rl2_clears_it() -> None:
    policy, agent = Rl2(some_agent()), some_agent()
    (shift,) = ground(MODEL, "E6000D1", range(1))
    policy.begin(MODEL, 1)
    agent.begin(MODEL, 1)
    for seen in shift.observations:
        policy.act(seen[None], None)
        agent.act(seen[None], None)
    policy.begin(MODEL, 1)
    np.testing.assert_array_equal(policy.agent.state, agent.state)
    assert policy.agent.state.any()
    forgetful = ForgetfulRl2(policy.agent)
    forgetful.begin(MODEL, 1)
    assert not forgetful.agent.state.any()


def test_the_learning_rule_starts_like_the_rule_and_remembers_between_shifts() -> None:
    adviser, rule, machine = LearningRule(), EmpiricalRule(), TrackMachine("public:1", [0])
    other = TrackMachine("public:1", [0])
    (mine,), _ = machine.grind(adviser)
    (theirs,), _ = other.grind(rule)
    np.testing.assert_array_equal(mine.speeds, theirs.speeds)
    found, speeds = adviser.power.found.copy(), adviser.speeds.copy()
    adviser.begin(MODEL, 1)
    assert adviser.power.known.all() and not adviser.begun
    np.testing.assert_array_equal(adviser.power.found, found)
    np.testing.assert_array_equal(adviser.speeds, speeds)


def log_of_one_cheap_dress(rng: np.random.Generator, blocks: int = 60) -> TrackShift:
    """Return a shift whose blocks are cheap if they have exactly one dress."""
    D = rng.integers(0, 3, blocks).astype(float)
    levels = form_of("gru").view(MODEL).codec.levels
    return TrackShift(
        observations=rng.normal(size=(blocks + 1, ENTRIES)).astype(np.float32),
        speeds=levels[rng.integers(0, len(levels), blocks)],
        executions=D,
        cost=np.where(D == 1.0, 1.0, 8.0),
        bad=np.zeros(blocks, bool),
    )


def chance_of_a_dress(policy: FineTuned, seen: np.ndarray) -> float:
    policy.begin(MODEL, 1)
    D = logits(policy, seen)[0, CHOICES[0] :]
    return float((np.exp(D) / np.exp(D).sum())[1])


def test_fine_tuning_moves_to_cheaper_decisions_within_its_bound(monkeypatch: pytest.MonkeyPatch) -> None:
    rng, chances = np.random.default_rng(0), []
    shifts, seen = [log_of_one_cheap_dress(rng) for _ in range(3)], np.zeros(ENTRIES, np.float32)
    for bound in (0.0, 0.002, 100.0):
        monkeypatch.setattr(retraining, "BOUND", bound)
        policy = FineTuned(some_agent())
        chances.append([chance_of_a_dress(policy, seen)])
        for shift in shifts:
            policy.learn(shift)
            chances[-1].append(chance_of_a_dress(policy, seen))
    still, near, far = chances
    assert still[0] < near[-1] < far[-1] and far == sorted(far)
    # the first step is made before the bound can act
    assert abs(still[-1] - still[0]) < 0.05


def test_equal_block_costs_give_an_equal_cost_ahead() -> None:
    cost = torch.full((60, 2), 3.0)
    assert torch.allclose(cost_ahead(cost), cost)


def test_fine_tuning_draws_from_the_softmax_at_its_temperature() -> None:
    policy, drawn = FineTuned(some_agent()), []
    seen = np.zeros((1, ENTRIES), np.float32)
    for _ in range(400):
        policy.begin(MODEL, 1)
        drawn.append(policy.act(seen, None).executions[0])
    policy.begin(MODEL, 1)
    D = logits(policy, seen[0])[0, CHOICES[0] :] / TEMPERATURE
    chances = np.exp(D) / np.exp(D).sum()
    shares = [np.mean(np.array(drawn) == k) for k in range(len(chances))]
    np.testing.assert_allclose(shares, chances, atol=4.0 * 0.5 / 400**0.5)


def test_a_fitted_problem_simulates_the_fitted_constants() -> None:
    z = np.zeros(len(CONSTANTS))
    z[0] = 1.5
    problem = FittedProblem(PLATES.name, PLATES.id, (), tuple(z))
    envs = problem.make_vec(2, observation="full", autoreset_mode="Disabled")
    ground_with, model = (StrokeParameters(*each.branches.base[0]) for each in (envs.simulation, MODEL))
    assert ground_with.u_ch == pytest.approx(np.exp(0.3) * model.u_ch)
    assert envs.simulation.entries[:ENTRIES] == MODEL.entries and len(envs.simulation.entries) > ENTRIES


def test_the_calibrated_agent_is_trained_after_two_shifts(monkeypatch: pytest.MonkeyPatch) -> None:
    fits: list[int] = []

    def fitted(model: Simulation, shifts: list[TrackShift], z: np.ndarray) -> np.ndarray:
        fits.append(len(shifts))
        return z

    monkeypatch.setattr(retraining, "FURTHER", SHORT)
    monkeypatch.setattr(retraining, "fitted", fitted)
    first, (shift,) = some_agent(), ground(MODEL, "E6000D1", range(1))
    policy = RobustCalibrated(first)
    for trained in (False, True, True):
        policy.begin(MODEL, 1)
        policy.learn(shift)
        assert (policy.agent is not first) == trained
    assert fits == [2]


@pytest.mark.nightly
def test_retraining_on_a_fitted_model_lowers_the_cost_on_its_machine() -> None:
    settings, costs = Settings(steps=300_000, envs=64), list[float]()
    z = np.zeros(len(CONSTANTS))
    z[ROUGH] = 2.0
    machine, seeds = changed(MODEL, z), episode_seeds("validation", 128)
    shifts = ground(machine, "E6000D1", range(2))
    for seed in (0, 1):
        policy = RobustCalibrated(agent := policy_of(*train(PLATES, settings, seed), PLATES, "gru"))
        for shift in shifts:
            policy.begin(MODEL, 1)
            policy.learn(shift)
        costs += [run_seeds(each, machine, seeds).cost.mean() for each in (agent, policy.agent)]
    assert sum(costs[1::2]) < 0.98 * sum(costs[::2])


def test_adapters_by_name() -> None:
    assert [make_adapter(name, MODEL).name for name in ADAPTERS] == [*ADAPTERS]

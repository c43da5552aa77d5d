import signal
import subprocess
import sys
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from agents.benchmark.agent_training import plain_agent
from grind_env.envs.space_metadata import CLIP, Standard
from grind_env.errors import GrindError, GrindWarning
from grind_env.policies.evaluation import episode_seeds, run_seeds
from grind_env.policies.learned.saved import load_policy, write_policy
from grind_env.policies.nominal_model import on
from grind_env.policies.problem_lookup import find_problem
from grind_env.training import gru_ppo
from grind_env.training.checkpoint import Checkpoint
from grind_env.training.gru_ppo import (
    SEEN,
    Agent,
    Memory,
    ReturnScale,
    Settings,
    TrainingEnvs,
    acting_part,
    form_of,
    policy_of,
    shown,
    take_over,
    train,
)
from tests.examples import few

PROBLEM = find_problem("oracle6")
SMALL = Settings(steps=96, envs=4, rollout=8, minibatches=2, epochs=1, units=5, hidden=(7, 6))


def random_agent(memory: Memory, entries: int, choices: tuple[int, ...] = (5, 3)) -> tuple[Agent, Standard, np.ndarray]:
    """Return an agent with random weights, the scale of its features, and features with two hidden entries appended."""
    torch.manual_seed(3)
    agent = Agent(entries, 2, list(choices), replace(SMALL, memory=memory))
    with torch.no_grad():
        for values in agent.parameters():
            values += 0.3 * torch.randn_like(values)
    rng = np.random.default_rng(0)
    scale = Standard(tuple(rng.normal(2.0, 1.0, entries)), tuple(rng.uniform(0.5, 3.0, entries)))
    return agent, scale, rng.normal(2.0, 3.0, (9, 6, entries + 2)).astype(np.float32)


def standardised(features: np.ndarray, scale: Standard) -> torch.Tensor:
    """Return features standardised as in a training, with unscaled hidden entries."""
    entries = len(scale.mean)
    scaled = (features[..., :entries] - scale.mean) / scale.deviation
    return torch.as_tensor(np.concatenate([scaled, features[..., entries:]], axis=-1)).float()


@pytest.mark.parametrize("memory", ["gru", "none"])
def test_torch_and_numpy_agents_give_the_same_probabilities(memory: Memory):
    agent, scale, seen = random_agent(memory, 4)
    actor = acting_part(agent, scale)
    begun = torch.zeros(9, 6)
    begun[0] = 1.0
    logs, *_ = agent(standardised(seen, scale), torch.zeros(1, 6, SMALL.units), begun)
    state = actor.begin(6)
    for k, each in enumerate(seen[..., :4]):
        said, state = actor.outputs(each, state)
        parts = np.split(said, [5], axis=1)
        for log, part in zip(logs, parts, strict=True):
            theirs = part - np.log(np.exp(part).sum(axis=1, keepdims=True))
            assert log[k].detach().numpy() == pytest.approx(theirs, abs=2e-5)
    assert (state != 0.0).any() == (memory == "gru")


def test_an_episode_that_begins_within_a_rollout_starts_with_an_empty_memory():
    agent, scale, found = random_agent("gru", 4)
    seen = standardised(found, scale)
    begun = torch.zeros(9, 6)
    begun[0], begun[4, 2] = 1.0, 1.0
    whole, values, _, _ = agent(seen, torch.ones(1, 6, SMALL.units), begun)
    alone, _, _, _ = agent(seen[4:, 2:3], torch.zeros(1, 1, SMALL.units), torch.zeros(5, 1))
    assert torch.allclose(whole[0][4:, 2], alone[0][:, 0], atol=1e-6)
    begun[4, 2] = 0.0
    through, later, _, _ = agent(seen, torch.zeros(1, 6, SMALL.units), begun)
    assert not torch.allclose(whole[0][4:, 2], through[0][4:, 2], atol=1e-3)
    others = [0, 1, 3, 4, 5]
    assert torch.allclose(values[:, others], later[:, others], atol=1e-6)


def test_hidden_entries_train_the_memory_but_change_no_decision():
    agent, scale, found = random_agent("gru", 4)
    seen = standardised(found, scale)
    other = seen.clone()
    other[..., 4:] += 1.0
    said, told = (agent(each, torch.zeros(1, 6, SMALL.units), torch.zeros(9, 6)) for each in (seen, other))
    assert all(torch.equal(a, b) for a, b in zip(said[0], told[0], strict=True))
    assert torch.equal(said[1], told[1])
    assert said[2] != told[2]
    # the critic does not train the memory, the guess of hidden entries does
    assert agent.gru is not None
    said[1].sum().backward(retain_graph=True)
    assert all(values.grad is None for values in agent.gru.parameters())
    said[2].backward()
    assert all(values.grad is not None and values.grad.any() for values in agent.gru.parameters())


def test_return_scale_gives_mean_and_deviation_of_all_returns():
    returns = torch.randn(300, 2, generator=torch.Generator().manual_seed(1)) * 2.0 + torch.tensor([5.0, -90.0])
    worth = ReturnScale(2)
    for part in returns.split([40, 130, 130]):
        worth.take(part)
    assert worth.mean.numpy() == pytest.approx(returns.numpy().mean(axis=0), rel=1e-5)
    assert worth.deviation.numpy() == pytest.approx(returns.numpy().std(axis=0), rel=1e-4)


def test_lateness_is_charged_as_it_grows_with_an_unchanged_total(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(gru_ppo, "ease_rewards", lambda charged: charged)
    episodes, slow, given = TrainingEnvs(find_problem("rush"), SMALL, 0), np.tile([8, 1], (SMALL.envs, 1)), []
    step = episodes.envs.step

    def noting(actions: np.ndarray) -> Any:
        given.append(step(actions))
        return given[-1]

    episodes.envs.step = noting
    charged = np.array([episodes.step(slow)[0][:, 0] for _ in range(8)])
    rewards = np.array([each[1] for each in given])
    assert (rewards[-1] < -10.0).all() and (charged[-1] > 0.6 * rewards[-1]).all()
    # part of the lateness of the next due date may be charged already
    assert charged.sum(axis=0) == pytest.approx(rewards.sum(axis=0) - episodes.late, rel=1e-5)


def test_features_are_measured_entries_followed_by_hidden_entries():
    episodes = TrainingEnvs(PROBLEM, SMALL, 0)
    full = TrainingEnvs(shown(PROBLEM, "state"), replace(SMALL, memory="state"), 0)
    assert episodes.entries == len(PROBLEM.simulation().entries)
    assert full.entries == full.seen.shape[1] == episodes.seen.shape[1]
    assert episodes.seen.shape[1] > episodes.entries
    for _ in range(20):
        assert torch.allclose(episodes.seen[:, : episodes.entries], full.seen[:, : episodes.entries])
        hidden = full.seen[:, episodes.entries :].clamp(-CLIP, CLIP)
        assert torch.equal(episodes.seen[:, episodes.entries :], hidden)
        for each in (episodes, full):
            each.step(np.ones((SMALL.envs, 2), np.int64))


@pytest.mark.parametrize("memory", SEEN)
def test_an_agent_with_any_memory_learns_and_acts_the_same_after_loading(memory: Memory, tmp_path: Path):
    problem, settings = shown(PROBLEM, memory), replace(SMALL, memory=memory)
    agent, scale = train(problem, settings, 0)
    untrained, _ = train(problem, replace(settings, learning_rate=0.0), 0)
    assert any(not a.equal(b) for a, b in zip(agent.parameters(), untrained.parameters(), strict=True))
    policy, path = policy_of(agent, scale, problem, memory), tmp_path / "agent.safetensors"
    write_policy(path, policy.actor, problem.simulation(), policy.name, form_of(memory), {})
    found = load_policy(path, simulation=problem.simulation())
    seeds = episode_seeds("validation", 4)
    live, saved = (run_seeds(each, problem.simulation(), seeds) for each in (policy, found))
    assert np.array_equal(live.speeds, saved.speeds)
    assert np.array_equal(live.executions, saved.executions)
    if memory == "state":
        with pytest.raises(GrindError, match="with other observations or actions"):
            load_policy(path)


def test_an_agent_trained_on_out_of_model_machines_loads_for_the_task(tmp_path):
    task, machines = find_problem("power_limited"), on(find_problem("power_limited"), "public")
    few = replace(SMALL, rollout=4)
    there, here = TrainingEnvs(machines, few, 0), TrainingEnvs(task, few, 0)
    assert there.entries == here.entries and there.seen.shape == here.seen.shape
    assert there.envs.simulation.plants is not None and here.envs.simulation.plants is None
    settings = Settings(steps=64)
    path = plain_agent(machines, "robust", settings, 0, tmp_path)
    assert load_policy(path, simulation=task.simulation()).name == "robust"
    assert path != plain_agent(task, "robust", settings, 0, tmp_path)


def test_a_training_machine_keeps_its_state_for_all_its_shifts():
    count = 12
    episodes = TrainingEnvs(on(PROBLEM, "public"), replace(SMALL, envs=count, shifts=3), 0)
    fields = episodes.envs.simulation.plants.first.remembers._fields
    walks, walked = fields.index("drift_dulls"), fields.index("drift_dulling")
    drawn, went_on = [[each.first.name for each in episodes.machines.first]], 0
    for _ in range(5):
        for _ in range(episodes.envs.task.blocks):
            episodes.step(np.ones((count, 2), np.int64))
        drawn.append([each.first.name for each in episodes.machines.first])
        for i, begun in enumerate(episodes.begun.tolist()):
            own = episodes.envs.episodes.extra_state(i)
            assert begun == (drawn[-1][i] != drawn[-2][i])
            assert (own[walked] != 0.0) == (own[walks] > 0.0 and not begun)
            went_on += own[walked] != 0.0
    assert went_on > 5
    # the environments begin in different shifts, and change machines in turn
    for i in range(count):
        changed = [k for k, (one, other) in enumerate(pairwise(drawn)) if one[i] != other[i]]
        assert changed == [k for k in range(5) if (i + k + 1) % 3 == 0]
    # the agent guesses the constants of its own machine
    constants = episodes.seen[:, -episodes.machines.hidden.shape[1] :]
    assert torch.equal(constants, episodes.machines.hidden) and constants.shape[1] > 10


def test_take_over_makes_an_agent_act_like_another_one():
    agent, scale, _ = random_agent("gru", 4)
    actor, other = acting_part(agent, scale), Agent(4, 2, [5, 3], SMALL)
    scale = Standard((1.0, 0.0, -2.0, 3.0), (0.5, 1.0, 2.0, 4.0))
    take_over(other, actor, scale)
    for name, values in acting_part(other, scale).tensors.items():
        np.testing.assert_allclose(values, actor.tensors[name], atol=1e-4)


def test_critic_first_trains_the_critic_only():
    settings = replace(SMALL, critic_first=3, guess=0.0)
    first, _ = train(PROBLEM, replace(settings, learning_rate=0.0), 0)
    agent, _ = train(PROBLEM, settings, 0)
    before = dict(first.named_parameters())
    moved = {name.split(".")[0] for name, values in agent.named_parameters() if not values.equal(before[name])}
    assert moved == {"critic"}


def weights(agent: Agent) -> list[np.ndarray]:
    """Return the weights of all layers."""
    return [values.numpy() for values in agent.state_dict().values()]


@pytest.mark.parametrize("budget", few((0.01, None)))
def test_a_killed_training_resumes_to_the_same_weights(tmp_path: Path, budget: float | None):
    problem, settings = shown(on(PROBLEM, "public"), "gru"), replace(SMALL, steps=320, budget=budget)
    whole, _ = train(problem, settings, 1)
    path = tmp_path / "part.checkpoint"
    killed = f"""
import os, signal
from pathlib import Path
from grind_env.policies.nominal_model import on
from grind_env.policies.problem_lookup import find_problem
from grind_env.training.checkpoint import Checkpoint
from grind_env.training.gru_ppo import Settings, shown, train

left = [5]

def advance(steps):
    left[0] -= 1
    left[0] or os.kill(os.getpid(), signal.SIGKILL)

train(shown(on(find_problem("oracle6"), "public"), "gru"), {settings!r}, 1, advance, Checkpoint(Path({str(path)!r})))
"""
    assert subprocess.run([sys.executable, "-c", killed], check=False).returncode == -signal.SIGKILL
    torch.manual_seed(77)
    steps: list[int] = []
    again, _ = train(problem, settings, 1, steps.append, Checkpoint(path))
    assert steps == [128, *[32] * 6]
    for one, other in zip(weights(whole), weights(again), strict=True):
        np.testing.assert_array_equal(one, other)


def test_a_damaged_checkpoint_gives_a_warning_and_a_fresh_start(tmp_path: Path):
    checkpoint = Checkpoint(tmp_path / "part.checkpoint")
    checkpoint.path.write_bytes(b"PK")
    with pytest.warns(GrindWarning, match="is damaged: the training begins anew"):
        assert checkpoint.resume("begun") == "begun"
    checkpoint.remove()
    assert not list(tmp_path.iterdir())

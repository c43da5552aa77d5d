import json
import sys
from dataclasses import replace
from pathlib import Path
from subprocess import run

import numpy as np
import pytest
import torch
from safetensors.numpy import load, save

from agents.learning import gru_ppo
from agents.learning.gru_ppo import SEEN, Agent, Memory, Scale, Settings, acting_part, form_of, policy_of, shown, train
from grind_env.errors import GrindError
from grind_env.policies.evaluation import episode_seeds, run_seeds
from grind_env.policies.learned.network import Network
from grind_env.policies.learned.saved import ENTRY, load_policy, write_policy
from grind_env.policies.problem import find_problem

PROBLEM = find_problem("oracle6")
FILE = Path(gru_ppo.__file__)
SMALL = Settings(steps=96, envs=4, rollout=8, minibatches=2, epochs=1, units=5, hidden=(7, 6))


def filled(memory: Memory, entries: int, choices: tuple[int, ...] = (5, 3)) -> tuple[Agent, Scale, np.ndarray]:
    """An agent whose decisions differ, the scale of its features, and some of them."""
    torch.manual_seed(3)
    agent, scale = Agent(entries, list(choices), replace(SMALL, memory=memory)), Scale(entries)
    with torch.no_grad():
        for values in agent.parameters():
            values += 0.3 * torch.randn_like(values)
    features = np.random.default_rng(0).normal(2.0, 3.0, (9, 6, entries)).astype(np.float32)
    scale.take(features.reshape(-1, entries).astype(np.float64))
    return agent, scale, features


@pytest.mark.parametrize("memory", ["gru", "none"])
def test_torch_and_numpy_say_the_same(memory: Memory):
    agent, scale, features = filled(memory, 4)
    actor = acting_part(agent, scale)
    begun = torch.zeros(9, 6)
    begun[0] = 1.0
    logs, _, _ = agent(scale(features), torch.zeros(1, 6, SMALL.units), begun)
    state = actor.begin(6)
    for k, each in enumerate(features):
        said, state = actor.outputs(each, state)
        parts = np.split(said, [5], axis=1)
        for log, part in zip(logs, parts, strict=True):
            theirs = part - np.log(np.exp(part).sum(axis=1, keepdims=True))
            assert log[k].detach().numpy() == pytest.approx(theirs, abs=2e-5)
    assert (state.output != 0.0).any() == (memory == "gru")


def test_episodes_that_begin_in_a_rollout_remember_nothing():
    agent, scale, features = filled("gru", 4)
    begun = torch.zeros(9, 6)
    begun[0], begun[4, 2] = 1.0, 1.0
    whole, values, _ = agent(scale(features), torch.ones(1, 6, SMALL.units), begun)
    alone, _, _ = agent(scale(features[4:, 2:3]), torch.zeros(1, 1, SMALL.units), torch.zeros(5, 1))
    assert torch.allclose(whole[0][4:, 2], alone[0][:, 0], atol=1e-6)
    begun[4, 2] = 0.0
    through, later, _ = agent(scale(features), torch.zeros(1, 6, SMALL.units), begun)
    assert not torch.allclose(whole[0][4:, 2], through[0][4:, 2], atol=1e-3)
    others = [0, 1, 3, 4, 5]
    assert torch.allclose(values[:, others], later[:, others], atol=1e-6)


def test_the_scale_is_that_of_all_features_together():
    features = np.random.default_rng(1).normal(5.0, 2.0, (300, 3))
    scale = Scale(3)
    for part in np.split(features, [40, 170]):
        scale.take(part)
    assert scale.mean == pytest.approx(features.mean(axis=0))
    assert scale.deviation == pytest.approx(features.std(axis=0))


@pytest.mark.parametrize("memory", SEEN)
def test_every_memory_learns_and_acts_the_same_from_its_file(memory: Memory, tmp_path: Path):
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


def test_a_damaged_file_is_refused(tmp_path: Path):
    path, simulation = tmp_path / "agent.safetensors", PROBLEM.simulation()
    choices = form_of("gru").view(simulation).action_space.nvec
    agent, scale, _ = filled("gru", len(simulation.entries), tuple(choices.tolist()))
    actor = acting_part(agent, scale)
    assert actor.network == Network(
        family="gru",
        entries=len(simulation.entries),
        lstm=5,
        hidden=(7, 6),
        outputs=sum(choices),
        activation="tanh",
    )
    write_policy(path, actor, simulation, "ppo_gru", form_of("gru"), {})
    data = path.read_bytes()
    text = data[8 : 8 + int.from_bytes(data[:8], "little")]
    entry = json.loads(text)["__metadata__"][ENTRY]
    for change, said in (
        (lambda tensors: tensors.pop("gru.weight_hh_l0"), "tensors are not those"),
        (lambda tensors: tensors["gru.bias_hh_l0"].fill(np.nan), "no finite number"),
        (lambda tensors: tensors["gru.weight_ih_l0"].fill(3e38), "so large that it may overflow"),
        (lambda tensors: tensors["actor.0.weight"].fill(3e38), "so large that it may overflow"),
    ):
        tensors = load(data)
        change(tensors)
        path.write_bytes(save(tensors, {ENTRY: entry}))
        with pytest.raises(GrindError, match=said):
            load_policy(path)


def test_the_file_runs_alone_and_its_mistakes_are_told(tmp_path: Path):
    def said(*words: str) -> tuple[int, str]:
        done = run([sys.executable, FILE, *words], capture_output=True, text=True, cwd=tmp_path, check=False)
        return done.returncode, done.stdout + done.stderr

    words = ("--task", "oracle6", "--steps", "1", "--episodes", "2", "--output", "agent.safetensors")
    status, text = said(*words)
    assert status == 0
    assert "CPU-seconds, written to agent.safetensors" in text
    assert load_policy(tmp_path / "agent.safetensors").name == "ppo_gru"
    status, text = said("--memory", "all")
    assert (status, text) == (2, "gru_ppo.py: --memory is 'all', but must be one of none, stack, gru, belief, state\n")

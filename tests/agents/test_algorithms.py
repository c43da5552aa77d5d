from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from agents.learning.algorithms import build
from agents.learning.saving import save_policy
from agents.learning.settings import (
    DEFAULTS,
    LAST_SEED,
    SEED_STRIDE,
    TRAINING_SEEDS,
    Settings,
    settings_for,
)
from agents.learning.train import new_model
from agents.learning.training_env import LearnerVecEnv
from agents.learning.validation import LiveAgent
from grind_env.policies.evaluation import episode_seeds, run_seeds
from grind_env.policies.learned.saved import load_policy
from grind_env.policies.problem import find_problem
from grind_env.policies.tuned import ConfigError

PROBLEM = find_problem("oracle6")
SIMULATION = PROBLEM.simulation()


def tiny(kind: str) -> Settings:
    settings = DEFAULTS[kind]
    hyper = dict(settings.hyper)
    small = {"n_steps": 6, "batch_size": 12, "n_epochs": 1, "buffer_size": 100, "learning_starts": 12, "labels": 24}
    hyper.update({name: value for name, value in small.items() if name in hyper})
    return replace(settings, envs=4, steps=60, hidden=(8,), hyper=hyper)


@pytest.mark.bits
@pytest.mark.parametrize("kind", DEFAULTS)
def test_every_kind_learns_and_acts_the_same_when_saved(kind: str, tmp_path: Path):
    settings = tiny(kind)
    model = new_model(PROBLEM, kind, 0, settings)
    before = [each.detach().clone() for each in model.policy.parameters()]
    model.learn(settings.steps)
    assert any(not old.equal(new) for old, new in zip(before, model.policy.parameters(), strict=True))
    path = tmp_path / "agent.safetensors"
    save_policy(path, model, SIMULATION, kind, settings)
    seeds = episode_seeds("validation", 4)
    live = run_seeds(LiveAgent(model, settings.memory, settings.actions), SIMULATION, seeds)
    saved = run_seeds(load_policy(path), SIMULATION, seeds)
    assert np.array_equal(live.speeds, saved.speeds)
    assert np.array_equal(live.executions, saved.executions)


def test_a_recurrent_agent_remembers_and_forgets_with_the_episode():
    settings = tiny("recurrent_ppo")
    agent = LiveAgent(new_model(PROBLEM, "recurrent_ppo", 0, settings), settings.memory, settings.actions)
    agent.begin(SIMULATION, 2)
    observation = np.random.default_rng(0).uniform(-1, 1, (2, len(SIMULATION.entries))).astype(np.float32)
    agent.act(observation, None)
    assert agent.state is not None
    first = agent.state[0].copy()
    agent.act(observation, None)
    assert not np.array_equal(agent.state[0], first)
    agent.begin(SIMULATION, 2)
    agent.act(observation, None)
    assert np.array_equal(agent.state[0], first)


def test_training_episodes_are_of_the_training_split():
    most = max(settings.envs for settings in DEFAULTS.values())
    assert TRAINING_SEEDS + SEED_STRIDE * LAST_SEED + most < episode_seeds("validation", 1)[0]
    assert most <= SEED_STRIDE


def test_a_file_sets_what_it_names_and_nothing_else(tmp_path: Path):
    (tmp_path / "oracle6.toml").write_text("[ppo]\nsteps = 7\nhidden = [3, 4]\n[ppo.hyper]\ngamma = 0.5\n")
    found, default = settings_for("ppo", PROBLEM.name, tmp_path), DEFAULTS["ppo"]
    assert (found.steps, found.hidden) == (7, (3, 4))
    assert found.hyper == {**default.hyper, "gamma": 0.5}
    assert replace(found, steps=default.steps, hidden=default.hidden, hyper=default.hyper) == default
    assert settings_for("dqn", PROBLEM.name, tmp_path) == DEFAULTS["dqn"]
    assert settings_for("ppo", "slot", tmp_path) == default


@pytest.mark.parametrize(
    "text",
    [
        "[ppo]\nstep = 7\n",
        "[ppo]\nsteps = 0\n",
        "[ppo]\nmemory = 'all'\n",
        "[ppo]\nactions = 3\n",
        "[ppo]\nhidden = 3\n",
        "[ppo]\nsteps = 'many'\n",
        "[ppo]\nhyper = 3\n",
        "ppo = 3\n",
        "[ppo\n",
    ],
)
def test_a_damaged_file_is_told(text: str, tmp_path: Path):
    (tmp_path / "oracle6.toml").write_text(text)
    with pytest.raises(ConfigError):
        settings_for("ppo", PROBLEM.name, tmp_path)


def test_an_unknown_kind_is_told():
    with pytest.raises(ConfigError, match=r"no kind of agent 'a2c'.*: choose from ppo"):
        settings_for("a2c", PROBLEM.name)


@pytest.mark.parametrize(("kind", "name"), [("ppo", "buffer_size"), ("dqn", "n_steps_"), ("sac", "clip_range")])
def test_arguments_of_another_algorithm_are_told(kind: str, name: str):
    settings = tiny(kind)
    env = LearnerVecEnv(PROBLEM, 4, settings.memory, settings.actions)
    with pytest.raises(ConfigError, match=name):
        build(replace(settings, hyper={**settings.hyper, name: 3}), env, 0)


def test_actions_that_an_algorithm_does_not_know_are_told():
    settings = replace(tiny("dqn"), actions="box")
    with pytest.raises(ConfigError, match="dqn"):
        build(settings, LearnerVecEnv(PROBLEM, 4, settings.memory, "box"), 0)

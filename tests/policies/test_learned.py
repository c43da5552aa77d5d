import hashlib
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from grind_env.errors import GrindError
from grind_env.policies.evaluation import episode_seeds, run_seeds, start_episodes
from grind_env.policies.learned.network import Actor, LearnedPolicy, Network
from grind_env.policies.learned.saved import load_policy
from grind_env.policies.policy_lookup import SHIPPED
from grind_env.policies.problem_lookup import find_problem
from tests.examples import few
from tests.policies.untrained import KINDS, recurrent, save
from tests.policies.untrained import untrained as built

pytestmark = pytest.mark.bits

PROBLEM = find_problem("power_limited")
SIMULATION = PROBLEM.simulation()
SPREAD = 2.0  #: factor on the weights, so that the decisions of an untrained network differ


@cache
def untrained(kind: str, task: str = "power_limited") -> Any:
    model = built(find_problem(task), kind)
    with torch.no_grad():
        for name, values in model.policy.named_parameters():
            values *= 100.0 if name.startswith("action_net") else SPREAD
    return model


def saved(folder: Path, kind: str, task: str = "power_limited") -> LearnedPolicy:
    path = folder / f"{kind}.safetensors"
    save(path, untrained(kind, task), find_problem(task).simulation(), kind)
    return load_policy(path)


@pytest.mark.parametrize("kind", few(KINDS))
def test_a_saved_agent_acts_like_stable_baselines(kind: str, tmp_path: Path):
    model, form = untrained(kind), KINDS[kind]
    policy = saved(tmp_path, kind)
    assert (policy.name, policy.sees) == (kind, "measurements")
    n = 8
    policy.begin(SIMULATION, n)
    view = form.view(SIMULATION)
    view.begin(n)
    episodes = start_episodes(SIMULATION, episode_seeds("validation", n))
    state, starts, decided = None, np.ones(n, bool), []
    for _ in range(12):
        observation = SIMULATION.observe(episodes)
        decision = policy.act(observation, None)
        actions, state = model.predict(view.features(observation), state, starts, deterministic=True)
        theirs = view.decide(np.asarray(actions))
        assert np.array_equal(decision.speeds, theirs.speeds)
        assert np.array_equal(decision.executions, theirs.executions)
        SIMULATION.step(episodes, *decision)
        starts = np.zeros(n, bool)
        decided.append(decision)
    assert len(np.unique([decision.speeds for decision in decided])) > 1


@pytest.mark.parametrize("kind", ["ppo", "gru"])
def test_an_episode_does_not_depend_on_other_episodes(kind: str, tmp_path: Path):
    policy = recurrent(SIMULATION) if kind == "gru" else saved(tmp_path, kind)
    n = 69
    features = np.random.default_rng(0).normal(size=(n, policy.actor.network.entries)).astype(np.float32)
    together, after = policy.actor.outputs(features, policy.actor.begin(n))
    again, _ = policy.actor.outputs(features, after)
    for i in (0, 1, 31, 64, n - 1):
        alone, state = policy.actor.outputs(features[i : i + 1], policy.actor.begin(1))
        assert np.array_equal(alone[0], together[i])
        assert np.array_equal(policy.actor.outputs(features[i : i + 1], state)[0][0], again[i])


@pytest.mark.parametrize(("lstm", "digest"), [(0, "98dfa9d8279ad5d4"), (24, "6856937e41bba947")])
def test_a_network_gives_equal_bits_on_every_machine(lstm: int, digest: str):
    network = Network(family="gru", entries=37, lstm=lstm, hidden=(64, 48), outputs=28, activation="tanh")
    rng = np.random.default_rng(0)
    tensors = {name: rng.uniform(-0.5, 0.5, shape).astype(np.float32) for name, shape in network.shapes().items()}
    actor = Actor(network, tensors)
    features = rng.uniform(-3.0, 3.0, (16, network.entries)).astype(np.float32)
    first, state = actor.outputs(features, actor.begin(16))
    second, _ = actor.outputs(features, state)
    assert hashlib.sha256(first.tobytes() + second.tobytes()).hexdigest()[:16] == digest


def test_the_repr_of_an_agent_identifies_its_weights():
    one, same, other = (
        load_policy(SHIPPED / "plain_gru" / f"{name}.safetensors") for name in ("blades", "blades", "rush")
    )
    assert repr(one) == repr(same) and "0x" not in repr(one)
    one.actor.tensors[next(iter(one.actor.tensors))].flat[0] += 1.0
    assert repr(one) != repr(same) != repr(other)


def test_every_evaluation_of_a_recurrent_agent_begins_without_memory():
    policy = recurrent(SIMULATION)
    seeds = episode_seeds("validation", 3)
    first, second = (run_seeds(policy, SIMULATION, seeds) for _ in range(2))
    assert np.array_equal(first.speeds, second.speeds)
    assert np.array_equal(first.cost, second.cost)
    assert first.cost[1:] == pytest.approx(run_seeds(policy, SIMULATION, seeds[1:]).cost, rel=1e-15)


def test_an_agent_refuses_another_task(tmp_path: Path):
    policy = saved(tmp_path, "ppo", "slot")
    policy.begin(find_problem("slot").simulation(), 1)
    with pytest.raises(GrindError, match="the agent ppo was trained for slot, not for power_limited"):
        policy.begin(SIMULATION, 1)

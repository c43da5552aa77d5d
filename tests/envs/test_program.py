from dataclasses import replace

import gymnasium as gym
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from grind_env.control import read
from grind_env.envs.program import conditions, job, number
from grind_env.machine.grind import grind
from grind_env.process.state import WheelState


def run(task_id: str, seed: int, policy_seed: int, blocks: int):
    env = gym.make(task_id).unwrapped
    env.reset(seed=seed)
    actions = np.random.default_rng(policy_seed).uniform(-1, 1, (blocks, 2)).astype(np.float32)
    infos = [env.step(action)[4] for action in actions]
    return env, infos


@settings(max_examples=10)
@given(seed=st.integers(0, 10_000), policy_seed=st.integers(0, 10_000))
def test_the_part_program_of_an_episode_grinds_the_same_parts(seed, policy_seed):
    env, infos = run("grind/PowerLimited-v0", seed, policy_seed, 8)
    kind = env.task.kinds[0]
    wheel = WheelState(*env.simulation.start([np.random.default_rng(seed)]).wheels[0])
    shop = job(env.task, kind)
    record = grind(
        read(env.part_program()),
        replace(shop, wheel=replace(shop.wheel, diamond_flat=wheel.wd)),
        conditions=conditions(env.task, env.episodes.tape[0])[:8],
    )
    parts = record.parts
    assert len(parts) == 8
    assert parts["dresses"].tolist() == [info["D"] for info in infos]
    assert parts["seconds"] == pytest.approx([info["seconds"] for info in infos], rel=1e-9)
    assert parts["survival"] == pytest.approx([info["good_parts"] for info in infos], rel=1e-7, abs=1e-12)
    assert parts["total_cost"] == pytest.approx([info["block_cost"] for info in infos], rel=1e-9)


@pytest.mark.parametrize(
    "value, text", [(0.3, ".3"), (-30.0, "-30."), (-0.02, "-.02"), (11943.0, "11943."), (0.0, "0.")]
)
def test_numbers_are_written_as_the_control_reads_them(value, text):
    assert number(value) == text

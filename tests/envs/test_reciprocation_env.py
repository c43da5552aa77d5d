import dataclasses
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grind_env.control import read
from grind_env.envs.blocks.job import conditions, job_of
from grind_env.envs.blocks.simulation import BlockSimulation
from grind_env.envs.env import GrindEnv
from grind_env.envs.ids import reciprocation
from grind_env.envs.names import task_names
from grind_env.envs.observations import physical
from grind_env.envs.tape import TapeRow
from grind_env.envs.tasks import read_task
from grind_env.machine.grind import grind
from grind_env.machine.record import GrindingRecord
from tests.envs.harness import assert_same, reward_terms_of, whole_tape
from tests.examples import examples

ID = "grind/Reciprocation-v0"


def play(env: GrindEnv, seed: int, policy_seed: int, blocks: int) -> list[dict[str, Any]]:
    env.reset(seed=seed)
    size = env.action_space.shape[0]
    actions = np.random.default_rng(policy_seed).uniform(-1, 1, (blocks, size)).astype(np.float32)
    return [env.step(action)[4] for action in actions]


def ground(env: GrindEnv, blocks: int) -> GrindingRecord:
    """The program of the episode, run with the operator's requests."""
    assert env.episodes is not None
    job = job_of(env.task, env.blocks)
    wheel = env.simulation.start([np.random.default_rng(env.np_random_seed)]).wheel(0)
    parts = tuple(conditions(env.task, whole_tape(env))[:blocks])
    job = dataclasses.replace(job, wheel=dataclasses.replace(job.wheel, diamond_flat=wheel.wd), parts=parts)
    control = dataclasses.replace(job.control, operator_dress_at=env.written().requests)
    return grind(read(env.part_program()), job, control=control)


@examples(10)
@given(seed=st.integers(0, 10_000), policy_seed=st.integers(0, 10_000), predress=st.booleans())
def test_the_part_program_of_an_episode_grinds_the_same_parts(seed: int, policy_seed: int, predress: bool) -> None:
    env = reciprocation.make(predress=predress, info="full")
    infos = play(env, seed, policy_seed, 6)
    record = ground(env, 6)
    parts = record.parts
    # random speeds ask a lot of the spindle, and of nothing else
    assert all("the spindle s" in warning for warning in record.warnings)
    dresses = [info["D"] + info.get("predress", 0.0) for info in infos]
    assert parts["dresses"].tolist() == dresses
    assert (record.dresses["cause"] == "operator").sum() == sum(info["D"] for info in infos)
    assert parts["seconds"] == pytest.approx([info["seconds"] for info in infos], rel=1e-9)
    assert parts["survival"] == pytest.approx([info["good_parts"] for info in infos], rel=1e-6, abs=1e-12)
    assert parts["total_cost"] == pytest.approx([info["block_cost"] for info in infos], rel=1e-8)


def test_the_blocks_of_a_step_are_the_literal_form() -> None:
    env = reciprocation.make(predress=True, show_block=True)
    env.reset(seed=0)
    assert env.episodes is not None
    stock = whole_tape(env)[0, 1]
    info = env.step(env.codec.encode(9487.0, 1.0, 1.0)[0])[4]
    lines = info["block"].split("\n")
    assert lines[0] == "G81.1 X330. I-30. E9487. P9100"
    assert [line.split()[0] for line in lines[1:]] == ["G01", "G04", "G01", "G04", "G80"]
    assert lines[1].endswith(" F.4") and lines[2].endswith("(OPERATOR ASKS FOR A DRESS)")
    assert lines[3].startswith(f"G01 Y-{stock:.3f}".replace("-0.", "-."))
    plain = env.step(np.array([0.0, -1.0, -0.5], np.float32))[4]["block"].split("\n")
    assert plain[0] == "G81 X330. I-30. E9487. P9100"
    assert [line.split()[0] for line in plain[1:]] == ["G01", "G04", "G80"]
    assert len(env.written().requests) == 1


def test_strokes_get_thinner_as_the_table_gets_faster() -> None:
    env = reciprocation.make()
    picks = []
    for u in (-1.0, 0.0, 0.7):
        env.reset(seed=0)
        observation = env.step(np.array([u, -1.0], np.float32))[0]
        names = [reading.name for reading in env.observation_info()]
        picks.append(0.02 * float(observation[names.index("last_pick")]))
    E = np.array([3000.0, 9487.0, 21_275.0]) / 60.0
    assert picks == pytest.approx(0.4 / 60.0 * (360.0 / E + E / 1000.0 + 0.15), rel=1e-3)
    assert "pick" not in names


@pytest.mark.parametrize("pre_dress", [0.0, 1.0])
def test_the_volume_ground_since_the_dress_is_kept_by_book(pre_dress: float) -> None:
    env = reciprocation.make(predress=True)
    env.reset(seed=6)
    assert env.episodes is not None
    stocks = whole_tape(env)[:, TapeRow._fields.index("gauged")]
    volume, blocks = 0.0, 0.0
    for stock, D in zip(stocks, (0.0, 2.0, 0.0, 0.0, 1.0, 3.0), strict=False):
        dressed = D + pre_dress > 0.0
        # D requests part the depth into D + 1 equal shares; a pre-dress comes before all of it
        volume = stock * 300.0 / (D + 1.0) + (0.0 if dressed else volume)
        blocks = 0.0 if dressed else blocks + 1.0
        observation = env.step(env.codec.encode(9000.0, D, pre_dress)[0])[0]
        seen = physical(observation, env.observation_info())
        assert float(seen["volume"]) == pytest.approx(volume, rel=1e-5)
        assert float(seen["blocks_since_dress"]) == pytest.approx(blocks, rel=1e-5)


def test_the_last_block_pays_for_the_wheel_it_leaves() -> None:
    env = reciprocation.make()
    env.reset(seed=1)
    handed = [env.step(env.codec.encode(9000.0, 1.0)[0])[4]["reward_handover"] for _ in range(60)]
    assert handed[:-1] == [0.0] * 59
    wheel = env.simulation.start([np.random.default_rng(1)]).wheel(0)
    assert env.episodes is not None
    worn = env.episodes.wheel(0)
    assert worn.A > wheel.A
    assert handed[-1] < 0.0


def test_the_depth_of_a_stroke_follows_the_infeed_of_the_task() -> None:
    task = dataclasses.replace(read_task("reciprocation"), infeed=0.2)
    picks = []
    for each in (task, read_task("reciprocation")):
        simulation = BlockSimulation(each)
        episodes = simulation.start([np.random.default_rng(0)])
        simulation.step(episodes, np.array([12_000.0]), np.array([0.0]))
        picks.append(float(physical(simulation.observe(episodes)[0], simulation.entries)["last_pick"]))
    assert picks[0] == pytest.approx(picks[1] / 2.0, rel=1e-6)


def test_the_episode_is_that_of_the_power_limited_task() -> None:
    ours, theirs = gym.make(ID).unwrapped, gym.make("grind/PowerLimited-v0").unwrapped
    for env in (ours, theirs):
        env.reset(seed=4)
    assert_same(whole_tape(ours), whole_tape(theirs))
    assert_same(ours.episodes.wheels, theirs.episodes.wheels)
    assert "reciprocation" not in task_names()


def test_a_fixed_plan_earns_minus_one_a_step() -> None:
    env = gym.make_vec(ID, 64)
    env.reset(seed=500)
    action = env.unwrapped.codec.encode(np.full(64, 12_000.0), np.full(64, 1.0))
    rewards = np.array([env.step(action)[1] for _ in range(60)])
    assert rewards.mean() == pytest.approx(-1.0, abs=0.1)


def test_the_terms_add_up_to_the_reward() -> None:
    env = reciprocation.make()
    env.reset(seed=0)
    vector = gym.make_vec(ID, 4)
    vector.reset(seed=0)
    for k in range(5):
        action = np.full(2, 0.2 * k - 0.5, np.float32)
        _, reward, _, _, info = env.step(action)
        assert sum(reward_terms_of(info).values()) == pytest.approx(reward, rel=1e-12)
        _, rewards, _, _, infos = vector.step(np.tile(action, (4, 1)))
        terms = [*reward_terms_of(infos).values()]
        np.testing.assert_allclose(np.sum(terms, axis=0), rewards, rtol=1e-12)

import gymnasium as gym
import numpy as np
import pytest

from grind_env.envs.ids import reciprocation
from grind_env.envs.noise_tape import TapeRow
from grind_env.envs.observations import physical
from grind_env.envs.task_names import task_names
from tests.envs.harness import assert_same, whole_tape

ID = "grind/Reciprocation-v0"


def test_a_step_writes_a_g81_cycle_with_its_infeed_blocks() -> None:
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


@pytest.mark.parametrize("pre_dress", [0.0, 1.0])
def test_the_volume_since_the_dress_follows_the_gauged_stock(pre_dress: float) -> None:
    env = reciprocation.make(predress=True)
    env.reset(seed=6)
    assert env.episodes is not None
    stocks = whole_tape(env)[:, TapeRow._fields.index("gauged")]
    volume, blocks = 0.0, 0.0
    for stock, D in zip(stocks, (0.0, 2.0, 0.0, 0.0, 1.0, 3.0), strict=False):
        dressed = D + pre_dress > 0.0
        # D requests divide the depth into D + 1 equal shares; a pre-dress comes first
        volume = stock * 300.0 / (D + 1.0) + (0.0 if dressed else volume)
        blocks = 0.0 if dressed else blocks + 1.0
        observation = env.step(env.codec.encode(9000.0, D, pre_dress)[0])[0]
        seen = physical(observation, env.observation_info())
        assert float(seen["volume"]) == pytest.approx(volume, rel=1e-5)
        assert float(seen["blocks_since_dress"]) == pytest.approx(blocks, rel=1e-5)


def test_an_episode_has_the_tape_and_the_wheel_of_power_limited() -> None:
    ours, theirs = gym.make(ID).unwrapped, gym.make("grind/PowerLimited-v0").unwrapped
    for env in (ours, theirs):
        env.reset(seed=4)
    assert_same(whole_tape(ours), whole_tape(theirs))
    assert_same(ours.episodes.wheels, theirs.episodes.wheels)
    assert "reciprocation" not in task_names()

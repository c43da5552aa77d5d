from collections.abc import Sequence

import gymnasium as gym
import numpy as np
import pytest

from grind_env.envs.program import number


def test_a_wheel_change_stands_in_the_program() -> None:
    env = gym.make("grind/CBN-v0").unwrapped
    env.reset(seed=0)
    changed = [env.step(np.array([0.5, 1.0]))[4]["reward_terms"]["change"] < 0.0 for _ in range(12)]
    assert sum(changed) == 1
    after = changed.index(True) + 1
    stops = [line for line in env.part_program().splitlines() if line.startswith(("M00", "M01"))]
    assert [("CHANGE THE WHEEL" in stop) for stop in stops] == [k == after for k in range(1, 12)]


def test_rough_and_finish_of_a_part_are_gauged_between() -> None:
    env = gym.make("grind/WideRails-v0").unwrapped
    env.reset(seed=0)
    for _ in range(4):
        env.step(np.zeros(2))
    stops = [line[:3] for line in env.part_program().splitlines() if line.startswith("M0")]
    assert stops == ["M01", "M00", "M01"]


@pytest.mark.parametrize(
    "value, text", [(0.3, ".3"), (-30.0, "-30."), (-0.02, "-.02"), (11943.0, "11943."), (0.0, "0.")]
)
def test_numbers_are_written_as_the_control_reads_them(value: float, text: str) -> None:
    assert number(value) == text


def blocks_of(text: str) -> Sequence[str]:
    return [line for line in text.splitlines() if line.startswith("G82")]


def test_an_order_of_another_kind_has_its_own_words() -> None:
    env = gym.make("grind/JobShop-v0").unwrapped
    env.reset(seed=3)
    infos = [env.step(np.zeros(2))[4] for _ in range(30)]
    assert blocks_of(env.part_program()) == [info["block"] for info in infos]
    picks = {block.kind.name: block.kind.pick for block in env.blocks}
    assert len(picks) == 3
    for info, block in zip(infos, env.blocks, strict=True):
        assert f"J{number(-block.kind.pick)} L{block.kind.sparkout + 1} " in info["block"]

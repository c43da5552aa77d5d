from itertools import product

import gymnasium as gym
import numpy as np
import pytest

from grind_env.envs.contexts import FACTORS
from tests.envs.harness import IDS, native

NAMES = ("kA", "pm", "fc", "Gref", "hf")
"""The factors on the wear of the wheel, beside the stock, of which the most wears it most."""
CORNERS = [
    {"material": material, "stock": FACTORS["stock"].high, **dict(zip(NAMES, values, strict=True))}
    for material in ("aisi_1020", "inconel_718")
    for values in product(*[(FACTORS[name].low, FACTORS[name].high) for name in NAMES])
]


@pytest.mark.parametrize("env_id", [*IDS, "grind/Reciprocation-v0"])
@pytest.mark.parametrize("action", [(1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)])
def test_no_corner_of_the_factors_leaves_the_numbers(env_id: str, action: tuple[float, float]) -> None:
    corners = CORNERS if "CBN" not in env_id else CORNERS[::8]
    env = native(env_id, len(corners), "SameStep")
    space = env.observation_space
    observations, _ = env.reset(seed=0, options={"context": corners})
    actions = np.tile(np.array(action, np.float32), (len(corners), 1))
    for _ in range(12):
        assert space.contains(observations)
        observations, rewards, *_ = env.step(actions)
        assert np.isfinite(rewards).all() and (rewards < 0.0).all()


def test_a_wheel_that_is_worn_away_costs_a_wheel_and_the_part() -> None:
    env = gym.make("grind/Slot-v0").unwrapped
    env.reset(seed=0, options={"context": {"material": "inconel_718", "stock": 3.0, "Gref": 0.2, "fc": 0.2}})
    _, reward, _, _, info = env.step(np.array([1.0, 1.0], np.float32))
    kind, wheel, rates = env.task.kinds[0], env.task.wheel, env.task.rates
    volume = np.pi / 4.0 * (wheel.diameter**2 - wheel.minimum_diameter**2) * kind.width
    costs = {name: -value * env.task.reference_cost for name, value in info["reward_terms"].items()}
    assert costs["wheel"] == pytest.approx(rates.wheel * volume)
    assert costs["scrap"] == pytest.approx(kind.scrap)
    assert reward == pytest.approx(sum(info["reward_terms"].values()))
    assert (info["cost"], info["good_parts"]) == (1.0, 0.0)
    # the next block has a new wheel
    assert env.episodes.wheels[0, 0] == wheel.diameter

"""Version 0 of an environment stays what it was: agents that were trained on it depend on every entry and every bit."""

import hashlib

import numpy as np
import pytest

from tests.envs.harness import Array, actions, native

pytestmark = pytest.mark.bits

MEASURED = [
    "mean_power",
    "first_power",
    "peak_power",
    "last_speed",
    "last_executions",
    "last_pick",
    "last_width",
    "size_error",
    "roughness",
    "parts_since_gauged",
    "volume",
    "blocks_since_dress",
    "dresses",
    "diameter",
    "pick",
    "width",
    "length",
    "sparkout",
    "stock",
    "roughness_limit",
    "tolerance",
    "scrap",
    "new_lot",
    "remaining",
]
HIDDEN = [
    "wear_flat",
    "loading",
    "waviness",
    "diamond_flat",
    "dressed_roughness",
    "dressed_density",
    "growth",
    "pressure",
    "fracture",
    "wear",
    "convection",
    "roughness_scale",
    "wheel_volume",
]
KINDS = [
    "coming_plate",
    "coming_gauge",
    "following_plate",
    "following_gauge",
]


def digest(values: list[Array]) -> str:
    return hashlib.sha256(np.array(values).tobytes()).hexdigest()[:16]


@pytest.mark.parametrize(
    ("env_id", "observation", "names", "seen", "earned"),
    [
        ("grind/PowerLimited-v0", "measured", MEASURED, "6000ae36b7b85f20", "805a0bd646df9400"),
        ("grind/PowerLimited-v0", "full", [*MEASURED, *HIDDEN], "3dbc6bdc564b1006", "805a0bd646df9400"),
        ("grind/Oracle6-v0", "measured", [*MEASURED, *KINDS], "7413cc68c91cf967", "f2bfc30e0483202a"),
        ("grind/Oracle6-v0", "full", [*MEASURED, *HIDDEN, *KINDS], "861d18bc75e1eba2", "f2bfc30e0483202a"),
    ],
)
def test_observations_and_rewards_are_those_of_the_first_release(
    env_id: str, observation: str, names: list[str], seen: str, earned: str
) -> None:
    env = native(env_id, 32, "SameStep", observation=observation)
    assert [entry.name for entry in env.unwrapped.observation_info()] == names
    observations, rewards = [env.reset(seed=11)[0]], []
    for action in actions(130, 32, seed=5):
        stepped = env.step(action)
        observations.append(stepped[0])
        rewards.append(stepped[1])
    # recorded before any other task was added
    assert (digest(observations), digest(rewards)) == (seen, earned)

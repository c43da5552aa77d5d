import gymnasium as gym
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode

from grind_env.belief.filter_quantities import CUT
from grind_env.envs.blocks.task_simulation import BlockSimulation
from grind_env.envs.episode_state import Episodes
from grind_env.envs.noise_tape import TapeRow
from grind_env.envs.observations import physical
from grind_env.envs.tasks import load_task
from tests.envs.harness import IDS, Array, actions, assert_same, native, start


def columns(env_id: str, seeds: list[int], plans: Array) -> list[Array]:
    """Return observations and rewards of each sub-env; plans have shape (steps, N, 2)."""
    env = native(env_id, len(seeds), AutoresetMode.SAME_STEP)
    observations = [env.reset(seed=seeds)[0]]
    rewards = []
    for action in plans:
        observation, reward, *_ = env.step(action)
        observations.append(observation)
        rewards.append(reward)
    return [np.concatenate([np.array(observations)[:, i].ravel(), np.array(rewards)[:, i]]) for i in range(len(seeds))]


@pytest.mark.parametrize("env_id", IDS)
def test_a_sub_env_does_not_depend_on_its_neighbours(env_id: str) -> None:
    steps = gym.make(env_id).unwrapped.task.blocks + 2
    seeds = list(range(100, 121))
    plans = actions(steps, len(seeds))
    alone = [columns(env_id, [seed], plans[:, [i]])[0] for i, seed in enumerate(seeds)]
    for order in (np.arange(21), np.arange(21)[::-1], np.random.default_rng(1).permutation(21)[:13]):
        together = columns(env_id, [seeds[i] for i in order], plans[:, order])
        assert_same(together, [alone[i] for i in order])


def test_successive_and_unseeded_episodes_differ() -> None:
    env = gym.make("grind/PowerLimited-v0")
    first, second, third = env.reset(seed=1)[0], env.reset()[0], env.reset()[0]
    assert not np.array_equal(first, second) and not np.array_equal(second, third)
    assert_same(env.reset(seed=1)[0], first)
    vector = native("grind/PowerLimited-v0", 8)
    assert len(np.unique(vector.reset()[0], axis=0)) == 8
    assert not np.array_equal(
        gym.make("grind/PowerLimited-v0").reset()[0], gym.make("grind/PowerLimited-v0").reset()[0]
    )


def tape_columns(count: int) -> dict[str, Array]:
    episodes = start(BlockSimulation(load_task("power_limited")), count)
    return dict(zip(TapeRow._fields, np.moveaxis(episodes.tape, 2, 0), strict=True))


def cut_sigma(sigma: float) -> float:
    """Return the standard deviation of sigma clip(N(0, 1), -1.8, 1.8)."""
    z = np.clip(np.random.default_rng(0).standard_normal(1_000_000), -1.8, 1.8)
    return sigma * float(z.std())


def test_the_draws_have_the_published_distributions() -> None:
    n, tape = 3000, tape_columns(3000)
    relative = tape["stock"] / 0.30
    assert relative.min() >= 0.4 - 1e-9
    assert relative.mean() == pytest.approx(1.0, abs=5 * 0.25 / np.sqrt(60 * n) + 0.001)
    assert relative.std() == pytest.approx(0.25, rel=0.02)
    error = tape["gauged"] - tape["stock"]
    assert error.std() == pytest.approx(0.005, rel=0.02)
    assert abs(error.mean()) < 5 * 0.005 / np.sqrt(60 * n)
    assert (tape["gauged"] >= 0.3 * 0.30).all()
    np.testing.assert_allclose(tape["stock"], np.round(tape["stock"], 3), atol=1e-12)

    assert (tape["new_lot"][:, 0] == 1.0).all()
    share = tape["new_lot"][:, 1:].mean()
    assert share == pytest.approx(1 / 6, abs=5 * np.sqrt(5 / 36 / (59 * n)))

    for name, sigma in (("fc", 0.10), ("Gref", 0.15), ("hf", 0.15)):
        assert (tape[name] == tape[name][:, :1]).all(), name
        logs = np.log(tape[name][:, 0])
        assert np.abs(logs).max() == pytest.approx(CUT * sigma), name
        assert logs.std() == pytest.approx(cut_sigma(sigma), rel=5 / np.sqrt(2 * n)), name
        assert abs(logs.mean()) < 5 * sigma / np.sqrt(n), name

    # the roughness is that of the wheel, and scatters from part to part
    logs = np.log(tape["ra_scale"])
    wheel_and_part = np.hypot(cut_sigma(0.07), cut_sigma(0.15))
    assert logs.std() == pytest.approx(wheel_and_part, rel=0.02)
    assert logs.mean(axis=1).std() == pytest.approx(np.hypot(cut_sigma(0.07), cut_sigma(0.15) / 60**0.5), rel=0.06)

    fresh = tape["new_lot"] == 1.0
    for name in ("kA", "pm"):
        assert (tape[name][:, 1:] == tape[name][:, :-1])[~fresh[:, 1:]].all(), name
        assert (tape[name][:, 1:] != tape[name][:, :-1])[fresh[:, 1:]].mean() > 0.99 - 0.075**2, name
    assert np.log(tape["pm"][fresh]).std() == pytest.approx(cut_sigma(0.08), rel=0.03)
    wheel_and_lot = np.hypot(cut_sigma(0.30), cut_sigma(0.80))
    assert np.log(tape["kA"][fresh]).std() == pytest.approx(wheel_and_lot, rel=0.04)


def test_the_diamond_starts_with_a_wear_flat_up_to_a_tenth_of_a_millimetre() -> None:
    simulation = BlockSimulation(load_task("power_limited"), full=True)
    flat = physical(simulation.observe(start(simulation, 2000)), simulation.entries)["diamond_flat"]
    assert 0.0 <= flat.min() < 0.002 and 0.098 < flat.max() <= 0.1
    assert flat.mean() == pytest.approx(0.05, abs=5 * 0.1 / np.sqrt(12 * 2000))


def test_the_noises_are_standard_normal_and_independent() -> None:
    tape = tape_columns(2000)
    names = ("mean_noise", "first_noise", "peak_noise", "size_noise", "roughness_noise")
    noise = np.array([tape[name].ravel() for name in names])
    n = noise.shape[1]
    assert (np.abs(noise.mean(axis=1)) < 5 / np.sqrt(n)).all()
    np.testing.assert_allclose(noise.std(axis=1), 1.0, atol=5 / np.sqrt(2 * n))
    correlation = np.corrcoef(noise) - np.eye(len(names))
    assert np.abs(correlation).max() < 5 / np.sqrt(n)


def test_picked_episodes_are_independent_copies() -> None:
    simulation = BlockSimulation(load_task("power_limited"))
    episodes = start(simulation, 4)
    simulation.step(episodes, np.full(4, 6000.0), np.ones(4))
    branches = episodes.pick([2, 2, 0])
    assert isinstance(branches, Episodes)
    before = simulation.observe(episodes)
    outcomes, _ = simulation.step(branches, np.array([6000.0, 8000.0, 6000.0]), np.array([0.0, 0.0, 0.0]))
    assert_same(simulation.observe(episodes), before)
    plain, _ = simulation.step(episodes, np.full(4, 6000.0), np.zeros(4))
    assert_same(outcomes[0], plain[2])
    assert_same(outcomes[2], plain[0])
    assert outcomes[1, 0] < outcomes[0, 0]

import itertools

import gymnasium as gym
import numpy as np
import pytest

import grind_env
from grind_env.envs.episode_state import NOISE
from grind_env.envs.noise_tape import TapeRow
from grind_env.envs.tasks import Due
from grind_env.policies import episode_columns
from grind_env.policies.choices import Decision
from grind_env.policies.evaluation import SEEDS, SEEDS_EACH, episode_seeds, run_seeds, start_episodes
from grind_env.policies.privileged_information import expected_dates, reveal
from grind_env.policies.scripted.rules import Fixed
from tests.policies.harness import simulated

gym.register_envs(grind_env)

SIMULATION = simulated("power_limited")
LOT = [TapeRow._fields.index(name) for name in ("kA", "pm", "hf", "fc", "Gref", "ra_scale")]


class Spy:
    """Policy that records the episodes it sees and then overwrites them."""

    name = "spy"

    def __init__(self, sees):
        self.sees = sees

    def begin(self, simulation, episodes):
        self.shown = []

    def act(self, observation, episodes):
        self.shown.append(None if episodes is None else episodes.pick(np.arange(len(observation))))
        if episodes is not None:
            for table in (episodes.tape, episodes.wheels, episodes.parts, episodes.memory, episodes.block):
                table[:] = 0
        return Decision(np.full(len(observation), 12000.0), np.ones(len(observation)))


def spied(sees, seeds=(0, 1, 2)):
    spy = Spy(sees)
    run_seeds(spy, SIMULATION, seeds)
    return spy.shown


def truth(seeds=(0, 1, 2)):
    return start_episodes(SIMULATION, seeds)


def test_training_validation_and_evaluation_have_no_seed_in_common():
    ranges = sorted((episode_seeds(seeds, SEEDS_EACH) for seeds in SEEDS), key=lambda seeds: seeds.start)
    assert len(ranges) == len(SEEDS) == 3
    assert all(a.stop <= b.start for a, b in itertools.pairwise(ranges))


@pytest.mark.parametrize("seed", [0, 2_000_000, 3_000_000, 3_400_000, 10**9])
def test_a_split_has_the_contexts_of_the_environment_for_every_seed(seed):
    env, plan = gym.make("grind/PowerLimited-v0"), Fixed(12_000.0, 1)
    costs = {}
    for split in (None, "all", "inner", "interpolation", "extrapolation"):
        env.reset(seed=seed, options=None if split is None else {"split": split})
        action = env.unwrapped.codec.encode(12000.0, 1)[0]
        costs[split] = sum(env.step(action)[-1]["block_cost"] for _ in range(60))
        (cost,) = run_seeds(plan, SIMULATION, [seed], *([] if split is None else [split])).cost
        assert cost == pytest.approx(costs[split], rel=1e-12)
    assert costs["all"] == costs[None]
    assert len(set(costs.values())) == 4


def test_a_policy_on_the_state_does_not_see_the_future():
    tape = truth().tape
    for k, shown in enumerate(spied("state")):
        # the true state and the coming block, but no draws of later blocks
        assert np.array_equal(shown.tape[:, k, LOT], tape[:, k, LOT])
        assert np.array_equal(shown.tape[:, k, episode_columns.STOCK], tape[:, k, episode_columns.STOCK])
        later, expected = shown.tape[:, k + 1 :], tape[:, [k]].copy()
        expected[..., episode_columns.ROUGHNESS] /= expected[..., episode_columns.PART_ROUGHNESS]  # of the wheel alone
        assert (later[..., LOT] == expected[..., LOT]).all()
        assert (later[..., [episode_columns.STOCK, episode_columns.GAUGED]] == 0.3).all()
        assert (later[..., episode_columns.NEW_LOT] == 0.0).all()
        assert (shown.tape[..., NOISE] == 0.0).all()


def test_the_state_shows_a_spare_wheel_only_once_it_is_mounted():
    simulation = simulated("CBN")
    episodes = start_episodes(simulation, [0, 0])
    episodes.memory[1, episode_columns.CHANGES] = 1.0
    shown = reveal("state", simulation, episodes).tape[:, 0]
    for old, new in episode_columns.OF_WHEEL:
        assert shown[0, new] == episodes.tape[0, 0, old] != episodes.tape[0, 0, new]
        assert shown[1, new] == episodes.tape[1, 0, new]


def test_later_due_dates_are_expected_at_the_mean_slack():
    # periods of two blocks: 30, 50 and 20 s of work, the next date at 100 s, mean slack 1.1
    tape = np.zeros((1, 6, len(TapeRow._fields)))
    tape[0, :, episode_columns.WORK] = [30.0, 10.0, 50.0, 30.0, 20.0, 15.0]
    dates = Due(blocks=2, speed=12_000.0, slack=(0.9, 1.3), late=1.0)
    for block in (0, 1):
        due = expected_dates(dates, tape, np.array([100.0]), np.array([block]))
        assert due[0] == pytest.approx([100.0, 100.0, 155.0, 155.0, 177.0, 177.0])
    assert expected_dates(dates, tape, np.array([100.0]), np.array([3]))[0, 3:] == pytest.approx([100.0, 122.0, 122.0])


@pytest.mark.parametrize("sees", ["measurements", "state", "future"])
def test_a_policy_cannot_change_the_truth(sees):
    assert np.array_equal(
        run_seeds(Spy(sees), SIMULATION, [3, 4]).cost, run_seeds(Fixed(12_000.0, 1), SIMULATION, [3, 4]).cost
    )

"""Every policy in every environment, and the information that it gets there."""

import numpy as np
import pytest

from grind_env.envs.episode_state import DRAWN_FROM, Episodes
from grind_env.envs.noise_tape import TapeRow
from grind_env.envs.simulation import Simulation
from grind_env.policies.choices import Decision, nearest_speed
from grind_env.policies.episode_columns import LISTED
from grind_env.policies.evaluation import roll_out, run_seeds, start_episodes
from grind_env.policies.planners.dynamic_programming import EPISODES_AT_ONCE
from grind_env.policies.planners.hindsight import Hindsight
from grind_env.policies.policy import Policy
from grind_env.policies.privileged_information import reveal
from grind_env.policies.problem_lookup import find_problem
from grind_env.policies.registry import ABLATIONS, UNSCORED, fitting, policy_names
from grind_env.policies.scripted.rules import Fixed, Random
from tests.policies.harness import shortened, untuned

#: environments, and the blocks or parts of their short episodes
LENGTHS = {"power_limited": 3, "job_shop": 3, "reciprocation": 2, "wide_plates": 2}
BESIDES = ("reciprocation", "wide_plates")  #: environments that are no task of cycle blocks
NAMES = [
    (env, name)
    for env, simulation in ((env, find_problem(env).simulation()) for env in LENGTHS)
    for name in (*policy_names(simulation), *ABLATIONS, *fitting(UNSCORED, simulation))
]


class Watched:
    """Policy whose every decision is checked."""

    def __init__(self, policy: Policy) -> None:
        self.policy, self.name, self.sees = policy, policy.name, policy.sees
        self.decided: list[Decision] = []

    def begin(self, simulation: Simulation, episodes: int) -> None:
        self.task = simulation.task
        self.policy.begin(simulation, episodes)

    def act(self, observation: np.ndarray, episodes: Episodes | None) -> Decision:
        assert (episodes is None) == (self.sees == "measurements")
        decision = self.policy.act(observation, episodes)
        for values in decision:
            assert (values.shape, values.dtype) == ((len(observation),), np.float64)
        assert np.array_equal(decision.speeds, nearest_speed(self.task, decision.speeds))
        assert np.isin(decision.executions, np.arange(self.task.action.executions + 1)).all()
        self.decided.append(decision)
        return decision


@pytest.mark.parametrize(("env", "name"), NAMES)
def test_every_policy_decides_in_the_action_space_of_every_environment(env: str, name: str) -> None:
    simulation = shortened(env, LENGTHS[env])
    policy = Watched(untuned(name, simulation))
    # again with another number of episodes: nothing is left of the first run
    for seeds in (range(2), range(3)):
        policy.decided.clear()
        run = run_seeds(policy, simulation, seeds)
        for decided, done in zip(zip(*policy.decided, strict=True), (run.speeds, run.executions), strict=True):
            wanted = np.where(np.isnan(done), np.nan, np.array(decided).T)
            np.testing.assert_array_equal(done, wanted)
        assert (run.cost > 0.0).all()
        assert run.finished.tolist() == [simulation.task.blocks] * len(seeds)


def halfway(simulation: Simulation, seeds: range, steps: int) -> Episodes:
    """Return episodes after some steps of a random policy."""
    episodes, plan = start_episodes(simulation, seeds), Random()
    plan.begin(simulation, len(seeds))
    for _ in range(steps):
        simulation.step(episodes, *plan.act(simulation.observe(episodes), None))
    return episodes


def on_tape(episodes: Episodes) -> list[np.ndarray]:
    """Return the arrays whose columns are the fields of `TapeRow`."""
    rows = len(TapeRow._fields)
    return [array for name, array in episodes.arrays().items() if array.shape[-1] == rows and name != "memory"]


@pytest.mark.parametrize("steps", [0, 7])
@pytest.mark.parametrize("sees", ["state", "future"])
@pytest.mark.parametrize("env", LENGTHS)
def test_no_policy_sees_the_noise(env: str, sees: str, steps: int) -> None:
    simulation = find_problem(env).simulation()
    episodes = halfway(simulation, range(2), steps)
    other, rng = episodes.pick(np.arange(2)), np.random.default_rng(0)
    changed = 0
    for table in on_tape(other):
        for column, name in enumerate(TapeRow._fields):
            if name.endswith("_noise"):
                table[..., column], changed = rng.normal(size=table.shape[:-1]), changed + 1
    other.source[:, DRAWN_FROM] = rng.normal(size=(2, len(DRAWN_FROM)))
    assert changed >= 5
    one, two = (reveal(sees, simulation, each) for each in (episodes, other))
    for (name, mine), yours in zip(one.arrays().items(), two.arrays().values(), strict=True):
        np.testing.assert_array_equal(mine, yours, err_msg=name)


@pytest.mark.parametrize("steps", [0, 7])
@pytest.mark.parametrize("env", LENGTHS)
def test_the_state_reveals_no_later_draws(env: str, steps: int) -> None:
    simulation = find_problem(env).simulation()
    episodes = halfway(simulation, range(2), steps)
    other, rng = episodes.pick(np.arange(2)), np.random.default_rng(0)
    drawn = np.setdiff1d(np.arange(len(TapeRow._fields)), LISTED)
    for i, block in enumerate(episodes.block):
        later = other.tape[i, block + 1 :]
        later[:, drawn] = rng.uniform(0.5, 2.0, (len(later), len(drawn)))
    other.source[:, DRAWN_FROM] = rng.normal(size=(2, len(DRAWN_FROM)))
    one, two = (reveal("state", simulation, each) for each in (episodes, other))
    for (name, mine), yours in zip(one.arrays().items(), two.arrays().values(), strict=True):
        np.testing.assert_array_equal(mine, yours, err_msg=name)
    # a policy that sees the future gets later draws
    known = [reveal("future", simulation, each).tape for each in (episodes, other)]
    assert not np.array_equal(*known)


@pytest.mark.parametrize("sees", ["state", "future"])
@pytest.mark.parametrize("env", LENGTHS)
def test_revealed_episodes_cost_as_much_as_the_true_ones(env: str, sees: str) -> None:
    # one step; with the future, all steps
    simulation = shortened(env, 3)
    episodes = halfway(simulation, range(3), 1)
    shown = reveal(sees, simulation, episodes)
    if sees == "future":
        costs = [roll_out(Fixed(11_000.0, 1, 2), simulation, each).cost for each in (episodes, shown)]
    else:
        choice = np.full(3, 11_000.0), np.ones(3)
        costs = [simulation.step(each, *choice)[0] for each in (episodes, shown)]
    np.testing.assert_array_equal(*costs)


@pytest.mark.parametrize("env", BESIDES)
def test_hindsight_costs_no_more_than_any_fixed_plan(env: str) -> None:
    simulation, seeds = shortened(env, 5), range(3)
    planned = run_seeds(Hindsight(sweeps=1), simulation, seeds)
    plans = [Fixed(E, D, every) for E in (6000.0, 12_000.0, 20_000.0) for D in (0, 1) for every in (1, 2, 4)]
    fixed = np.array([run_seeds(plan, simulation, seeds).cost for plan in plans])
    assert (planned.cost <= fixed.min(axis=0)).all()
    # there is something to gain
    assert planned.cost.mean() < 0.98 * fixed.mean(axis=1).min()


def test_hindsight_plans_each_episode_as_if_alone() -> None:
    simulation, seeds = shortened("power_limited", 2), range(EPISODES_AT_ONCE + 2)
    together = run_seeds(Hindsight(sweeps=0), simulation, seeds)
    alone = [run_seeds(Hindsight(sweeps=0), simulation, [seed]).cost[0] for seed in (seeds[0], seeds[-1])]
    assert together.cost[[0, -1]].tolist() == alone

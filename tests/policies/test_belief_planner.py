import numpy as np
import pytest
from scipy.interpolate import RegularGridInterpolator

from grind_env.belief.wheel_belief import BeliefError
from grind_env.envs.simulation import Simulation
from grind_env.policies.choices import all_choices
from grind_env.policies.episode_columns import COST, PRESSURE
from grind_env.policies.evaluation import episode_seeds, run_seeds, start_episodes
from grind_env.policies.planners import cost_to_go as module
from grind_env.policies.planners.belief_planner import BeliefPlanner
from grind_env.policies.planners.cost_to_go import KA, between, dullness, place, worth
from grind_env.policies.problem_lookup import find_problem
from grind_env.policies.registry import check_names, make_policy, policy_names
from grind_env.policies.tuned_parameters import ConfigError
from tests.policies.harness import simulated

PLATES = simulated("power_limited")
SMALL = BeliefPlanner(members=8, speeds=6)


def test_interpolation_agrees_with_scipy_and_extrapolates_on_request():
    rng = np.random.default_rng(0)
    axes = [np.sort(rng.uniform(size=n)) for n in (4, 3, 5)]
    table = rng.normal(size=(2, 4, 3, 5))
    points = np.stack([rng.uniform(axis[0], axis[-1], 50) for axis in axes], axis=1)
    first = rng.integers(0, 2, 50)
    found = between(table, first, *(place(axis, values) for axis, values in zip(axes, points.T, strict=True)))
    theirs = [RegularGridInterpolator(axes, table[k])(point)[0] for k, point in zip(first, points, strict=True)]
    assert found == pytest.approx(theirs)
    line = np.array([0.0, 1.0, 3.0])
    ends = np.array([-1.0, 4.0])
    assert between(line[None], np.zeros(2, int), place(line, ends, beyond=True)) == pytest.approx(ends)
    assert between(line[None], np.zeros(2, int), place(line, ends)) == pytest.approx([0.0, 3.0])


def cost_of_known_states(simulation: Simulation, n: int) -> np.ndarray:
    """Return the cost of episodes of known state, which take the choice with the least cost plus cost to go."""
    table, every = worth(simulation), all_choices(simulation.task, 10)
    state, total, count = start_episodes(simulation, episode_seeds("training", n)), np.zeros(n), len(every.speeds)
    for block in range(simulation.task.blocks):
        tape = np.minimum(np.arange(block, block + 2), simulation.task.blocks - 1)
        branches = state.pick(np.repeat(np.arange(n), count))
        branches = branches.window(state.tape[:, tape], np.repeat(np.arange(n), count), 0, 2)
        coming = np.repeat(state.coming(), count, axis=0)
        cost = simulation.step(branches, np.tile(every.speeds, n), np.tile(every.executions, n))[0][:, COST]
        lot = np.log(coming[:, KA]), np.log(coming[:, PRESSURE])
        rows = table.course.number[simulation.branches.rows_of(coming)]
        places = table.places(*lot, dullness(branches.wheels), np.zeros(n * count))
        best = (cost + between(table.after(block), rows, *places)).reshape(n, count).argmin(axis=1)
        total += simulation.step(state, every.speeds[best], every.executions[best])[0][:, COST]
    return total


def test_the_table_predicts_the_cost_of_known_states(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(module, "DOUBT", 0.01)
    cost, table = cost_of_known_states(PLATES, 128), worth(PLATES)
    says = float(np.sum(table.lots * table.before[0, 0, :, :, 0, 0]))
    assert says == pytest.approx(cost.mean(), abs=2.0 * cost.std() / np.sqrt(len(cost)) + 0.1 * says)


def test_a_dull_wheel_a_fast_lot_and_little_time_cost_more():
    table = worth(simulated("rush"))
    assert table.period == 8
    middle = table.before[40]
    assert (np.diff(middle, axis=1) > -0.2).all()
    of_lots = np.diff(middle[:, :, :, [0, -1]], axis=3)
    # with the most time left the effect of a lot is small and shows in the mean over the wheels only
    assert (of_lots[..., :-1] > 0.0).all() and (of_lots.mean(axis=1) > 0.0).all()
    assert (np.diff(middle, axis=4) < 0.05).all()
    # at the end nothing is left to pay
    assert (table.before[-1] == 0.0).all()


def test_the_belief_planner_is_cheaper_than_the_fixed_plan():
    seeds = episode_seeds("validation", 16)
    ours = run_seeds(make_policy("belief_planner", PLATES), PLATES, seeds)
    plan = run_seeds(make_policy("constant", PLATES), PLATES, seeds)
    assert ours.cost.mean() < 0.8 * plan.cost.mean()


@pytest.mark.parametrize("task", ["power_limited", "wide_rails", "rush"])
def test_an_episode_does_not_depend_on_other_episodes(task: str):
    simulation, seeds = simulated(task), episode_seeds("validation", 3)
    together, alone = (run_seeds(SMALL, simulation, part) for part in (seeds, seeds[1:2]))
    assert np.array_equal(together.speeds[1:2], alone.speeds)
    assert np.array_equal(together.executions[1:2], alone.executions)


def test_the_belief_planner_is_not_listed_and_needs_a_compiled_simulation(monkeypatch):
    assert "belief_planner" not in policy_names(PLATES)
    assert list(check_names(PLATES, ["belief_planner"])) == ["belief_planner"]
    executed = find_problem("power_limited").simulation()
    monkeypatch.setattr(executed, "compiled", False)
    with pytest.raises(ConfigError, match=r"no policy 'belief_planner' for power_limited: .*, empirical_rule$"):
        make_policy("belief_planner", executed)
    with pytest.raises(BeliefError, match="is not followed by a belief"):
        worth(executed)

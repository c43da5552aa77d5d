import numpy as np
import pytest

from agents.dynamic_programming import cheapest_of_each, exact_optimum, forward_plans
from agents.evaluate import episode_seeds, evaluate, start_episodes
from agents.hindsight import Hindsight, moved, moves, plan_cost, sweep
from agents.planners import all_choices
from agents.policy import Decision
from agents.registry import make_policy
from agents.scripted import Fixed
from grind_env.envs.simulation import Simulation
from grind_env.envs.tasks import load_task
from grind_env.errors import GrindError

TASK, ORACLE = load_task("power_limited"), load_task("oracle6")
EPISODES = 8


@pytest.fixture(scope="module")
def runs():
    """Every policy on the same training episodes."""
    names = ("constant", "interval", "power_threshold", "adaptive_rule", "full_state_rule", "mpc", "hindsight")
    seeds = episode_seeds("training", EPISODES)
    return {name: evaluate(make_policy(name, TASK), TASK, seeds) for name in names}


def test_the_optimum_of_oracle6():
    optimum = exact_optimum(ORACLE)
    assert optimum.cost == pytest.approx(17.4850, rel=1e-3)
    assert optimum.runner_up == pytest.approx(17.5251, rel=1e-3)
    assert (optimum.speeds / 1000.0).tolist() == [21, 6, 14, 21, 6, 6]
    assert optimum.executions.tolist() == [1, 0, 0, 1, 0, 0]


def test_an_optimum_needs_a_task_without_chance():
    with pytest.raises(GrindError, match="power_limited has no exact optimum"):
        exact_optimum(TASK)


@pytest.mark.parametrize("policy", [Hindsight(), make_policy("mpc", ORACLE)])
def test_planners_find_the_optimum_of_oracle6(policy):
    run = evaluate(policy, ORACLE, [0])
    assert run.cost[0] == pytest.approx(exact_optimum(ORACLE).cost, rel=1e-12)


def test_published_gaps_of_oracle6():
    # scenarios, section 4.2: constant per kind 4.5 %, constant 34 %, random 59 % above the optimum
    optimum = exact_optimum(ORACLE).cost
    gaps = {
        name: float(evaluate(make_policy(name, ORACLE), ORACLE, range(400 if name == "random" else 1)).cost.mean())
        for name in ("constant_per_kind", "constant", "random")
    }
    assert gaps["constant_per_kind"] / optimum == pytest.approx(1.045, abs=0.002)
    assert gaps["constant"] / optimum == pytest.approx(1.34, abs=0.01)
    assert gaps["random"] / optimum == pytest.approx(1.59, abs=0.05)


def test_more_knowledge_costs_less(runs):
    cost = {name: float(run.cost.mean()) for name, run in runs.items()}
    assert cost["hindsight"] < cost["mpc"] < cost["adaptive_rule"] < min(cost["constant"], cost["interval"])
    assert cost["hindsight"] < cost["full_state_rule"] < cost["adaptive_rule"]


def test_hindsight_is_the_cheapest_in_every_episode(runs):
    for name, run in runs.items():
        assert (runs["hindsight"].cost <= run.cost).all(), name


def test_never_dressing_costs_eight_times_the_best_fixed_plan(runs):
    best = min(runs[name].cost.mean() for name in ("constant", "interval"))
    for E in (3.0, 5.0, 8.0, 12.0, 20.0, 30.0):
        assert evaluate(Fixed(E, 0), TASK, episode_seeds("training", EPISODES)).cost.mean() > 8.0 * best


def test_a_sweep_never_makes_a_plan_dearer():
    simulation = Simulation(TASK)
    start = start_episodes(simulation, episode_seeds("training", 4))
    plan = Decision(np.full((4, 60), 10000.0), np.ones((4, 60)))
    better = sweep(simulation, start, plan, np.random.default_rng(0))
    before, after = plan_cost(simulation, start, *(np.stack(pair) for pair in zip(plan, better, strict=True)))
    assert (after < 0.9 * before).all()
    assert (plan.speeds == 10000.0).all()


def test_plan_cost_is_the_cost_of_following_the_plan():
    simulation = Simulation(TASK)
    start = start_episodes(simulation, [3, 4])
    cost = plan_cost(simulation, start, np.full((1, 2, 60), 9000.0), np.ones((1, 2, 60)))
    assert cost[0] == pytest.approx(evaluate(Fixed(9.0, 1), TASK, [3, 4]).cost, rel=1e-12)


def test_forward_plans_do_not_depend_on_the_episodes_beside():
    simulation = Simulation(ORACLE)
    many = forward_plans(simulation, start_episodes(simulation, range(20)))
    assert (many.speeds == many.speeds[0]).all()
    assert (many.executions == many.executions[0]).all()


def test_moves_begin_with_the_plan_and_stay_legal():
    plan = Decision(np.array([[3000.0, 9000.0], [30000.0, 9000.0]]), np.array([[0.0, 3.0], [3.0, 0.0]]))
    speeds, executions = moves(TASK, plan, np.random.default_rng(0))
    assert np.array_equal(speeds[0], plan.speeds)
    assert np.array_equal(executions[0], plan.executions)
    assert ((speeds >= 3000.0) & (speeds <= 30000.0) & (speeds == np.floor(speeds))).all()
    assert ((executions >= 0.0) & (executions <= 3.0)).all()
    # an execution moves to the neighbour block only as a whole
    assert set(map(tuple, executions[:, 0])) == {(0.0, 3.0), (1.0, 3.0), (1.0, 2.0)}


def test_levels_of_speed_move_by_one():
    speeds = np.array([6000.0, 9000.0, 21000.0])
    assert moved(ORACLE, speeds, np.array([1.05, 1.05, 1.05])).tolist() == [9000.0, 14000.0, 21000.0]
    assert moved(ORACLE, speeds, np.array([0.9, 0.9, 0.9])).tolist() == [6000.0, 6000.0, 14000.0]


def test_cheapest_of_each_group():
    cost = np.array([3.0, 1.0, 2.0, 5.0, 4.0])
    owner, kind = np.array([1, 0, 0, 1, 1]), np.array([7, 7, 7, 8, 8])
    assert cheapest_of_each(cost, owner).tolist() == [1, 0]
    assert cheapest_of_each(cost, kind, owner).tolist() == [1, 0, 4]


def test_all_choices_are_every_pair():
    speeds, executions = all_choices(ORACLE, 0)
    pairs = set(zip(speeds.tolist(), executions.tolist(), strict=True))
    assert pairs == {(E, D) for E in (6000.0, 9000.0, 14000.0, 21000.0) for D in (0.0, 1.0)}
    assert len(all_choices(TASK, 14).speeds) == 14 * 4

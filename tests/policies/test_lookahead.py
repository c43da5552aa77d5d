import dataclasses

import numpy as np
import pytest

from grind_env.belief.filter_quantities import Belief
from grind_env.envs.blocks.task_simulation import BlockSimulation
from grind_env.envs.cost import Outcome
from grind_env.envs.tasks import Spread, load_task
from grind_env.policies.choices import speed_grid
from grind_env.policies.evaluation import episode_seeds, run_seeds
from grind_env.policies.planners.known_state import FullStateRule
from grind_env.policies.registry import make_policy
from grind_env.policies.scripted.belief_rule import BeliefRule
from grind_env.policies.scripted.look_ahead import LookAhead
from grind_env.process.stroke_types import WheelState
from tests.policies.harness import simulated
from tests.policies.optimum import exact_optimum

ORACLE = simulated("oracle6")
COST = Outcome._fields.index("cost")
A, LOADING = WheelState._fields.index("A"), WheelState._fields.index("lam")
RULE = {
    "E": (11.3e3, 7.2e3),
    "A_dress": (0.02, 0.012),
    "gA": -0.4,
    "gF": 0.1,
    "gH": 0.2,
    "wV": 0.3,
    "wH": 0.6,
    "gK": 0.2,
}


def cost_of_dress(task):
    """Return the cost of a dress: time at the hourly rate, wheel volume and diamond."""
    volume = task.dress.passes * task.dress.depth * np.pi * task.wheel.diameter * task.wheel.width
    return task.rates.hourly * task.dress_seconds / 3600.0 + task.rates.wheel * volume + task.rates.dress


def costs(task, simulation, episodes, E, D, usual, price, growth):
    """Return the cost of each choice for the next block up to the end of the part, with the price of a dull wheel."""
    branches = episodes.pick(np.zeros(len(E), int))
    cost, found = simulation.step(branches, E, D)[0][:, COST], []
    whole = task.kinds[int(episodes.tape[0, episodes.block[0], 0])].ends_part
    for dresses in (0.0, 1.0):
        ahead, total = branches.pick(np.arange(len(E))), cost
        if not whole:
            outcomes, _ = simulation.step(ahead, np.full(len(E), usual), np.full(len(E), dresses))
            total = total + outcomes[:, COST]
        if ahead.block[0] < task.blocks:
            dullness = ahead.wheels[:, A] + 0.02 * ahead.wheels[:, LOADING]
            total = total + price * cost_of_dress(task) * (dullness / 0.015) ** growth
        found.append(total)
    return np.minimum(*found)


@pytest.mark.parametrize(("name", "blocks"), [("oracle6", 6), ("power_limited", 8), ("wide_rails", 100), ("rush", 8)])
def test_with_a_true_belief_look_ahead_takes_the_cheapest_choice(name, blocks):
    task = dataclasses.replace(load_task(name), spread=Spread())  # nothing is drawn: the belief is the truth
    price, growth = 1.5, 2.0
    policy = LookAhead(price=(price,) * len(task.kinds), growth=(growth,) * len(task.kinds))
    simulation = BlockSimulation(task)
    episodes = simulation.start([np.random.default_rng(0)])
    policy.begin(simulation, 1)
    usual = dict.fromkeys(range(len(task.kinds)), 12000.0)
    for block in range(blocks):
        decision = policy.act(simulation.observe(episodes), None)
        grid, D = speed_grid(task, 8), np.arange(task.action.executions + 1.0)
        E = np.concatenate([np.repeat(grid, len(D)), decision.speeds])
        dresses = np.concatenate([np.tile(D, len(grid)), decision.executions])
        kind = int(episodes.tape[0, block, 0])
        found = costs(task, simulation, episodes, E, dresses, usual.get(kind + 1), price, growth)
        assert found[-1] <= found[:-1].min() + 1e-9
        usual[kind] = float(decision.speeds[0])
        simulation.step(episodes, *decision)


def test_a_price_of_the_dull_wheel_brings_look_ahead_near_the_optimum():
    optimum = exact_optimum(ORACLE).cost
    policies = [LookAhead(price=(price,) * 2, growth=(1.5,) * 2) for price in (0.0, 0.75)]
    blind, seeing = (run_seeds(policy, ORACLE, range(1)) for policy in policies)
    assert blind.cost[0] > 1.05 * optimum
    assert optimum <= seeing.cost[0] < 1.01 * optimum


def test_look_ahead_hurries_when_late_and_saves_a_scarce_layer():
    rush, cbn = simulated("rush"), simulated("CBN")
    seeds = episode_seeds("training", 4)

    def run(simulation, **changes):
        kinds = len(simulation.task.kinds)
        return run_seeds(LookAhead(price=(1.0,) * kinds, growth=(1.5,) * kinds, **changes), simulation, seeds)

    assert run(rush, haste=4.0).speeds.mean() > 1.01 * run(rush, haste=0.0).speeds.mean()
    assert run(cbn, layer=0.1).executions.mean() < 0.9 * run(cbn, layer=0.0).executions.mean()


@pytest.mark.bits
def test_a_look_ahead_decision_does_not_depend_on_other_episodes():
    simulation = simulated("power_limited")
    seeds = episode_seeds("training", 3)
    policy = LookAhead(price=(1.0,), growth=(1.5,))
    together, alone = run_seeds(policy, simulation, seeds), run_seeds(policy, simulation, seeds[1:2])
    assert np.array_equal(together.speeds[1], alone.speeds[0])
    assert np.array_equal(together.executions[1], alone.executions[0])


def test_the_belief_rule_on_a_true_belief_equals_the_full_state_rule():
    believing = BeliefRule(**RULE, wK=0.5)
    knowing = FullStateRule(**RULE, wK=0.5, gR=0.0)
    run, reference = (run_seeds(policy, ORACLE, range(1)) for policy in (believing, knowing))
    assert np.array_equal(run.speeds, reference.speeds)
    assert np.array_equal(run.executions, reference.executions)
    assert len(set(run.speeds[0])) > 1


def test_the_belief_rule_follows_its_formula_on_the_belief():
    simulation = simulated("power_limited")
    plain = {"E": (10_000.0,), "A_dress": (0.018,), "gA": -0.5, "gF": 0.0, "gH": 0.0, "wV": 0.0, "wH": 0.0}
    spread = []

    class Watched(BeliefRule):
        def act(self, observation, episodes):
            decision = super().act(observation, episodes)
            belief = Belief(*self.belief.beliefs.T)
            area, loading = (self.belief.wheels[:, :, column].mean(axis=1) for column in (A, LOADING))
            dullness = (area + 0.02 * loading) * np.exp(belief.pressure)
            speeds = 10000.0 * np.sqrt(0.015 / dullness) * np.exp(0.3 * belief.growth)
            assert decision.speeds == pytest.approx(np.clip(speeds, 3000.0, 30000.0), abs=0.51)
            assert np.array_equal(decision.executions, dullness * np.exp(0.4 * belief.growth) > 0.018)
            spread.append((np.std(belief.growth), np.std(belief.pressure), decision.executions.mean()))
            return decision

    run_seeds(Watched(**plain, gK=0.3, wK=0.4), simulation, episode_seeds("training", 8))
    # every term of the formula varied
    assert (np.mean(spread, axis=0) > 0.01).all()


def test_the_belief_rule_is_cheaper_than_the_adaptive_rule():
    # validation episodes: full state < belief < estimate of the sharpness alone
    simulation, seeds = simulated("power_limited"), episode_seeds("validation", 48)
    names = ("full_state_rule", "belief_rule", "adaptive_rule")
    cost = [float(run_seeds(make_policy(name, simulation), simulation, seeds).cost.mean()) for name in names]
    assert cost[0] < cost[1] < 0.95 * cost[2]

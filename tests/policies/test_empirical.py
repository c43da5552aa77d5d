from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from grind_env.envs.blocks.task_simulation import BlockSimulation
from grind_env.envs.cost import Outcome
from grind_env.envs.tasks import load_task
from grind_env.policies.evaluation import cost_per_good_part, episode_seeds, run_seeds
from grind_env.policies.problem_lookup import find_problem
from grind_env.policies.scripted.empirical_rule import EmpiricalRule, first_speeds, usual_volumes
from grind_env.policies.scripted.learned_laws import PartLaw, PowerLaw
from grind_env.policies.scripted.rules import Fixed
from tests.policies.harness import decide, observation, simulated

PLATES, RAILS, SHOP = (simulated(name) for name in ("power_limited", "wide_rails", "job_shop"))
PLATE = find_problem("grind_env/examples/plate_g82.nc", parts=4).simulation()
GROUND = {"last_pick": 0.02, "last_width": 50.0, "pick": 0.02, "width": 50.0, "length": 300.0, "stock": 1.0}


def test_the_power_law_recovers_the_exponents_of_its_readings() -> None:
    rng, law = np.random.default_rng(0), PowerLaw(2)
    for _ in range(300):
        rate, volume = rng.uniform(50.0, 400.0, 2), rng.uniform(0.0, 400.0, 2)
        read = np.array([True, False])
        law.learn(np.exp(2.0 + 0.8 * np.log(rate) + 0.2 * np.log(volume + 10.0)), rate, volume, read)
    assert law.found[0] == pytest.approx([2.0, 0.8, 0.2], abs=0.05)
    assert law.known.tolist() == [True, False]
    assert law.found[1].tolist() == [0.0, 0.7, 0.15]
    # at the removal rate for a power the law gives this power
    wanted = law.removal(np.full(2, 3000.0), np.full(2, 90.0))[0]
    assert 2.0 + 0.8 * np.log(wanted) + 0.2 * np.log(100.0) == pytest.approx(np.log(3000.0), abs=0.03)


def test_each_machine_learns_its_own_law() -> None:
    alone, beside = PowerLaw(1), PowerLaw(2)
    for power in (2000.0, 2500.0, 2200.0):
        alone.learn(np.array([power]), np.array([200.0]), np.array([50.0]), np.ones(1, bool))
        beside.learn(np.array([9000.0, power]), np.array([100.0, 200.0]), np.full(2, 50.0), np.ones(2, bool))
    assert beside.found[1] == pytest.approx(alone.found[0])


def test_the_part_law_raises_E_for_parts_well_below_their_limit() -> None:
    law, kinds = PartLaw(1, np.array([0.4, 0.3, 0.0]), exponent=0.5, usual=0.5, memory=100.0), np.array([1])
    for _ in range(200):
        law.learn(np.array([0.4]), kinds, np.array([2.0]), np.ones(1, bool))
    # 0.4 (E / 2)^0.5 = 0.65
    assert law.speed(kinds)[0] == pytest.approx(2.0 * (0.65 / 0.4) ** 2, rel=0.05)
    assert law.speed(np.array([0]))[0] == pytest.approx((0.65 / 0.5) ** 2)
    assert law.speed(np.array([2]))[0] == np.inf


def test_first_speeds_come_from_the_handbook_or_the_program() -> None:
    assert first_speeds(PLATES).tolist() == [6000.0]
    assert first_speeds(PLATE).tolist() == [15000.0, 9000.0]
    # there the infeed sets the depth of a stroke, and the cross pick sets its width
    for name in ("reciprocation", "wide_plates"):
        assert first_speeds(find_problem(name).simulation()).tolist() == [12000.0]


def test_usual_volumes_follow_the_conductivity() -> None:
    # 34.3 W/(m K) of 52100, 50 of 1020, 11.4 of Inconel 718
    assert usual_volumes(SHOP, 4.0) == pytest.approx([137.2, 137.2, 200.0])
    assert usual_volumes(simulated("blades"), 4.0) == pytest.approx([45.6, 45.6])
    # a fifth, because an edge of 12 mm grinds a plate of 60 mm
    assert usual_volumes(find_problem("wide_plates").simulation(), 4.0) == pytest.approx([137.2 / 5.0])


def test_E_rises_step_by_step_while_power_is_left() -> None:
    seen = [observation(PLATES, **GROUND)]
    for speed in (6000.0, 7500.0, 9375.0):
        seen.append(observation(PLATES, peak_power=0.15 * speed, last_speed=speed, **GROUND))
    # the usual Ra of parts that nobody has gauged limits the last E to (0.65 / 0.5)^2
    speeds = [E for E, _ in decide(EmpiricalRule(step=1.25), PLATES, *seen)]
    assert speeds == [6000.0, 7500.0, 9375.0, 10140.0]


def test_power_beyond_the_limit_leads_to_a_dress_and_then_to_a_lower_E() -> None:
    def after(power: float, executions: float) -> tuple[float, float]:
        ground = GROUND | {"last_speed": 6000.0, "last_executions": executions, "volume": 30.0}
        first = observation(PLATES, **GROUND)
        return decide(EmpiricalRule(), PLATES, first, observation(PLATES, peak_power=power, **ground))[1]

    assert after(4000.0, 0.0)[1] == 0.0
    assert after(5100.0, 0.0) == (6000.0, 1.0)
    assert after(6100.0, 1.0) == (6000.0, 2.0)
    assert after(6100.0, 2.0) == (5400.0, 2.0)


def test_thick_or_hot_parts_lead_to_a_dress_and_a_shorter_interval() -> None:
    def executions(error: float) -> list[float]:
        ground = GROUND | {"last_speed": 6000.0, "tolerance": 20.0, "peak_power": 2000.0}
        seen = [observation(PLATES, **GROUND), observation(PLATES, size_error=error, volume=20.0, **ground)]
        seen.append(observation(PLATES, last_executions=1.0, volume=20.0, **ground))
        return [D for _, D in decide(EmpiricalRule(), PLATES, *seen)][1:]

    assert executions(5.0) == [0.0, 0.0]
    # 20 + 90 mm3/mm turned out too much for one dress interval
    assert executions(21.0)[0] >= 1.0
    assert executions(-14.0)[0] >= 1.0
    assert executions(-14.0)[1] == 3.0


def test_a_thick_part_limits_the_volume_before_its_dress() -> None:
    rule = EmpiricalRule()
    ground = GROUND | {"last_speed": 6000.0, "tolerance": 20.0, "peak_power": 2000.0, "last_executions": 1.0}
    begin = observation(PLATES, **(GROUND | {"volume": 60.0}))
    decide(rule, PLATES, begin, observation(PLATES, size_error=21.0, volume=10.0, **ground))
    # the dress came half-way through a block of some 90 mm3/mm
    assert 0.65 * 95.0 < rule.volumes[0, 0] < 0.65 * 115.0


def test_no_dress_comes_right_before_the_finish_of_a_part() -> None:
    rough = observation(RAILS, coming_rough=1.0, volume=200.0, stock=1.0, length=300.0)
    finish = observation(RAILS, coming_finish=1.0, volume=290.0, stock=1.0, length=300.0, peak_power=6100.0)
    again = observation(RAILS, coming_rough=1.0, volume=299.0, stock=1.0, length=300.0)
    assert [D for _, D in decide(EmpiricalRule(), RAILS, finish, again, rough)] == [0.0, 2.0, 2.0]


FORCES = dict.fromkeys(("u_ch", "kp", "kc", "pm"), 1.35)


@pytest.mark.parametrize("factors", [{}, FORCES, {"kA": 3.0}], ids=["nominal", "forces", "growth"])
def test_the_empirical_rule_is_near_the_best_fixed_plan_of_a_machine(factors: dict[str, float]) -> None:
    task = load_task("power_limited")
    simulation = BlockSimulation(replace(task, factors={**task.factors, **factors}))
    seeds = episode_seeds("validation", 16)
    rule = run_seeds(EmpiricalRule(), simulation, seeds)
    plans = [Fixed(E, D, every) for E in (4000.0, 6000.0, 8000.0) for D, every in ((1, 1), (3, 1), (1, 2))]
    costs = [cost_per_good_part(plan.cost, plan.good) for plan in (run_seeds(p, simulation, seeds) for p in plans)]
    assert cost_per_good_part(rule.cost, rule.good) < 1.3 * min(costs)


def test_without_a_tolerance_the_size_error_does_not_matter() -> None:
    ground = GROUND | {"last_speed": 6000.0, "peak_power": 900.0, "size_error": 500.0}
    task = load_task("power_limited")
    free = BlockSimulation(replace(task, kinds=(replace(task.kinds[0], tolerance=0.0, roughness_limit=0.0),)))
    first = observation(free, **GROUND)
    # a step starts from the E that was ground, even if another policy chose it
    assert decide(EmpiricalRule(step=1.25), free, first, *[observation(free, **ground)] * 4)[-1] == (7500.0, 0.0)


def test_the_time_of_a_program_block_is_its_strokes_and_some_handling() -> None:
    rows, speeds = np.array([0, 1]), np.array([15_000.0, 9000.0])
    seconds = PLATE.branches.seconds(rows, speeds)
    plate: Any = PLATE
    episodes = plate.with_spread(0.0).start([np.random.default_rng(0)])
    for k in rows:
        outcomes, _ = PLATE.step(episodes, speeds[k : k + 1], np.zeros(1))
        # the outcome adds loading, gauging and the moves between
        assert 0.0 < outcomes[0, Outcome._fields.index("seconds")] - seconds[k] < 40.0

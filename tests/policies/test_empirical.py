from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from grind_env.envs.blocks.task_simulation import BlockSimulation
from grind_env.envs.cost import Outcome
from grind_env.envs.tasks import load_task
from grind_env.policies.evaluation import cost_per_good_part, episode_seeds, run_seeds
from grind_env.policies.problem import find_problem
from grind_env.policies.scripted.empirical_rule import EmpiricalRule, first_speeds, usual_volumes
from grind_env.policies.scripted.learned_laws import PartLaw, PowerLaw
from grind_env.policies.scripted.rules import Fixed
from tests.policies.harness import decide, observation, simulated

PLATES, RAILS, SHOP = (simulated(name) for name in ("power_limited", "wide_rails", "job_shop"))
PLATE = find_problem("grind_env/examples/plate_g82.nc", parts=4).simulation()
GROUND = {"last_pick": 0.02, "last_width": 50.0, "pick": 0.02, "width": 50.0, "length": 300.0, "stock": 1.0}


def test_the_law_finds_the_exponents_that_the_readings_were_made_with() -> None:
    rng, law = np.random.default_rng(0), PowerLaw(2)
    for _ in range(300):
        rate, volume = rng.uniform(50.0, 400.0, 2), rng.uniform(0.0, 400.0, 2)
        read = np.array([True, False])
        law.learn(np.exp(2.0 + 0.8 * np.log(rate) + 0.2 * np.log(volume + 10.0)), rate, volume, read)
    assert law.found[0] == pytest.approx([2.0, 0.8, 0.2], abs=0.05)
    assert law.known.tolist() == [True, False]
    assert law.found[1].tolist() == [0.0, 0.7, 0.15]
    # the rate at which it asks for a power is where the law has that power
    wanted = law.removal(np.full(2, 3000.0), np.full(2, 90.0))[0]
    assert 2.0 + 0.8 * np.log(wanted) + 0.2 * np.log(100.0) == pytest.approx(np.log(3000.0), abs=0.03)


def test_one_machine_learns_nothing_of_another() -> None:
    alone, beside = PowerLaw(1), PowerLaw(2)
    for power in (2000.0, 2500.0, 2200.0):
        alone.learn(np.array([power]), np.array([200.0]), np.array([50.0]), np.ones(1, bool))
        beside.learn(np.array([9000.0, power]), np.array([100.0, 200.0]), np.full(2, 50.0), np.ones(2, bool))
    assert beside.found[1] == pytest.approx(alone.found[0])


def test_parts_of_half_their_ra_may_be_ground_faster_by_the_root_of_what_is_left() -> None:
    law, kinds = PartLaw(1, np.array([0.4, 0.3, 0.0]), exponent=0.5, usual=0.5, memory=100.0), np.array([1])
    for _ in range(200):
        law.learn(np.array([0.4]), kinds, np.array([2.0]), np.ones(1, bool))
    # 0.4 (E / 2)^0.5 = 0.65
    assert law.speed(kinds)[0] == pytest.approx(2.0 * (0.65 / 0.4) ** 2, rel=0.05)
    assert law.speed(np.array([0]))[0] == pytest.approx((0.65 / 0.5) ** 2)
    assert law.speed(np.array([2]))[0] == np.inf


def test_it_begins_at_the_speed_of_the_handbook_or_of_the_program() -> None:
    assert first_speeds(PLATES).tolist() == [6000.0]
    assert first_speeds(PLATE).tolist() == [15000.0, 9000.0]
    # what sets the depth of a stroke there is the infeed, and what sets its width the cross pick
    for name in ("reciprocation", "wide_plates"):
        assert first_speeds(find_problem(name).simulation()).tolist() == [12000.0]


def test_usual_volumes_are_those_of_the_conductivity() -> None:
    # 34.3 W/(m K) of 52100, 50 of 1020, 11.4 of Inconel 718
    assert usual_volumes(SHOP, 4.0) == pytest.approx([137.2, 137.2, 200.0])
    assert usual_volumes(simulated("blades"), 4.0) == pytest.approx([45.6, 45.6])
    # a fifth, for the edge of 12 mm grinds a plate of 60 mm
    assert usual_volumes(find_problem("wide_plates").simulation(), 4.0) == pytest.approx([137.2 / 5.0])


def test_speed_rises_with_the_power_that_is_left_step_by_step() -> None:
    seen = [observation(PLATES, **GROUND)]
    for speed in (6000.0, 7500.0, 9375.0):
        seen.append(observation(PLATES, peak_power=0.15 * speed, last_speed=speed, **GROUND))
    # the last one is as fast as the Ra of parts is trusted that nobody has gauged, (0.65 / 0.5)^2
    speeds = [E for E, _ in decide(EmpiricalRule(step=1.25), PLATES, *seen)]
    assert speeds == [6000.0, 7500.0, 9375.0, 10140.0]


def test_a_power_beyond_the_limit_is_dressed_away_and_only_then_slowed_down() -> None:
    def after(power: float, executions: float) -> tuple[float, float]:
        ground = GROUND | {"last_speed": 6000.0, "last_executions": executions, "volume": 30.0}
        first = observation(PLATES, **GROUND)
        return decide(EmpiricalRule(), PLATES, first, observation(PLATES, peak_power=power, **ground))[1]

    assert after(4000.0, 0.0)[1] == 0.0
    assert after(5100.0, 0.0) == (6000.0, 1.0)
    assert after(6100.0, 1.0) == (6000.0, 2.0)
    assert after(6100.0, 2.0) == (5400.0, 2.0)


def test_parts_that_are_too_thick_or_hot_are_dressed_against_and_shorten_the_interval() -> None:
    def executions(error: float) -> list[float]:
        ground = GROUND | {"last_speed": 6000.0, "tolerance": 20.0, "peak_power": 2000.0}
        seen = [observation(PLATES, **GROUND), observation(PLATES, size_error=error, volume=20.0, **ground)]
        seen.append(observation(PLATES, last_executions=1.0, volume=20.0, **ground))
        return [D for _, D in decide(EmpiricalRule(), PLATES, *seen)][1:]

    assert executions(5.0) == [0.0, 0.0]
    # 20 + 90 mm3/mm after 13 turned out too many
    assert executions(21.0)[0] >= 1.0
    assert executions(-14.0)[0] >= 1.0
    assert executions(-14.0)[1] == 3.0


def test_a_wheel_that_was_dressed_in_its_block_was_too_dull_before() -> None:
    rule = EmpiricalRule()
    ground = GROUND | {"last_speed": 6000.0, "tolerance": 20.0, "peak_power": 2000.0, "last_executions": 1.0}
    begin = observation(PLATES, **(GROUND | {"volume": 60.0}))
    decide(rule, PLATES, begin, observation(PLATES, size_error=21.0, volume=10.0, **ground))
    # the execution stood half-way in a block of some 90 mm3/mm
    assert 0.65 * 95.0 < rule.volumes[0, 0] < 0.65 * 115.0


def test_the_finish_of_a_part_is_not_ground_with_a_fresh_wheel() -> None:
    rough = observation(RAILS, coming_rough=1.0, volume=200.0, stock=1.0, length=300.0)
    finish = observation(RAILS, coming_finish=1.0, volume=290.0, stock=1.0, length=300.0, peak_power=6100.0)
    again = observation(RAILS, coming_rough=1.0, volume=299.0, stock=1.0, length=300.0)
    assert [D for _, D in decide(EmpiricalRule(), RAILS, finish, again, rough)] == [0.0, 2.0, 2.0]


FORCES = dict.fromkeys(("u_ch", "kp", "kc", "pm"), 1.35)


@pytest.mark.parametrize("factors", [{}, FORCES, {"kA": 3.0}], ids=["nominal", "forces", "growth"])
def test_it_is_near_the_plan_that_was_found_for_the_machine(factors: dict[str, float]) -> None:
    task = load_task("power_limited")
    simulation = BlockSimulation(replace(task, factors={**task.factors, **factors}))
    seeds = episode_seeds("validation", 16)
    rule = run_seeds(EmpiricalRule(), simulation, seeds)
    plans = [Fixed(E, D, every) for E in (4000.0, 6000.0, 8000.0) for D, every in ((1, 1), (3, 1), (1, 2))]
    costs = [cost_per_good_part(plan.cost, plan.good) for plan in (run_seeds(p, simulation, seeds) for p in plans)]
    assert cost_per_good_part(rule.cost, rule.good) < 1.3 * min(costs)


def test_a_part_without_limits_is_no_matter_of_size() -> None:
    ground = GROUND | {"last_speed": 6000.0, "peak_power": 900.0, "size_error": 500.0}
    task = load_task("power_limited")
    free = BlockSimulation(replace(task, kinds=(replace(task.kinds[0], tolerance=0.0, roughness_limit=0.0),)))
    first = observation(free, **GROUND)
    # and a step is one from what was ground, whoever has decided it
    assert decide(EmpiricalRule(step=1.25), free, first, *[observation(free, **ground)] * 4)[-1] == (7500.0, 0.0)


def test_a_block_of_a_program_takes_the_strokes_that_it_has() -> None:
    rows, speeds = np.array([0, 1]), np.array([15_000.0, 9000.0])
    seconds = PLATE.branches.seconds(rows, speeds)
    plate: Any = PLATE
    episodes = plate.with_spread(0.0).start([np.random.default_rng(0)])
    for k in rows:
        outcomes, _ = PLATE.step(episodes, speeds[k : k + 1], np.zeros(1))
        # beside them there are loading, gauging and the ways between
        assert 0.0 < outcomes[0, Outcome._fields.index("seconds")] - seconds[k] < 40.0

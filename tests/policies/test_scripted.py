import math

import numpy as np
import pytest

from grind_env.policies.choices import nearest_speed, speed_grid
from grind_env.policies.scripted.handbook import Handbook, handbook_speeds
from grind_env.policies.scripted.rules import AdaptiveRule, ConstantPerKind, Fixed, PowerThreshold, Random
from tests.policies.harness import decide, observation, simulated

PLATES, LEVELS = simulated("power_limited"), simulated("oracle6")
RULE = {
    "E": (10_000.0,), "A_dress": (0.02,), "gA": -0.5, "gF": 0.0, "gH": 0.0, "wV": 0.0, "wH": 1.0, "gS": 0.0, "wS": 0.0,
}  # fmt: skip
AFTER = {
    "last_speed": 12_000.0,
    "last_pick": 0.02,
    "last_width": 50.0,
    "diameter": 300.0,
    "volume": 120.0,
    "stock": 1.0,
}


def test_nearest_speed_is_whole_within_the_range_or_a_level():
    assert nearest_speed(PLATES.task, [1.0, 12345.6, 99999.0]).tolist() == [3000.0, 12346.0, 30000.0]
    assert nearest_speed(LEVELS.task, [1.0, 11000.0, 11500.0, 99999.0]).tolist() == [6000.0, 9000.0, 14000.0, 21000.0]


def test_speed_grid_is_geometric():
    assert speed_grid(PLATES.task, 3).tolist() == [3000.0, 9487.0, 30000.0]
    assert speed_grid(LEVELS.task, 9).tolist() == [6000.0, 9000.0, 14000.0, 21000.0]


def test_random_is_uniform_in_the_action_space():
    policy = Random(seed=1)
    policy.begin(PLATES, 20000)
    speeds, executions = policy.act(np.zeros((20000, len(PLATES.entries)), np.float32), None)
    # two thirds of the box dress nothing
    assert np.bincount(executions.astype(int)) == pytest.approx(20000.0 * np.array([6, 1, 1, 1]) / 9.0, rel=0.05)
    assert np.median(speeds) == pytest.approx(np.sqrt(3000.0 * 30000.0), rel=0.03)


def test_an_interval_dresses_in_every_nth_block():
    decisions = decide(Fixed(8000.0, 2, 3), PLATES, *[observation(PLATES)] * 6)
    assert decisions == [(8000.0, 0), (8000.0, 0), (8000.0, 2)] * 2


def test_constant_per_kind_follows_the_coming_kind():
    plate, gauge = observation(LEVELS, coming_plate=1.0), observation(LEVELS, coming_gauge=1.0)
    decisions = decide(ConstantPerKind((21_000.0, 6000.0), (1, 0)), LEVELS, plate, gauge, plate)
    assert decisions == [(21000.0, 1), (6000.0, 0), (21000.0, 1)]


def test_the_power_rule_dresses_from_the_upper_down_to_the_lower_threshold():
    # removal rate 0.02 * 50 * 200 = 200 mm3/s: 50, 70, 50, 39, 50 J/mm3 against 60 and 40
    powers = (10000.0, 14000.0, 10000.0, 7800.0, 10000.0)
    seen = [observation(PLATES, mean_power=power, **AFTER) for power in powers]
    rule = PowerThreshold(E=12_000.0, upper=60.0, lower=2.0 / 3.0, share=9.0)
    assert [D for _, D in decide(rule, PLATES, *seen)] == [0, 1, 1, 0, 0]


def test_the_power_rule_slows_down_near_the_limit_only():
    rule = PowerThreshold(E=12_000.0, upper=1e9, lower=1.0, share=0.8)
    low, high = (observation(PLATES, mean_power=power, **AFTER) for power in (3500.0, 8000.0))
    # 8000 W at 12 m/min where 0.8 * 5000 W are allowed: 12 * 4000/8000
    assert decide(rule, PLATES, low, high) == [(12000.0, 0), (6000.0, 0)]


def test_the_adaptive_rule_by_hand():
    # 7000 W are a wear-flat area of 0.0101142 (test_estimator): E = 10,000 (0.0101142/0.015)^-0.5 = 12,178 mm/min
    sharp = observation(PLATES, mean_power=7000.0, **AFTER)
    assert decide(AdaptiveRule(**RULE), PLATES, sharp) == [(12178.0, 0.0)]
    # twice the stock adds ln 2 to the dress criterion: 0.0202 is above 0.02
    assert decide(AdaptiveRule(**RULE), PLATES, observation(PLATES, mean_power=7000.0, **AFTER | {"stock": 2.0})) == [
        (12178.0, 1.0)
    ]
    # 9500 W: friction 2.96519 N/mm, area 0.0230959, E = 10,000 (0.0230959/0.015)^-0.5 = 8059 mm/min
    assert decide(AdaptiveRule(**RULE), PLATES, observation(PLATES, mean_power=9500.0, **AFTER)) == [(8059.0, 1.0)]


def test_the_adaptive_rule_follows_the_clock_and_the_layer():
    rule = RULE | {"E": (10_000.0,) * 3, "A_dress": (0.02,) * 3, "gP": 0.5, "wP": -1.0}
    rush, fresh = simulated("rush"), math.log(0.0095 / 0.015)
    unhurried = 10_000.0 * math.exp(-0.5 * fresh)
    # with a quarter of the time left, E doubles
    for slack, E in ((0.0, unhurried), (math.log(0.25), 2.0 * unhurried)):
        assert decide(AdaptiveRule(**rule), rush, observation(rush, slack=slack, stock=1.0)) == [
            (pytest.approx(E, abs=1.0), 0.0)
        ]
    # much time in hand makes a dress cheap: ln(0.0095) + ln 3 is above ln(0.02)
    assert decide(AdaptiveRule(**rule), rush, observation(rush, slack=math.log(3.0), stock=1.0))[0][1] == 1.0
    cbn = simulated("CBN")
    rule = RULE | {"E": (10_000.0,) * 2, "A_dress": (0.02,) * 2, "gB": 1.0, "wB": 2.0}
    few, many = (observation(cbn, executions_left=left, remaining=0.25, stock=1.0) for left in (15.0, 60.0))
    assert decide(AdaptiveRule(**rule), cbn, few) == [(pytest.approx(0.5 * unhurried, abs=1.0), 0.0)]
    # twice as many executions as blocks: E doubles, and ln(0.0095) + 2 ln 2 is above ln(0.02)
    assert decide(AdaptiveRule(**rule), cbn, many) == [(pytest.approx(2.0 * unhurried, abs=1.0), 1.0)]


def test_handbook_speeds():
    speeds = {"slot": 12, "job_shop": 15, "rush": 15, "blades": 10, "CBN": 20}
    for name, E in speeds.items():
        simulation = simulated(name)
        coming = observation(simulation, starts_part=1.0)
        assert decide(Handbook(), simulation, coming, coming) == [(1000.0 * E, 1.0)] * 2


def test_the_handbook_leaves_a_weak_spindle_a_fifth_of_its_power():
    # 50 mm x 0.02 mm at 40 J/mm3: 0.8 * 5000 W drive a table of 100 mm/s, where 12 m/min are usual
    simulation = simulated("power_limited")
    coming = observation(simulation, starts_part=1.0)
    assert decide(Handbook(), simulation, coming) == [(6000.0, 1.0)]
    # of a rail only the rough pick, 60 mm x 0.015 mm, is too much; the finish pick of 0.005 mm keeps the usual speed
    assert handbook_speeds(simulated("wide_rails").task).tolist() == [pytest.approx(6667.0, abs=50.0), 12000.0]

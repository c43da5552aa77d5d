import dataclasses
import math

import numpy as np
import pytest

from grind_env.envs.blocks.simulation import BlockSimulation
from grind_env.envs.tables import Outcome
from grind_env.envs.tasks import Spread
from grind_env.policies.scripted.burn_line import BurnLine
from grind_env.policies.scripted.roughness_gauge import RoughnessGauge
from grind_env.policies.scripted.size_threshold import SizeThreshold
from tests.policies.harness import decide, observation, simulated

PLATES, RAILS, SHOP = (simulated(name) for name in ("power_limited", "wide_rails", "job_shop"))
GROUND = {"last_speed": 12.0, "last_pick": 0.02, "last_width": 50.0, "diameter": 300.0}

# 52100 with an A60 J wheel, vw 200 mm/s, vs 30 m/s, de 300 mm, a 20 um, A 0.015
GRAIN = 20e-6 * (1.0 + 20.8 * 0.015)
PARTITION = 1.0 / (1.0 + 0.97 * 35.0 / (math.sqrt(34.3 * 7815.0 * 506.0) * math.sqrt(GRAIN * 30.0)))
BURNING = 6.2 + 7.18 * (0.88 / PARTITION) * 300.0**0.25 * 0.02**-0.75 * 200.0**-0.5
LINE = BURNING * 50.0 * 0.02 * 200.0
"""Power on the burning line, W."""


def test_the_size_rule_dresses_beyond_its_share_of_the_tolerance():
    parts = [observation(PLATES, size_error=error, tolerance=20.0) for error in (0.0, 9.0, 11.0, -11.0, 9.0)]
    assert decide(SizeThreshold((10.0,), (0.5,)), PLATES, *parts) == [
        (10000, 0),
        (10000, 0),
        (10000, 1),
        (10000, 1),
        (10000, 0),
    ]


def test_a_size_reading_is_held_against_the_tolerance_of_its_own_part():
    # the rough block of a rail has no tolerance; the error of the last rail is still that of 7 um
    rough = observation(RAILS, coming_rough=1.0, size_error=4.0)
    finish = observation(RAILS, coming_finish=1.0, size_error=4.0, tolerance=7.0)
    rule = SizeThreshold((20.0, 10.0), (0.5, 0.9))
    # before the first part there is nothing to compare with
    assert decide(rule, RAILS, rough, finish, rough, finish) == [
        (20000, 0), (10000, 0), (20000, 1), (10000, 0),
    ]  # fmt: skip
    # 6 um are too much for a gauge of 5 um, and no reason to dress after a wear plate of 18 um
    first = [observation(SHOP, tolerance=tolerance) for tolerance in (5.0, 18.0)]
    after = observation(SHOP, size_error=6.0, tolerance=9.0)
    rule = SizeThreshold((12.0,) * 3, (0.9,) * 3)
    assert [decide(rule, SHOP, each, after)[1][1] for each in first] == [1, 0]


def test_the_roughness_rule_dresses_while_the_reading_is_high_and_slows_down():
    readings_ = [observation(PLATES, roughness=ratio) for ratio in (0.0, 0.8, 0.95, 1.2, 0.5)]
    rule = RoughnessGauge((12.0,), (0.9,), near=0.8, slowing=2.0)
    # 12 (0.8/0.95)^2 = 8.5097, 12 (0.8/1.2)^2 = 5.3333
    assert decide(rule, PLATES, *readings_) == [(12000, 0), (12000, 0), (8510, 1), (5333, 1), (12000, 0)]


def test_the_burn_rule_dresses_beyond_its_margin_of_the_line():
    assert pytest.approx(8959.0, rel=1e-3) == LINE
    rule = BurnLine((12.0,), (0.8,), near=9.0, slowing=1.0)
    powers = (0.0, 0.79 * LINE, 0.81 * LINE)
    assert decide(rule, PLATES, *(observation(PLATES, mean_power=power, **GROUND) for power in powers)) == [
        (12000, 0), (12000, 0), (12000, 1),
    ]  # fmt: skip


def test_the_burn_rule_slows_down_beyond_the_nearness_of_the_line():
    rule = BurnLine((12.0,), (9.0,), near=0.5, slowing=0.5)
    low, high = (observation(PLATES, mean_power=share * LINE, **GROUND) for share in (0.49, 0.98))
    (first, _), (second, _) = decide(rule, PLATES, low, high)
    assert first == 12000.0
    assert second == pytest.approx(12000.0 * math.sqrt(0.5 / 0.98), abs=2.0)


def test_the_line_is_that_of_the_material_that_was_ground():
    # soft 1020 takes in more of the grain heat than 52100 (0.919 against 0.906), so that its line lies 1.4 % lower
    def dressed(kind):
        coming = observation(SHOP, **{f"coming_{kind}": 1.0})
        after = observation(SHOP, mean_power=0.98 * LINE, coming_gauge=1.0, **GROUND)
        return decide(BurnLine((12.0,) * 3, (0.987,) * 3, near=9.0, slowing=1.0), SHOP, coming, after)[1][1]

    assert (dressed("plate"), dressed("wear_plate")) == (0, 1)


def test_the_measured_ratio_is_about_the_burn_ratio_of_the_simulation():
    # of a spindle that does not slow: a slower one shows more load than it has power
    overrides = {**PLATES.task.setup.machine_overrides, "power_limit": 20_000.0}
    setup = dataclasses.replace(PLATES.task.setup, machine_overrides=overrides)
    simulation = BlockSimulation(dataclasses.replace(PLATES.task, setup=setup, spread=Spread()))
    episodes = simulation.start([np.random.default_rng(0)])
    ratios, true = [], []
    for _ in range(6):
        # the ratio lies between the last margin that dresses and the first that does not
        margins = np.linspace(0.2, 2.0, 181)
        seen = simulation.observe(episodes)
        if episodes.block[0]:
            dressed = [decide(BurnLine((9.0,), (margin,), 9.0, 1.0), simulation, seen)[0][1] for margin in margins]
            ratios.append(margins[int(sum(dressed))])
        outcomes, _ = simulation.step(episodes, np.array([9000.0]), np.array([0.0]))
        true.append(outcomes[0, Outcome._fields.index("burn_ratio")])
    # the simulation takes the highest of a block, at the real depth of cut and its own wear-flat area
    assert ratios == pytest.approx(true[:-1], rel=0.15)
    assert ratios == sorted(ratios)

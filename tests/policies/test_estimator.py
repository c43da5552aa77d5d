import math

import numpy as np
import pytest

from grind_env.envs.cost import Outcome
from grind_env.policies.episode_columns import AREA
from grind_env.policies.episode_columns import PRESSURE as PRESSURE_FACTOR
from grind_env.policies.scripted.sharpness_estimator import SharpnessEstimator
from tests.policies.harness import observation, simulated

TORQUE = Outcome._fields.index("peak_torque")
PLATES = simulated("power_limited")

# nominal values of the set-up: 52100 with an A60 J wheel, 30 m/s at 300 mm
CHIP_ENERGY, PLOUGHING, FRICTION, PRESSURE, SLOPE, THRESHOLD = 13.8, 0.62, 0.4, 68.0, 7e5, 0.25e-3


def block(power, **changes):
    """Return the readings after a block of 12 m/min, 20 um picks and 50 mm width on a 300 mm wheel."""
    values = {
        "last_speed": 12_000.0,
        "last_pick": 0.02,
        "last_width": 50.0,
        "diameter": 300.0,
        "volume": 120.0,
        "stock": 1.1,
    }
    return observation(PLATES, mean_power=power, **values | changes)


def power_of(area):
    """Return the mean power of `block` at a wear-flat area, W, by the equations of the model."""
    vw, vs = 200.0, 30.0
    curvature = 4.0 * vw / (300.0 * vs * 1000.0)
    rubbing = PLOUGHING + FRICTION * (PRESSURE + SLOPE * curvature) * area
    return 50.0 * vs * (CHIP_ENERGY * 0.02 * vw / vs + rubbing * math.sqrt((0.02 + THRESHOLD) * 300.0))


def started(n=1):
    return SharpnessEstimator(PLATES, n)


def test_wear_flat_area_from_power_by_hand():
    # 7000 W: Ft' = 7000/(50 * 30) = 4.66667; chips 13.8 * 0.02 * 200/30 = 1.84; contact sqrt(300 * 0.02025) = 2.46475;
    # ploughing 0.62 * 2.46475 = 1.52815; friction 1.29852 N/mm; pressure 68 + 7e5 * 8.8889e-5 = 130.222 N/mm2;
    # 0.4 * 130.222 * 2.46475 = 128.386; ratio 0.0101142
    estimate = started().update(block(7000.0))
    assert estimate.wear_flat[0] == pytest.approx(0.0101142, rel=1e-4)
    assert estimate.volume[0] == pytest.approx(120.0)
    assert estimate.stock[0] == pytest.approx(1.1)


def test_severity_by_hand():
    # (0.0145 - 0.0085) / 120 = 5e-5, twice the nominal rate: ln 2 with weight 1/1.5, then 1/2.5
    estimator = started()
    assert estimator.update(block(power_of(0.0145))).severity[0] == pytest.approx(math.log(2.0) / 1.5, rel=1e-3)
    second = estimator.update(block(power_of(0.0145))).severity[0]
    assert second == pytest.approx(math.log(2.0) * (1.0 - (1.0 - 1.0 / 1.5) * (1.0 - 1.0 / 2.5)), rel=1e-3)


def test_terms_of_severity_are_cut_at_two():
    estimator = started()
    for _ in range(40):
        estimate = estimator.update(block(power_of(0.05), volume=20.0))
    assert estimate.severity[0] == pytest.approx(2.0, rel=1e-3)


def test_a_new_lot_forgets_the_severity_of_the_old_one():
    estimator = started()
    estimator.update(block(power_of(0.0145)))
    assert estimator.update(block(power_of(0.0145), new_lot=1.0)).severity[0] == 0.0


def test_a_small_volume_does_not_change_the_severity():
    assert started().update(block(7000.0, volume=14.0)).severity[0] == 0.0


def test_no_power_means_a_fresh_wheel_and_low_power_the_smallest_area():
    estimator = started()
    assert estimator.update(block(0.0)).wear_flat[0] == 0.0095
    assert estimator.update(block(3000.0)).wear_flat[0] == 0.004


def test_restart_forgets_the_masked_episodes_only():
    estimator = started(2)
    both = np.repeat(block(power_of(0.0145)), 2, axis=0)
    estimator.update(both)
    estimator.restart(np.array([True, False]))
    severity = estimator.update(both).severity
    assert severity[0] == pytest.approx(math.log(2.0) / 1.5, rel=1e-3)
    assert severity[1] > severity[0]


def test_the_force_of_the_last_block_is_read_with_its_own_material():
    # wear flats press less on 1020; a block of another kind comes next
    shop = simulated("job_shop")
    task = shop.task
    p = task.parameters(task.kinds[2])
    assert p.pm != task.parameters(task.kinds[0]).pm
    vw, vs, area = 250.0, 30.0, 0.02
    curvature = 4.0 * vw / (300.0 * vs * 1000.0)
    rubbing = p.kp + p.mu * p.pm * (p.pa + p.pb * curvature) * area
    force = p.u_ch * 0.02 * vw / vs + rubbing * math.sqrt(300.0 * (0.02 + p.a0))
    last = {"last_speed": 15_000.0, "last_pick": 0.02, "last_width": 20.0, "diameter": 300.0, "volume": 90.0}

    estimator = SharpnessEstimator(shop, 1)
    assert estimator.update(observation(shop, coming_wear_plate=1.0)).kind[0] == 2.0
    after = estimator.update(observation(shop, coming_gauge=1.0, mean_power=20.0 * vs * force, **last))
    assert after.kind[0] == 0.0
    assert after.wear_flat[0] == pytest.approx(area, rel=1e-3)


def test_pressure_of_time_and_thrift_by_hand():
    # half the nominal time of the work is left: ln 2; 20 executions for 30 of 120 blocks: ln(2/3)
    rush, cbn = simulated("rush"), simulated("CBN")
    for simulation, values, expected in (
        (rush, {"slack": math.log(0.5)}, (math.log(2.0), 0.0)),
        (cbn, {"executions_left": 20.0, "remaining": 0.25}, (0.0, math.log(2.0 / 3.0))),
        (cbn, {"executions_left": 0.0, "remaining": 0.25}, (0.0, math.log(0.5 / 30.0))),
        (PLATES, {}, (0.0, 0.0)),
    ):
        estimator = SharpnessEstimator(simulation, 1)
        estimate = estimator.update(observation(simulation, **values))
        assert (estimate.pressed[0], estimate.thrift[0]) == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize("name", ["slot", "job_shop", "wide_rails", "blades", "power_limited"])
def test_the_estimate_follows_the_true_wear_flats_in_every_task(name):
    simulation = simulated(name)
    episodes = simulation.start([np.random.default_rng(seed) for seed in range(200)])
    estimator = SharpnessEstimator(simulation, 200)
    estimator.update(simulation.observe(episodes))
    stalled = np.zeros(200, bool)
    # the last block is no finish block: there heat feeds the wheel, and the power belongs to a depth unlike the pick
    for _ in range({"slot": 2, "job_shop": 6, "power_limited": 2, "wide_rails": 3, "blades": 5}[name]):
        outcomes, _ = simulation.step(episodes, np.full(200, 5000.0), np.zeros(200))
        stalled |= outcomes[:, TORQUE] >= 1.0
        pressure = episodes.tape[np.arange(200), episodes.block - 1, PRESSURE_FACTOR]
        estimate = estimator.update(simulation.observe(episodes))
    true = episodes.wheels[:, AREA] * pressure
    ground = ~stalled  # a wheel that has stalled grinds no more of the part
    assert ground.mean() > 0.7
    assert np.corrcoef(np.log(estimate.wear_flat[ground]), np.log(true[ground]))[0, 1] > 0.9
    # the estimate is too high where the load slows the spindle
    assert np.median(estimate.wear_flat[ground] / true[ground]) == pytest.approx(1.0, abs=0.25)

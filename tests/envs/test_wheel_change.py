import numpy as np
import pytest

from grind_env.envs.blocks.task_simulation import BlockSimulation
from grind_env.envs.cost import Outcome
from grind_env.envs.noise_tape import TapeRow
from grind_env.envs.observations import physical
from grind_env.envs.reset_options import Fixed, Given
from grind_env.envs.tasks import load_task
from grind_env.machine.loops.row_io import OWN_FROM
from grind_env.process.stroke_types import WheelState
from tests.envs.harness import start

CBN = BlockSimulation(load_task("CBN"), full=True)
N = 64
STEP = 2 * 3 * 0.004  #: mm of diameter that one execution takes off


def test_the_wheel_starts_with_8_to_26_executions_left() -> None:
    episodes = start(CBN, 3000)
    diameter = WheelState(*episodes.wheels[:, :OWN_FROM].T).ds
    left = (diameter - 290.0) / STEP
    assert 8.0 <= left.min() < 8.05 and 25.95 < left.max() <= 26.0
    assert left.mean() == pytest.approx(17.0, abs=5 * 18.0 / np.sqrt(12 * 3000))
    seen = physical(CBN.observe(episodes), CBN.entries)
    np.testing.assert_allclose(seen["executions_left"], left, rtol=1e-5)


def test_a_worn_out_wheel_is_replaced_by_a_new_one() -> None:
    episodes = start(CBN, N)
    diameters, flats, wheels = [WheelState(*episodes.wheels[:, :OWN_FROM].T).ds.copy()], [], []
    outcomes = []
    for _ in range(CBN.task.blocks):
        outcomes.append(CBN.step(episodes, np.full(N, 15000.0), np.ones(N))[0])
        wheels.append(WheelState(*episodes.wheels[:, :OWN_FROM].T.copy()))
        diameters.append(wheels[-1].ds)
        flats.append(wheels[-1].wd)
    outcome = Outcome(*np.moveaxis(np.array(outcomes), 2, 0))
    changed = outcome.change_cost > 0.0
    assert (changed.sum(axis=0) == 1).all()  # 120 executions: 8 to 26 of the old wheel, and the new one has 416
    np.testing.assert_array_equal(np.unique(outcome.change_cost), [0.0, 150.0])
    ds, wd = np.array(diameters), np.array(flats)
    assert (ds[1:][changed] == 300.0).all() and (ds[ds != ds[0]] >= 290.0).all()
    # the wheel was changed as soon as one more block had taken it below 290 mm
    before = ds[:-1][changed]
    worn = (ds[:-1] - ds[1:])[~changed].max() - STEP
    assert 0.0 < worn < 0.005
    assert (before >= 290.0).all() and (before - STEP - worn < 290.0).all()
    # 40 minutes more than a block without a change
    seconds = outcome.seconds
    block = np.argmax(changed, axis=0)
    usual = seconds[(block + 2) % 120, np.arange(N)]
    assert (np.abs(seconds[block, np.arange(N)] - usual - 2400.0) < 60.0).all()
    # the new wheel is mounted dressed, by the same diamond
    at = (block, np.arange(N))
    np.testing.assert_allclose(np.array([wheel.A for wheel in wheels])[at], dressed_flat(wd[at]), rtol=1e-6)
    for name in ("V", "lam", "W"):
        assert (np.array([getattr(wheel, name) for wheel in wheels])[at] == 0.0).all(), name
    seen = physical(CBN.observe(episodes), CBN.entries)
    # the gauge has a noise of 1.4 um and shows whole um
    np.testing.assert_allclose(seen["executions_left"], (ds[-1] - 290.0) / STEP, atol=5.0 * 0.0015 / STEP)


def dressed_flat(flat: np.ndarray) -> np.ndarray:
    """Return the wear-flat area of a dress 0.004 mm deep, 0.10 mm/rev, with a 0.5 mm diamond (model-2.md, section 2).

    A medium dress is 0.02 mm deep, with a sharp diamond that cuts a width of 0.28 mm.
    """
    severity = (0.004 / 0.02) / (1.0 + flat / 0.28)
    medium = CBN.task.parameters(CBN.task.kinds[0]).Ad
    return medium * (0.25 + 0.75 / np.sqrt(severity))


def test_the_new_wheel_draws_its_own_factors() -> None:
    tape = TapeRow(*np.moveaxis(start(CBN, 2000).tape, 2, 0))
    z = np.clip(np.random.default_rng(0).standard_normal(1_000_000), -1.8, 1.8).std()
    ratio = np.log(tape.spare_kA[:, 0] / tape.kA[:, 0])
    assert ratio.std() == pytest.approx(np.sqrt(2.0) * 0.30 * z, rel=0.06)
    # the scatter from part to part does not depend on the wheel
    own, spare = np.log(tape.ra_scale), np.log(tape.spare_ra_scale)
    np.testing.assert_allclose(spare - own, np.repeat((spare - own)[:, :1], CBN.task.blocks, axis=1), atol=1e-12)
    assert (spare - own)[:, 0].std() == pytest.approx(np.sqrt(2.0) * 0.07 * z, rel=0.06)
    assert spare[:, 0].std() == pytest.approx(np.hypot(0.07, 0.15) * z, rel=0.06)
    # the mean of 60 parts has little scatter of the parts: mainly the scatter of the two wheels is left
    assert np.corrcoef(spare.mean(axis=1), own.mean(axis=1))[0, 1] < 0.25


def test_the_factors_of_the_new_wheel_act_from_the_next_block_on() -> None:
    given = Given(fixed=Fixed(executions_left=0.5, wheel_kA=1.0, ra_scale=1.0))
    episodes = CBN.start([np.random.default_rng(0), np.random.default_rng(0)], [given] * 2)
    rough = TapeRow._fields.index("spare_ra_scale")
    episodes.tape[1, :, rough] *= 1.5
    speeds, ones = np.full(2, 15000.0), np.ones(2)
    first = Outcome(*CBN.step(episodes, speeds, ones)[0].T)
    assert (first.change_cost == 150.0).all() and first.roughness[0] == first.roughness[1]
    # nothing has been read of the new wheel
    assert (physical(CBN.observe(episodes), CBN.entries)["mean_power"] == 0.0).all()
    second = Outcome(*CBN.step(episodes, speeds, np.zeros(2))[0].T)
    assert second.roughness[1] > 1.2 * second.roughness[0]
    assert (physical(CBN.observe(episodes), CBN.entries)["mean_power"] > 0.0).all()

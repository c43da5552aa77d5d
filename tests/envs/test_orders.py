from dataclasses import replace

import numpy as np
import pytest

from grind_env.envs.blocks.task_simulation import BlockSimulation
from grind_env.envs.cost import Outcome
from grind_env.envs.noise_tape import TapeRow
from grind_env.envs.observations import physical
from grind_env.envs.reset_options import CONTEXT_FACTORS, Fixed, Given
from grind_env.envs.tasks import load_task
from tests.envs.harness import Array, rollout, start

EPISODES = 1500
RUSH = BlockSimulation(load_task("rush"))


def tape(name: str, count: int = EPISODES) -> TapeRow:
    """Return the tape, every column of shape (episodes, blocks)."""
    return TapeRow(*np.moveaxis(start(BlockSimulation(load_task(name)), count).tape, 2, 0))


def nominal_time(kind: Array) -> Array:
    """Return the nominal time of a block in s, by kind: E 12 m/min, 260 mm stroke, no dress, with loading."""
    stroke = 260.0 / 200.0 + 200.0 / 1000.0 + 0.15
    # ceil(H/a) plunges, one coverage stroke, L spark-out strokes: gauge, plate, wear plate
    strokes = np.array([10 + 1 + 4, 20 + 1 + 2, 20 + 1 + 1])
    return 20.0 + strokes[kind.astype(int)] * stroke


@pytest.mark.parametrize("name", ["job_shop", "rush"])
def test_an_order_has_one_kind_its_own_lot_and_one_to_eight_parts(name: str) -> None:
    t = tape(name)
    kinds, sizes = [], []
    for k, new, kA, pm in zip(t.kind, t.new_lot, t.kA, t.pm, strict=True):
        begins = np.flatnonzero(new)
        assert begins[0] == 0
        orders = np.split(np.arange(96), begins[1:])
        for order in orders:
            for column in (k, kA, pm):
                assert (column[order] == column[order[0]]).all()
        assert len(np.unique(kA)) > len(orders) / 2
        # the last order ends with the episode and may be cut
        kinds += [int(k[order[0]]) for order in orders]
        sizes += [len(order) for order in orders[:-1]]
    n = len(sizes)
    # the episode cuts its last order, so that long orders are a little rarer than one in eight
    share = np.bincount(sizes, minlength=9) / n
    assert share[0] == 0.0 and len(share) == 9
    np.testing.assert_allclose(share[1:], 1 / 8, atol=0.012)
    np.testing.assert_allclose(np.bincount(kinds) / len(kinds), 1 / 3, atol=5 * np.sqrt(2 / 9 / n))


def test_job_shop_draws_its_factors_as_published() -> None:
    t = tape("job_shop")
    begins = t.new_lot == 1.0
    z = np.clip(np.random.default_rng(0).standard_normal(1_000_000), -1.8, 1.8).std()
    assert np.log(t.kA[begins]).std() == pytest.approx(np.hypot(0.70 * z, 0.30 * z), rel=0.03)
    assert np.log(t.pm[begins]).std() == pytest.approx(0.08 * z, rel=0.03)
    relative = t.stock / np.array([0.06, 0.20, 0.40])[t.kind.astype(int)]
    # on whole micrometres
    assert relative.min() >= 0.5 - 0.0005 / 0.06
    assert relative.std() == pytest.approx(0.20, rel=0.03)
    assert (t.gauged - t.stock).std() == pytest.approx(0.004, rel=0.02)
    for column in (t.due, t.work, t.is_due):
        assert (column == 0.0).all()


def test_due_dates_follow_the_nominal_work() -> None:
    t = tape("rush")
    work = nominal_time(t.kind)
    period = work.reshape(EPISODES, 12, 8).sum(axis=2)
    due = t.due.reshape(EPISODES, 12, 8)
    assert (due == due[:, :, :1]).all()
    factor = np.diff(due[:, :, 0], axis=1, prepend=0.0) / period
    assert 0.7 <= factor.min() < 0.705 and 1.295 < factor.max() <= 1.3
    assert factor.mean() == pytest.approx(1.0, abs=5 * 0.6 / np.sqrt(12 * factor.size))
    assert np.corrcoef(factor[:, :-1].ravel(), factor[:, 1:].ravel())[0, 1] == pytest.approx(0.0, abs=0.03)
    left = np.cumsum(work.reshape(EPISODES, 12, 8)[:, :, ::-1], axis=2)[:, :, ::-1].reshape(EPISODES, 96)
    np.testing.assert_allclose(t.work, left, rtol=1e-12)
    np.testing.assert_array_equal(t.is_due, np.tile(np.arange(96) % 8 == 7, (EPISODES, 1)))


def test_the_nominal_time_is_the_time_at_nominal_stock() -> None:
    given = Given(fixed=Fixed(stock=1.0))
    episodes = RUSH.start([np.random.default_rng(3)], [given])
    work = nominal_time(episodes.tape[0, :, 0])
    outcome, _, _ = rollout(RUSH, episodes, 12000.0, 0.0)
    np.testing.assert_allclose(outcome.seconds[:, 0], work, rtol=1e-12)


@pytest.mark.parametrize(("speed", "dresses"), [(3000.0, 3.0), (12000.0, 1.0), (25000.0, 0.0)])
def test_lateness_costs_600_dollars_an_hour_without_limit(speed: float, dresses: float) -> None:
    episodes = start(RUSH, 32)
    due = TapeRow(*np.moveaxis(episodes.tape, 2, 0)).due.T.copy()
    outcome, _, observations = rollout(RUSH, episodes, speed, dresses)
    clock = np.cumsum(outcome.seconds, axis=0)
    late = np.maximum(clock - due, 0.0)
    late[np.arange(96) % 8 != 7] = 0.0
    np.testing.assert_allclose(outcome.late_cost, 600.0 * late / 3600.0, rtol=1e-9, atol=1e-9)
    if speed == 3000.0:
        assert late[-1].min() > 3600.0  # an hour and more at the end, and still counting
        assert (np.diff(late[7::8], axis=0) > 0.0).all()
    plain = BlockSimulation(replace(load_task("job_shop"), dress=RUSH.task.dress))
    without, _, _ = rollout(plain, start(plain, 32), speed, dresses)
    np.testing.assert_array_equal(outcome.scrap_cost, without.scrap_cost)
    np.testing.assert_allclose(outcome.cost - outcome.late_cost, without.cost, rtol=1e-9)

    seen = physical(observations, RUSH.entries)
    before = np.concatenate([np.zeros((1, 32)), clock[:-1]])
    margin = due - before
    np.testing.assert_allclose(seen["time_to_due"][:-1], margin, rtol=1e-4, atol=0.05)
    work = TapeRow(*np.moveaxis(episodes.tape, 2, 0)).work.T
    slack = np.log(np.maximum(margin / work, 0.05))
    np.testing.assert_allclose(seen["slack"][:-1], np.minimum(slack, 5.0), rtol=1e-4, atol=1e-4)
    assert (seen["slack"][-1] == 0.0).all() and (seen["time_to_due"][-1] == 0.0).all()


def test_a_dress_serves_the_next_order_of_another_kind() -> None:
    # a wheel dressed in the last block of an order is sharp for the first one of the next, of another kind
    task = load_task("job_shop")
    simulation = BlockSimulation(task)
    fixed = Fixed(**{name: factor.nominal for name, factor in CONTEXT_FACTORS.items()})
    kinds = task.numbers(("wear_plate", "wear_plate", "gauge"), "")
    episodes = simulation.start([np.random.default_rng(0), np.random.default_rng(0)], [Given(fixed, kinds)] * 2)
    speeds = np.full(2, 12000.0)
    dressed = np.array([0.0, 1.0])
    outcomes = [simulation.step(episodes, speeds, dressed * (k == 1))[0] for k in range(3)]
    gauge = Outcome(*outcomes[2].T)
    assert gauge.peak_power[1] < 0.97 * gauge.peak_power[0]

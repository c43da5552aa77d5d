"""The ensemble filter is exact where the answer is known, and close to the truth elsewhere."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grind_env.belief.ensemble_filter import adjust, learn
from grind_env.belief.filter_quantities import Belief, Hidden, Signals
from grind_env.belief.wheel_belief import BeliefError, WheelBelief, hypercube
from grind_env.envs.block_kind_rows import kind_row
from grind_env.envs.blocks.task_simulation import BlockSimulation
from grind_env.envs.cost import Outcome
from grind_env.envs.filter_members import MemberModel
from grind_env.envs.observation_memory import belief_entries
from grind_env.envs.observations import bounds, physical
from grind_env.envs.reset_options import Fixed, Given
from grind_env.envs.simulation import Simulation
from grind_env.envs.task_names import task_names
from grind_env.envs.tasks import Spread, Task, load_task
from grind_env.kernel import logistic
from grind_env.machine.loops.stroke_totals import Tally
from grind_env.policies.problem_lookup import find_problem
from grind_env.policies.scripted.sharpness_estimator import SharpnessEstimator
from grind_env.process.stroke_types import WheelState
from tests.envs.harness import Array, assert_same, start
from tests.examples import few, nightly

PLATES, RAILS, BLADES = (load_task(name) for name in ("power_limited", "wide_rails", "blades"))
#: blades scored only by the heat near the finished surface
FINISHED = dataclasses.replace(
    BLADES, kinds=tuple(dataclasses.replace(kind, rise_allowance=0.0) for kind in BLADES.kinds)
)
RISE, TORQUE = (Outcome._fields.index(name) for name in ("rise", "peak_torque"))


def run(
    task: Task,
    count: int,
    seed: int,
    speeds: tuple[float, float] = (6000.0, 16000.0),
    given: Given | None = None,
    make: type[BlockSimulation] = BlockSimulation,
) -> dict[str, Array]:
    """Return beliefs and truth before every block and after the last, under random plans; shape (blocks + 1, N)."""
    simulation = make(task, full=True, pre_dress=True)
    rngs = [np.random.default_rng(seed + i) for i in range(count)]
    episodes, rng = simulation.start(rngs, None if given is None else [given] * count), np.random.default_rng(seed)
    belief = WheelBelief(MemberModel(simulation))
    belief.begin(count)
    found: dict[str, list[Array]] = {
        name: [] for name in (*Belief._fields, "A", "ln_kA", "rise", "torque", "observation")
    }
    rise, torque = np.zeros((2, count))
    for k in range(task.blocks + 1):
        observation = simulation.observe(episodes)
        truth = physical(observation, simulation.entries)
        for name, value in belief.update(observation)._asdict().items():
            found[name].append(value)
        growth = np.log(truth["growth"])
        for name, value in (("A", truth["wear_flat"]), ("ln_kA", growth), ("rise", rise), ("torque", torque)):
            found[name].append(value)
        found["observation"].append(observation)
        if k < task.blocks:
            E = np.floor(np.exp(rng.uniform(*np.log(speeds), count)))
            D, pre_dress = (rng.random((2, count)) < [[0.3], [0.1]]).astype(float)
            outcomes, _ = simulation.step(episodes, E, D, pre_dress)
            rise, torque = outcomes[:, RISE], outcomes[:, TORQUE]
    return {name: np.array(values) for name, values in found.items()}


def r2(truth: Array, prediction: Array) -> float:
    return float(1.0 - np.mean((truth - prediction) ** 2) / np.var(truth))


# --- the adjustment against Bayes' rule ----------------------------------------------------------------------


@given(st.integers(0, 10**6), st.integers(3, 40), st.floats(0.05, 5.0), st.floats(-3.0, 3.0))
def test_adjust_gives_the_exact_gaussian_posterior(seed: int, members: int, sigma: float, reading: float) -> None:
    states = np.random.default_rng(seed).normal(size=(4, members))
    states[1] += 0.7 * states[0]
    mean, covariance = states.mean(axis=1), np.cov(states)
    gain = covariance[:, 0] / (covariance[0, 0] + sigma**2)
    adjust(states, 0, reading, sigma)
    np.testing.assert_allclose(states.mean(axis=1), mean + gain * (reading - mean[0]), atol=1e-10)
    np.testing.assert_allclose(np.cov(states), covariance - np.outer(gain, covariance[0]), atol=1e-10)


def test_adjust_changes_nothing_if_all_members_agree() -> None:
    states = np.array([[2.0, 2.0, 2.0], [0.0, 1.0, 2.0]])
    adjust(states, 0, 5.0, 0.1)
    assert states.tolist() == [[2.0, 2.0, 2.0], [0.0, 1.0, 2.0]]


LIMIT = PLATES.machine.power_limit
READINGS = {
    "all": (3000.0, 2800.0, 3300.0),
    "small": (60.0, 40.0, 70.0),
    "no full plunge since the dress": (0.0, 2800.0, 3300.0),
    "the first at the end of its range": (3000.0, 5.0 * LIMIT, 3300.0),
    "none": (0.0, 0.0, 0.0),
}


@pytest.mark.parametrize("read", READINGS.values(), ids=list(READINGS))
def test_learn_applies_bayes_rule_to_logarithms_with_the_sensor_noise(read: tuple[float, float, float]) -> None:
    members, noise, rng = 12, 1.5, np.random.default_rng(1)
    level = max(read) or 3000.0
    powers = level * np.exp(0.2 * rng.normal(size=(3, members)))
    hidden, wheels = rng.normal(size=(members, len(Hidden._fields))), np.ones((members, len(WheelState._fields)))
    results = np.zeros((members, len(Tally._fields)))
    column = Tally._fields.index
    latest = [column(f"power_{number}") for number in range(1, 5)]
    results[:, latest], results[:, column("last_count")] = np.outer(powers[0], [0.7, 0.9, 1.1, 1.3]), 4.0
    results[:, column("first_power")], results[:, column("first_count")] = 6.0 * powers[1], 6.0
    results[:, column("peak_load")] = powers[2]
    results[:, column("plunge_rise")] = rng.uniform(300.0, 900.0, members)
    area = WheelState._fields.index("A")
    wheels[:, area] = 0.02 * np.exp(0.3 * rng.normal(size=members))

    # the textbook update of mean and covariance, one reading after the other
    states = np.vstack([hidden.T, np.log(wheels[:, area]), np.log(powers + 1.0)])
    mean, covariance = states.mean(axis=1), np.cov(states)
    for k, reading in enumerate(read):
        row = len(Hidden._fields) + 1 + k
        if 0.0 < reading < 5.0 * LIMIT:
            sigma = noise * (0.03 + 20.0 / np.exp(mean[row]))
            gain = covariance[:, row] / (covariance[row, row] + sigma**2)
            mean = mean + gain * (np.log(reading + 1.0) - mean[row])
            covariance = covariance - np.outer(gain, covariance[row])

    seen = Signals(*read, speed=12_000.0, executions=1.0, pre_dress=0.0, diameter=300.0, new_lot=0.0)
    learn(kind_row(PLATES, PLATES.kinds[0]), seen, noise, 1e9, results, wheels, hidden)
    learnt = np.vstack([hidden.T, np.log(wheels[:, area])])
    np.testing.assert_allclose(learnt.mean(axis=1), mean[: len(learnt)], atol=1e-9)
    np.testing.assert_allclose(np.cov(learnt), covariance[: len(learnt), : len(learnt)], atol=1e-9)


def test_learn_caps_the_wear_flat_area_at_its_limit() -> None:
    members = 6
    hidden, wheels = np.zeros((members, len(Hidden._fields))), np.ones((members, len(WheelState._fields)))
    area = WheelState._fields.index("A")
    wheels[:, area] = np.linspace(0.15, 0.24, members)
    results = np.zeros((members, len(Tally._fields)))
    results[:, Tally._fields.index("peak_load")] = np.linspace(5000.0, 8000.0, members)
    seen = Signals(0.0, 0.0, 12_000.0, speed=12_000.0, executions=1.0, pre_dress=0.0, diameter=300.0, new_lot=0.0)
    learn(kind_row(PLATES, PLATES.kinds[0]), seen, 1.0, 0.25, results, wheels, hidden)
    assert wheels[:, area].max() == 0.25


def test_hypercube_draws_latin_hypercube_samples() -> None:
    samples = hypercube(5, 16)
    assert samples.shape == (5, 16, len(Hidden._fields))
    np.testing.assert_allclose(samples.mean(axis=1), 0.0, atol=1e-12)
    np.testing.assert_allclose(samples.std(axis=1, ddof=1), 1.0)
    layers = np.searchsorted(np.sort(samples[0, :, 0]), samples)
    assert (np.sort(layers, axis=1) == np.arange(16)[:, None]).all()
    assert len({tuple(column) for sample in layers for column in sample.T}) == 5 * len(Hidden._fields)


# --- the filter ----------------------------------------------------------------------------------------------


#: least ratio of the largest to the smallest wear-flat area; short light grinding dulls less
LEAST_DULLED = {"noise": 1.1}


@pytest.mark.parametrize("name", [*task_names(), nightly("reciprocation"), nightly("wide_plates")])
def test_the_belief_is_exact_in_a_task_without_randomness(name: str) -> None:
    # through dresses, pre-dresses, orders, ageing coolant and new wheels
    simulation = find_problem(name).simulation()
    found = run(dataclasses.replace(simulation.task, spread=Spread()), 8, 3, make=type(simulation))
    np.testing.assert_allclose(found["wear_flat"], found["A"], rtol=2e-5)
    assert found["wear_flat_spread"].max() < 1e-6
    assert found["A"].max() > LEAST_DULLED.get(name, 1.2) * found["A"].min()


def test_the_belief_uses_the_material_that_the_observation_shows() -> None:
    shop = dataclasses.replace(load_task("job_shop"), spread=Spread())
    soft = Given(Fixed(material=float(shop.materials.index("aisi_1020"))))
    found = run(shop, 8, 3, given=soft)
    np.testing.assert_allclose(found["wear_flat"], found["A"], rtol=2e-5)
    assert not np.allclose(found["A"], run(shop, 8, 3)["A"], rtol=0.01)


@pytest.mark.nightly
def test_a_wheel_change_widens_the_belief_about_the_wheel() -> None:
    task = load_task("CBN")
    found = run(task, 48, 4)
    diameter = physical(found["observation"], BlockSimulation(task, full=True, pre_dress=True).entries)["diameter"]
    changed = np.diff(diameter, axis=0) > 1.0
    assert changed.sum() >= 24
    spread = found["growth_spread"]
    assert spread[1:][changed].mean() > spread[:-1][changed].mean() + 0.02
    # the new wheel is dressed by a diamond with an unknown wear flat
    miss = np.abs(found["wear_flat"] - found["A"])[1:][changed]
    assert (miss < 2.0 * found["wear_flat_spread"][1:][changed]).mean() > 0.9
    assert (miss < 0.15 * found["A"][1:][changed]).all()


def test_the_first_belief_is_the_prior_of_the_task() -> None:
    simulation = BlockSimulation(PLATES)
    first = WheelBelief(MemberModel(simulation), 64)
    first.begin(3)
    belief = first.update(simulation.observe(start(simulation, 3)))
    # variance of a standard normal number clipped at 1.8
    c = 1.8
    tail = 0.5 * math.erfc(c / math.sqrt(2.0))
    density = math.exp(-0.5 * c * c) / math.sqrt(2.0 * math.pi)
    cut = math.sqrt((1.0 - 2.0 * tail) - 2.0 * c * density + 2.0 * c * c * tail)
    spread = PLATES.spread
    np.testing.assert_allclose(belief.growth, 0.0, atol=1e-3)
    np.testing.assert_allclose(belief.growth_spread, cut * math.hypot(spread.wheel_growth, spread.lot_growth), rtol=0.1)
    np.testing.assert_allclose(belief.pressure_spread, cut * spread.lot_pressure, rtol=0.03)
    assert (belief.burnt == 0.0).all()


@pytest.mark.nightly
def test_a_new_lot_resets_the_belief_about_the_lot() -> None:
    found = run(PLATES, 64, 11)
    new = physical(found["observation"], BlockSimulation(PLATES, full=True, pre_dress=True).entries)["new_lot"] > 0.5
    new[0] = False
    later, known = new[1:], ~new[1:] & ~new[:-1]
    assert later.sum() > 200
    # 16 members cannot sample the lot quite independently of the wheel
    assert found["growth_spread"][1:][later].min() > 0.7 * PLATES.spread.lot_growth
    assert found["growth_spread"][1:][later].mean() > 0.95 * PLATES.spread.lot_growth
    assert found["growth_spread"][1:][known].mean() < 0.75 * PLATES.spread.lot_growth
    np.testing.assert_allclose(found["pressure"][1:][later], 0.0, atol=1e-3)
    # the belief about the wheel stays, for the wheel is the same
    assert np.ptp(found["growth"][1:][later]) > 0.1


# without dresses the wheel of the plates dulls to a level set by the table speed, which hides part of its growth
@pytest.mark.parametrize(
    ("task", "least", "growth"), [(PLATES, 0.88, 0.25), (RAILS, 0.91, 0.5)], ids=["plates", "rails"]
)
def test_the_belief_follows_the_wear_better_than_the_formula(task: Task, least: float, growth: float) -> None:
    found = run(task, 96, 20_000)
    measuring = BlockSimulation(task)
    estimator, names = SharpnessEstimator(measuring), [entry.name for entry in measuring.entries]
    entries = BlockSimulation(task, full=True, pre_dress=True).entries
    measured = [k for k, entry in enumerate(entries) if entry.name in names]
    estimator.begin(96)
    formula = np.array([estimator.update(each[:, measured]).wear_flat for each in found["observation"]])
    truth, mean, spread = (found[name][1:-1] for name in ("A", "wear_flat", "wear_flat_spread"))
    assert r2(truth, mean) > least
    assert np.mean((mean - truth) ** 2) < 0.3 * np.mean((formula[1:-1] - truth) ** 2)
    assert 0.85 < np.mean(np.abs(mean - truth) < 2.0 * spread) < 0.98
    assert r2(found["ln_kA"][1:-1], found["growth"][1:-1]) > growth


def test_a_stalled_spindle_does_not_lead_the_belief_astray() -> None:
    # after a stall the wheel passes above the part: these readings say nothing about the wheel
    for task in (PLATES, RAILS):
        found = run(task, 48, 20_000, speeds=(12_000.0, 30_000.0))
        stalled = found["torque"][1:] >= 1.0
        assert stalled.mean() > 0.02
        ratio = found["wear_flat"][1:] / found["A"][1:]
        assert (ratio[stalled] > 0.4).all() and (ratio[stalled] < 2.5).all()


# always predicting the mean would give an R2 of 0
@pytest.mark.parametrize(("name", "least"), few([("reciprocation", 0.80), ("wide_plates", 0.92)]))
def test_the_belief_follows_the_wear_under_other_cycles(name: str, least: float) -> None:
    simulation = find_problem(name).simulation()
    found = run(simulation.task, 64, 40_000, make=type(simulation))
    truth, mean, spread = (found[each][1:-1] for each in ("A", "wear_flat", "wear_flat_spread"))
    assert r2(truth, mean) > least
    assert 0.85 < np.mean(np.abs(mean - truth) < 2.0 * spread) < 0.98


def test_a_simulation_without_compiled_blocks_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    simulation = find_problem("oracle6").simulation()
    monkeypatch.setattr(simulation, "compiled", False)
    with pytest.raises(BeliefError, match="oracle6 is not followed by a belief, which grinds compiled blocks: use"):
        MemberModel(simulation)


# at speeds at which some parts burn and others do not
@pytest.mark.parametrize(
    ("task", "speeds", "least"),
    [
        (BLADES, (10_000.0, 30_000.0), 0.9),
        (load_task("CBN"), (3000.0, 9000.0), 0.85),
        (FINISHED, (10_000.0, 30_000.0), 0.9),
    ],
    ids=["blades", "CBN", "finish only"],
)
def test_the_belief_estimates_the_probability_of_burn(task: Task, speeds: tuple[float, float], least: float) -> None:
    found = run(task, 96, 30_000, speeds=speeds)
    limits = [task.limits(task.kinds[task.kind_of_block(k)]).rise for k in range(task.blocks)]
    truth = np.array(
        [
            [logistic((rise - limit) / 12.0) for rise in row]
            for row, limit in zip(found["rise"][1:], limits, strict=True)
        ]
    )
    assert 0.01 < truth.mean() < 0.5
    assert r2(truth, found["burnt"][1:]) > least
    # burn is believed as often as it occurs
    assert found["burnt"][1:].mean() == pytest.approx(truth.mean(), rel=0.15)


def test_every_member_has_the_measured_diameter() -> None:
    simulation = BlockSimulation(PLATES)
    observation = simulation.observe(start(simulation, 2))
    observation[1, [entry.name for entry in simulation.entries].index("diameter")] -= 0.25
    belief = WheelBelief(MemberModel(simulation), 4)
    belief.begin(2)
    belief.update(observation)
    diameters = belief.wheels[:, :, WheelState._fields.index("ds")]
    np.testing.assert_allclose(diameters, [[300.0] * 4, [280.0] * 4], rtol=1e-6)


# --- bookkeeping ---------------------------------------------------------------------------------------------


def beliefs_of(simulation: Simulation, observations: Array, masks: Array | None = None) -> list[Belief]:
    belief = WheelBelief(MemberModel(simulation), 8)
    belief.begin(observations.shape[1])
    masks = np.ones(observations.shape[:2], bool) if masks is None else masks
    return [belief.update(each, mask) for each, mask in zip(observations, masks, strict=True)]


def test_the_belief_of_an_episode_does_not_depend_on_its_neighbours() -> None:
    simulation = BlockSimulation(BLADES, full=True, pre_dress=True)
    observations = run(BLADES, 6, 5)["observation"][:12]
    together = beliefs_of(simulation, observations)
    turned = beliefs_of(simulation, observations[:, ::-1])
    for i in range(6):
        alone = beliefs_of(simulation, observations[:, i : i + 1])
        for a, b, c in zip(together, turned, alone, strict=True):
            for x, y, z in zip(a, b, c, strict=True):
                assert x[i] == y[5 - i] == z[0]


def test_the_belief_reads_measured_entries_only() -> None:
    full = BlockSimulation(BLADES, full=True, pre_dress=True)
    observations = run(BLADES, 4, 6)["observation"][:12]
    measured = [k for k, entry in enumerate(full.entries) if entry.noise != "hidden"]
    measuring = BlockSimulation(BLADES, pre_dress=True)
    assert measuring.entries == tuple(full.entries[k] for k in measured)
    assert len(measured) < len(full.entries)
    assert_same(beliefs_of(full, observations), beliefs_of(measuring, observations[..., measured]))


def test_a_masked_update_and_a_restart_touch_the_masked_episodes_only() -> None:
    simulation = BlockSimulation(BLADES, full=True, pre_dress=True)
    observations = run(BLADES, 2, 7)["observation"][:10]
    alone = [beliefs_of(simulation, observations[:, i : i + 1]) for i in range(2)]
    belief = WheelBelief(MemberModel(simulation), 8)
    belief.begin(2)
    pair = np.empty_like(observations[0])
    # episode 1 runs three blocks behind episode 0, then begins again
    for k in range(10):
        pair[0], pair[1] = observations[k, 0], observations[max(k - 3, 0), 1]
        seen = belief.update(pair, np.array([True, k >= 3]))
        assert [column[0] for column in seen] == [column[0] for column in alone[0][k]]
        if k >= 3:
            assert [column[1] for column in seen] == [column[0] for column in alone[1][k - 3]]
    belief.restart(np.array([False, True]))
    for k in range(6):
        pair[1] = observations[k, 1]
        seen = belief.update(pair, np.array([False, True]))
        assert [column[1] for column in seen] == [column[0] for column in alone[1][k]]
        assert [column[0] for column in seen] == [column[0] for column in alone[0][9]]


def test_an_ensemble_needs_two_members() -> None:
    with pytest.raises(BeliefError, match="members is 1, but must be at least 2"):
        WheelBelief(MemberModel(BlockSimulation(PLATES)), 1)


def test_the_belief_entries_are_the_fields_of_belief_in_order() -> None:
    low, high = bounds(belief_entries())
    assert [entry.name for entry in belief_entries()] == [f"belief_{name}" for name in Belief._fields]
    assert (low < high).all()

import functools

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode

from grind_env.envs.blocks.task_simulation import BlockSimulation
from grind_env.envs.noise_tape import TapeRow
from grind_env.envs.observations import HIDDEN, physical
from grind_env.envs.task_names import environment_id
from grind_env.envs.tasks import load_task, task_names
from grind_env.pages import summary
from tests.envs.harness import Array, Course, actions, every_id, native, start, whole_tape

N = 300


@pytest.mark.parametrize("env_id", every_id())
def test_random_steps_stay_in_the_space_and_in_the_reward_range_of_the_page(env_id: str) -> None:
    stated = summary(env_id).reward
    assert stated is not None
    least, most = stated
    env = native(env_id, 500, "SameStep", observation="full")
    low, high = env.single_observation_space.low, env.single_observation_space.high
    env.reset(seed=0)
    for action in actions(200, 500):
        observations, rewards, *_ = env.step(action)
        assert np.isfinite(rewards).all() and rewards.max() <= most
        assert least is None or rewards.min() >= least
        assert ((observations >= low) & (observations <= high)).all()  # false for NaN, too


class Run(Course):
    """Random episodes of a task with their readings."""

    def __init__(self, name: str) -> None:
        rng, shape = np.random.default_rng(1), (load_task(name).blocks, N)
        speeds = 1000.0 * np.floor(6.0 + 13.0 * rng.random(shape))
        super().__init__(BlockSimulation(load_task(name), full=True), speeds, np.floor(1.4 * rng.random(shape)))
        shown = physical(self.observations, self.simulation.entries)
        constant = {k: np.full(self.observations.shape[:2], v) for k, v in self.simulation.constant_readings.items()}
        self.read = constant | shown


run = functools.cache(Run)


def assert_standard_normal(z: Array, least: int = 2500) -> None:
    n = z.size
    assert n > least
    assert abs(z.mean()) < 5.0 / np.sqrt(n)
    assert z.std() == pytest.approx(1.0, abs=5.0 / np.sqrt(2 * n))
    assert (np.abs(z) < 1.0).mean() == pytest.approx(0.6827, abs=5.0 * np.sqrt(0.6827 * 0.3173 / n))


def mean_power(total: Array, count: Array) -> Array:
    return np.where(count > 0.0, total / np.maximum(count, 1.0), 0.0)


def test_power_readings_have_three_per_cent_and_twenty_watts_of_noise() -> None:
    r = run("power_limited")
    latest = [getattr(r.result, f"power_{number}") for number in range(1, 7)]
    for name, true, count in (
        ("peak_power", r.result.peak_load, r.result.strokes),
        ("first_power", mean_power(r.result.first_power, r.result.first_count), r.result.first_count),
        ("mean_power", mean_power(sum(latest), r.result.last_count), r.result.last_count),
    ):
        reading = r.read[name][1:]
        assert (reading[count == 0.0] == 0.0).all(), name
        # after a stall the spindle idles, a power cannot be read below 0, and a sensor ends at five times the limit
        inside = (true > 500.0) & (true < 4.0 * r.task.machine.power_limit)
        assert_standard_normal(((reading - true) / (0.03 * true + 20.0))[inside])
    assert (r.result.last_count[r.executions == 0.0] > 0.0).all()
    assert r.result.last_count.max() == 6.0 and r.result.first_count.max() == 6.0


def test_the_size_gauge_has_seven_tenths_of_a_micrometre_of_noise() -> None:
    r = run("power_limited")
    inside = np.abs(r.outcome.size_error) < 90.0
    assert_standard_normal(((r.read["size_error"][1:] - r.outcome.size_error) / 0.7)[inside])


@pytest.mark.parametrize("name", [name for name in task_names() if name != "memory"])
def test_every_third_part_is_gauged_for_roughness_and_known_one_part_late(name: str) -> None:
    r = run(name)
    # blocks that end a part, the same in all episodes; every one of them has a limit
    ends = np.flatnonzero(r.of_kind("ends_part")[:, 0])
    limits = r.of_kind("roughness_limit")[ends]
    assert (limits > 0.0).all()
    ratios = r.outcome.roughness[ends] / limits
    noise = []
    for done in range(1, len(ends) + 1):
        # until the next part is done the reading stays as it is
        shown = np.arange(ends[done - 1], ends[done] if done < len(ends) else r.task.blocks) + 1
        read, since = r.read["roughness"][shown], r.read["parts_since_gauged"][shown]
        assert (read == read[0]).all() and (since == since[0]).all()
        if done == 1:
            assert (read == 0.0).all()
            continue
        # parts 0, 3, 6, ... are gauged, and known when the part after them is done
        gauged = 3 * ((done - 2) // 3)
        noise.append(((read[0] / ratios[gauged] - 1.0) / 0.06)[ratios[gauged] < 4.0])
        np.testing.assert_allclose(since[0], done - 1 - gauged, atol=1e-5)
    z = np.concatenate(noise[::3])
    if r.task.spread.measurement:
        assert_standard_normal(z / r.task.spread.measurement, least=min(2500, 100 * r.task.blocks - 1))
    else:
        np.testing.assert_allclose(z, 0.0, atol=1e-4)


@pytest.mark.parametrize("name", task_names())
def test_book_keeping_is_exact(name: str) -> None:
    r = run(name)
    exact = {"rtol": 1e-5, "atol": 2e-4}
    np.testing.assert_allclose(r.read["last_speed"][1:], r.speeds, **exact)
    np.testing.assert_allclose(r.read["last_executions"][1:], r.executions, **exact)
    np.testing.assert_allclose(r.read["dresses"][1:], np.cumsum(r.executions, axis=0), **exact)
    lengths, changed = r.of_kind("length"), r.outcome.change_cost > 0.0
    since, volume = np.zeros(N), np.full(N, r.task.start.volume)
    for k, executions in enumerate(r.executions):
        volume = np.where(executions > 0.0, 0.0, volume) + r.tape.gauged[:, k] * lengths[k] / (executions + 1.0)
        volume[changed[k]] = 0.0
        np.testing.assert_allclose(r.read["volume"][k + 1], np.minimum(volume, 6000.0), **exact)
        since = np.where((executions > 0.0) | changed[k], 0.0, since + 1.0)
        np.testing.assert_allclose(r.read["blocks_since_dress"][k + 1], since, **exact)
    left = (r.task.blocks - np.arange(r.task.blocks + 1)) / r.task.blocks
    np.testing.assert_allclose(r.read["remaining"], np.repeat(left[:, None], N, axis=1), **exact)


@pytest.mark.parametrize("name", task_names())
def test_the_gauged_diameter_is_rounded_to_a_micrometre_and_exact_after_a_change(name: str) -> None:
    r = run(name)
    read, changed = r.read["diameter"], r.outcome.change_cost > 0.0
    np.testing.assert_allclose(read[0], r.wheels.ds[0], rtol=1e-6)
    np.testing.assert_allclose(read[1:] * 1000.0, np.round(read[1:] * 1000.0), atol=0.02)
    np.testing.assert_allclose(read[1:][changed], r.task.wheel.diameter, rtol=1e-6)
    error = 1000.0 * (read[1:] - r.wheels.ds[1:])[~changed]
    if r.task.spread.measurement:
        # twice the noise of the size gauge, plus the error of rounding to 1 um
        assert_standard_normal(error / np.hypot(1.4 * r.task.spread.measurement, 12.0**-0.5))
    else:
        assert np.abs(error).max() < 0.52


@pytest.mark.parametrize("name", task_names())
def test_the_coming_block_is_announced(name: str) -> None:
    r = run(name)
    announced = {
        **{
            field: r.of_kind(field) for field in ("pick", "width", "length", "sparkout", "roughness_limit", "tolerance")
        },
        "scrap": r.of_kind("scrap"),
        "stock": r.tape.gauged.T / r.of_kind("stock"),
    }
    if "new_lot" not in r.simulation.constant_readings:
        announced["new_lot"] = r.tape.new_lot.T
    for reading, values in announced.items():
        np.testing.assert_allclose(r.read[reading][:-1], values, rtol=1e-6, err_msg=reading)
        if reading not in r.simulation.constant_readings:
            assert (r.read[reading][-1] == 0.0).all(), reading
    kinds = r.task.kinds
    shown = {entry for entry in r.read if entry.startswith(("coming_", "following_", "material_"))}
    for number, kind in enumerate(kinds if len(kinds) > 1 else ()):
        coming, following = r.read[f"coming_{kind.name}"], r.read[f"following_{kind.name}"]
        np.testing.assert_array_equal(coming[:-1], r.kinds == number)
        np.testing.assert_array_equal(following[:-2], r.kinds[1:] == number)
        assert (coming[-1] == 0.0).all() and (following[-2:] == 0.0).all()
        shown -= {f"coming_{kind.name}", f"following_{kind.name}"}
    names = {kind.material for kind in kinds}
    for material in names if len(names) > 1 else ():
        of_it = np.array([kind.material == material for kind in kinds])[r.kinds]
        np.testing.assert_array_equal(r.read[f"material_{material}"][:-1], of_it)
        assert (r.read[f"material_{material}"][-1] == 0.0).all()
        shown.discard(f"material_{material}")
    assert not shown


def test_a_pre_dress_is_remembered_for_one_block() -> None:
    env = gym.make("grind/PowerLimited-v0", predress=True, observation="full", show_block=True).unwrapped
    env.reset(seed=0)
    for wanted, D in ((1.0, 1), (0.0, 0), (1.0, 0)):
        action = env.codec.encode([9000.0], [D], [wanted])[0]
        stock = whole_tape(env)[env.episodes.block[0], TapeRow._fields.index("gauged")]
        before = physical(env.simulation.observe(env.episodes)[0], env.simulation.entries)
        observation, *_, info = env.step(action)
        seen = physical(observation, env.simulation.entries)
        assert seen["last_pre_dress"] == info["predress"] == wanted
        assert seen["dresses"] == pytest.approx(before["dresses"] + D + wanted)
        # the last of D executions comes at the depth D/(D + 1), a pre-dress before the first stroke
        left = stock * 300.0 / (D + 1.0) + (0.0 if D + wanted > 0.0 else before["volume"])
        assert seen["volume"] == pytest.approx(left, rel=1e-5)
        assert info["block"].startswith("G82.1 " if wanted else "G82 ")


@pytest.mark.parametrize("name", task_names())
def test_the_full_observation_shows_the_true_state(name: str) -> None:
    r = run(name)
    for reading, true in (
        ("wear_flat", r.wheels.A),
        ("loading", r.wheels.lam),
        ("diamond_flat", r.wheels.wd),
        ("dressed_roughness", r.wheels.Rd),
        ("dressed_density", r.wheels.Cd),
    ):
        np.testing.assert_allclose(r.read[reading], true, rtol=1e-5, atol=1e-7, err_msg=reading)
    changes = np.cumsum(r.outcome.change_cost > 0.0, axis=0)
    spare = np.concatenate([np.zeros((1, N)), changes[:-1]]) > 0.0
    for reading, factor in (
        ("growth", np.where(spare, r.tape.spare_kA.T, r.tape.kA.T)),
        ("pressure", r.tape.pm.T),
        ("fracture", r.tape.fc.T),
        ("wear", r.tape.Gref.T),
        ("convection", r.tape.hf.T),
        ("roughness_scale", np.where(spare, r.tape.spare_ra_scale.T, r.tape.ra_scale.T)),
    ):
        np.testing.assert_allclose(r.read[reading][:-1], np.minimum(factor, 11.0), rtol=1e-6, err_msg=reading)


@pytest.mark.parametrize("name", ["CBN", "blades", "wide_rails"])  # tasks with several blocks per part
def test_the_full_observation_shows_the_heat_of_a_part_in_work(name: str) -> None:
    simulation = BlockSimulation(load_task(name), full=True)
    episodes, shown, blocks = start(simulation, 1), [], []
    for _ in range(3):
        shown.append(physical(simulation.observe(episodes)[0], simulation.entries)["part_rise"])
        blocks.append(simulation.writer.block(episodes, 0, 9000.0, 0.0))
        simulation.step(episodes, np.array([9000.0]), np.array([0.0]))
    strokes = (record := simulation.writer.record(episodes, 0, blocks)).strokes
    first = record.executions["first"][1]
    # every mode takes a share of the heat of each stroke, which decays until the end of the block
    p, rows = simulation.task.parameters(blocks[0].kind), strokes[:first]
    heat = rows["eps"] * rows["Ft"] * rows["vs"] * rows["b"] / (rows["E"] / 60.0) * p.per_capacity
    after = np.cumsum(np.round(rows["seconds"], 3)[::-1])[::-1]  # the process counts whole ms
    modes = ((p.w_1, p.r_1), (p.w_2, p.r_2), (p.w_3, p.r_3), (p.w_4, p.r_4))
    warm = sum(share * np.sum(heat * np.exp(-rate * after)) for share, rate in modes)
    assert warm > 1.0
    assert shown == pytest.approx([0.0, warm, 0.0], rel=1e-6)


def test_every_episode_starts_with_the_wheel_of_its_task() -> None:
    for name, A, V in (("power_limited", None, 0.0), ("oracle6", 0.012, 150.0)):
        env = native(environment_id(name), 50, AutoresetMode.SAME_STEP, observation="full")
        entries = env.unwrapped.observation_info()
        rows = [env.reset(seed=0)[0]]
        for action in actions(60, 50):
            stepped = env.step(action)
            rows += [stepped[0]] if stepped[2].all() else []
        assert len(rows) == (11 if name == "oracle6" else 2)
        seen = physical(np.array(rows), entries)
        for reading, value in (("diameter", 300.0), ("volume", V), ("loading", 0.0)):
            np.testing.assert_allclose(seen[reading], value, rtol=1e-6, atol=1e-9, err_msg=reading)
        if A is not None:
            np.testing.assert_allclose(seen["wear_flat"], A, rtol=1e-6)
        # 0.003 and 0.0022 per unit of overlap ratio (model.md): a blunter diamond leaves a duller wheel
        assert (seen["wear_flat"] > 0.003).all() and (seen["wear_flat"] < 0.03).all()
        for reading in ("dresses", "blocks_since_dress", "mean_power", "peak_power", "size_error", "roughness"):
            assert (seen[reading] == 0.0).all(), reading


def test_the_scaling_keeps_ordinary_readings_near_one() -> None:
    r = run("power_limited")
    # readings after a stall are not ordinary
    shown = r.observations[1:, :, : -len(HIDDEN)][r.outcome.peak_torque < 1.0]
    assert np.abs(np.percentile(shown, [5, 50, 95], axis=0)).max() <= 3.0

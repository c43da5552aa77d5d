from dataclasses import replace
from itertools import product
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode

from grind_env.belief.filter_quantities import CUT
from grind_env.envs import task_env_factory
from grind_env.envs.blocks.task_simulation import BlockSimulation
from grind_env.envs.distribution_splits import EVERY, SPLITS, Split, draws_of
from grind_env.envs.noise_tape import TapeRow
from grind_env.envs.random_numbers import within
from grind_env.envs.reset_options import CONTEXT_FACTORS, ContextError, Given, nominal_context, read_options
from grind_env.envs.tasks import load_task, task_names
from grind_env.errors import GrindError
from tests.envs.harness import BLOCKS, IDS, Array, actions, assert_same, every_id, native, refusal, start, whole_tape

#: deciles of the standard normal distribution
DECILES = np.array([-1.28155, -0.84162, -0.52440, -0.25335, 0.0, 0.25335, 0.52440, 0.84162, 1.28155])


def trajectory(env_id: str, seed: int, options: Any, **kwargs: Any) -> tuple[Array, Array, str]:
    """Return observations, rewards and the part program of an episode of moderate actions."""
    env = gym.make(env_id, **kwargs).unwrapped
    observations, rewards = [env.reset(seed=seed, options=options)[0]], []
    for action in 0.5 * actions(BLOCKS[env_id], 1)[:, 0]:
        observation, reward, *_ = env.step(action)
        observations.append(observation)
        rewards.append(reward)
    return np.array(observations), np.array(rewards), env.part_program()


@pytest.mark.parametrize("name", task_names())
def test_the_nominal_context_makes_a_task_deterministic(name: str) -> None:
    env_id = IDS[task_names().index(name)]
    task = load_task(name)
    runs = [trajectory(env_id, seed, {"context": nominal_context(task)}, observation="full") for seed in (1, 99)]
    assert_same(runs[0], runs[1])
    assert_same(trajectory(env_id, 7, {"context": "nominal"}, observation="full"), runs[0])
    if name != "oracle6":  # Oracle6 is always deterministic
        plain = trajectory(env_id, 1, None, observation="full")
        assert not np.array_equal(plain[1], runs[0][1])
        # and the nominal values are those of the task: stock on target, every factor 1
        given = read_options(task, {"context": "nominal"}, Given())
        tape = TapeRow(*BlockSimulation(task).start([np.random.default_rng(0)], [given]).tape[0].T)
        stocks = np.array([kind.stock for kind in task.kinds])[tape.kind.astype(int)]
        np.testing.assert_allclose(tape.stock, stocks, rtol=1e-12)
        np.testing.assert_allclose(tape.gauged, stocks, rtol=1e-12)
        for factor in (tape.kA, tape.pm, tape.fc, tape.Gref, tape.ra_scale, tape.spare_kA, tape.spare_ra_scale):
            assert (factor == 1.0).all()
        assert (tape.hf == 1.0).all() == (name != "blades")


#: values other than the nominal ones; every other factor gets 1.5
OTHER = {"executions_left": 3.0, "slack": 0.5, "diamond_flat": 0.2, "noise": 2.0, "stock": 1.2}


@pytest.mark.parametrize("env_id", [*IDS, "grind/Reciprocation-v0", "grind/WidePlates-v0"])
def test_a_factor_either_changes_something_or_is_refused(env_id: str) -> None:
    single = gym.make(env_id).unwrapped
    nominal = nominal_context(single.task)
    legal = [name for name in CONTEXT_FACTORS if name in nominal]
    for name in set(CONTEXT_FACTORS) - set(legal):
        with pytest.raises(ContextError, match=f"{name} cannot be fixed, leave it out"):
            single.reset(options={"context": {name: OTHER.get(name, 1.5)}})
    contexts = [nominal, *({**nominal, name: OTHER.get(name, 1.5)} for name in legal)]
    env = native(env_id, len(contexts), AutoresetMode.DISABLED, observation="full")
    seen, earned = [env.reset(seed=[0] * len(contexts), options={"context": contexts})[0]], []
    over = np.zeros(len(contexts), bool)
    for action in actions(4 if env_id == "grind/WidePlates-v0" else 60, 1):
        if over.any():
            break
        # the middle of the speeds, and a dress now and then
        batch = np.repeat(np.clip(action * [0.3, 1.0], -1.0, 1.0), len(contexts), axis=0).astype(np.float32)
        observations, rewards, over, *_ = env.step(batch)
        seen.append(observations)
        earned.append(rewards[:, None])
    made, shown = (np.concatenate(rows, axis=1) for rows in (earned, seen))
    for k, name in enumerate(legal, 1):
        assert not (shown[k] == shown[0]).all(), name
        # every factor except the noise also changes the rewards
        assert (made[k] == made[0]).all() == (name == "noise"), name


def test_a_context_does_not_change_the_draws_of_other_factors() -> None:
    simulation = BlockSimulation(load_task("power_limited"))
    seeds = [np.random.default_rng(s) for s in range(50)]
    given = read_options(simulation.task, {"context": {"kA": 2.0, "noise": 0.5}}, Given())
    plain = TapeRow(*np.moveaxis(start(simulation, 50).tape, 2, 0))
    fixed = TapeRow(*np.moveaxis(simulation.start(seeds, [given] * 50).tape, 2, 0))
    for name in ("kind", "stock", "new_lot", "pm", "hf", "fc", "Gref", "ra_scale", "material"):
        np.testing.assert_array_equal(getattr(plain, name), getattr(fixed, name), err_msg=name)
    # every lot has the factor 2, multiplied by the factor of the wheel
    wheel = fixed.kA / 2.0
    assert (wheel == wheel[:, :1]).all() and np.abs(np.log(wheel)).max() == pytest.approx(
        CUT * simulation.task.spread.wheel_growth
    )
    np.testing.assert_allclose(fixed.mean_noise, 0.5 * plain.mean_noise)
    np.testing.assert_allclose(fixed.gauged - fixed.stock, 0.5 * (plain.gauged - plain.stock), atol=1e-12)


def test_a_lot_without_any_difference_is_not_a_new_lot() -> None:
    simulation = BlockSimulation(load_task("power_limited"))
    for context, lots in (({"kA": 1.0}, True), ({"pm": 1.0}, True), ({"kA": 1.0, "pm": 1.0}, False)):
        given = read_options(simulation.task, {"context": context}, Given())
        tape = TapeRow(*simulation.start([np.random.default_rng(0)], [given]).tape[0].T)
        assert tape.new_lot[0] == 1.0 and (tape.new_lot[1:] == 1.0).any() == lots


def test_a_context_holds_until_another_is_given() -> None:
    env = gym.make("grind/PowerLimited-v0").unwrapped

    def growth(**reset: Any) -> float:
        env.reset(**reset)
        return float(np.unique(whole_tape(env)[:, TapeRow._fields.index("kA")]).size)

    assert growth(seed=0) > 5
    assert growth(seed=0, options={"context": {"kA": 1.0}}) == 1
    assert growth() == 1
    assert growth(options={"split": "interpolation"}) == 1
    assert growth(options={"context": None}) > 5
    assert env.given.split == SPLITS["interpolation"]
    assert growth(options={"split": "all"}) > 5
    assert env.given == Given()


def test_sub_envs_keep_their_own_contexts_through_autoresets() -> None:
    contexts = [{"stock": 0.8, "sequence": ["plate"]}, None, "nominal"]
    for mode in (AutoresetMode.SAME_STEP, AutoresetMode.NEXT_STEP):
        env = native("grind/PowerLimited-v0", 3, mode)
        env.reset(seed=3, options={"context": contexts, "split": ["inner", "interpolation", "all"]})
        stock = TapeRow._fields.index("stock")
        for episode in range(2):
            begun = env.unwrapped
            stocks = begun.simulation.with_full_tapes(begun.episodes).tape[:, :, stock]
            assert (stocks[0] == 0.24).all() and (stocks[2] == 0.30).all(), episode
            assert len(np.unique(stocks[1])) > 20
            for action in actions(61 if mode == AutoresetMode.NEXT_STEP else 60, 3, seed=episode):
                env.step(action)
        assert [given.split for given in env.unwrapped.given] == [
            SPLITS[name] for name in ("inner", "interpolation", "all")
        ]
        # only the sub-env that is reset takes a new context
        mask = np.array([True, False, False])
        env.reset(options={"reset_mask": mask, "context": {"stock": 1.2}})
        assert [given.fixed.stock for given in env.unwrapped.given][::2] == [1.2, 1.0]


BAD: list[tuple[Any, str]] = [
    ({"contexts": {}}, "no reset option 'contexts'"),
    ({"context": {"ka": 1.0}}, "no factor 'ka'"),
    ({"context": {"kA": "hard"}}, "kA is 'hard', but must be a number from 0.05 to 20"),
    ({"context": {"kA": True}}, "kA is True"),
    ({"context": {"kA": 0.0}}, "kA is 0.0"),
    ({"context": {"hf": np.nan}}, "hf is nan"),
    ({"context": {"stock": 4}}, "stock is 4, but must be a number from 0.3 to 3"),
    ({"context": {"material": "aisi_52101"}}, "material is 'aisi_52101', but must be one of aisi_1020, aisi_1045, "),
    ({"context": {"sequence": ["plat"]}}, "there is no kind 'plat' (did you mean plate?); legal are plate"),
    ({"context": {"sequence": []}}, "sequence is []"),
    ({"context": {"sequence": "plate"}}, "sequence is 'plate'"),
    ({"context": {"executions_left": 4.0}}, "executions_left cannot be fixed"),
    ({"context": {"slack": 0.5}}, "power_limited has no due dates: slack cannot be fixed, leave it out"),
    ({"context": {"coolant_ageing": 2.0}}, "power_limited has a coolant that does not age: coolant_ageing cannot"),
    *(
        ({"split": name}, f"split is {name!r}, but must be one of all, inner, interpolation, extrapolation: it names")
        for name in ("training", "validation", "evaluation", "outer", None, 3)
    ),
    ({"context": np.array([1, 2])}, "context is array([1, 2]), but must be a dict"),
    ({"context": {"material": ["inconel_718"]}}, "material is ['inconel_718'], but must be one of"),
    ({"context": {"kA": np.array([1.0, 2.0])}}, "kA is array([1., 2.]), but must be a number"),
    ({"split": "train"}, "split is 'train', which is called 'inner' now"),
]


@pytest.mark.parametrize(("options", "part"), BAD)
def test_a_bad_option_is_refused_and_changes_nothing(options: Any, part: str) -> None:
    env, twin = (gym.make("grind/PowerLimited-v0").unwrapped for _ in range(2))
    vector, other = native("grind/PowerLimited-v0", 2), native("grind/PowerLimited-v0", 2)
    for each in (env, twin, vector, other):
        each.reset(seed=1)
    for each in (env, vector):
        assert part in refusal(ContextError, each.reset, seed=2, options=options)
    assert_same(env.step(np.zeros(2)), twin.step(np.zeros(2)))
    assert_same(vector.step(np.zeros((2, 2))), other.step(np.zeros((2, 2))))
    assert_same(env.reset(), twin.reset())
    assert_same(vector.reset(), other.reset())
    assert issubclass(ContextError, GrindError)


def test_a_list_of_contexts_must_have_one_for_each_env() -> None:
    env = native("grind/PowerLimited-v0", 2)
    with pytest.raises(ContextError, match="context has 3 entries, but must have 2"):
        env.reset(options={"context": [None] * 3})
    with pytest.raises(ContextError, match="context is \\["):
        gym.make("grind/PowerLimited-v0").reset(options={"context": [None]})


def test_a_rough_block_needs_its_finish_block() -> None:
    task = load_task("wide_rails")
    for sequence in (["rough"], ["finish", "rough"], ["rough", "finish", "finish"]):
        with pytest.raises(ContextError, match="whole parts"):
            read_options(task, {"context": {"sequence": sequence}}, Given())


def test_the_splits_use_disjoint_ranges_of_every_factor() -> None:
    assert SPLITS[EVERY] == Split()
    inner, between = (SPLITS[name].ranges for name in ("inner", "interpolation"))
    assert sorted(inner + between) == [0, 1, 3, 4, 5, 6, 8, 9]
    # the ranges of interpolation lie between those of training
    assert all(min(inner) < number < max(inner) for number in between)
    # symmetric about the middle, so that no split is harder on the whole
    assert all(sorted(9 - number for number in split.ranges) == sorted(split.ranges) for split in SPLITS.values())
    assert [name for name, split in SPLITS.items() if split.leaves_task] == ["extrapolation"]
    u = np.sort(np.random.default_rng(0).random(20_000))
    for split in (inner, between):
        moved = np.array([within(number, draws_of(Split(ranges=split)).bits) for number in u.tolist()])
        share = np.bincount((10.0 * moved).astype(int), minlength=10) / len(u)
        expected = np.array([1.0 / len(split) if number in split else 0.0 for number in range(10)])
        np.testing.assert_allclose(share, expected, atol=0.01)
        assert (np.diff(moved) >= 0.0).all()


def test_every_factor_of_an_episode_comes_from_the_ranges_of_its_split() -> None:
    # the roughness of every part scatters on top of that of the wheel, as gauge noise does, in every split
    task = load_task("CBN")
    simulation = BlockSimulation(replace(task, spread=replace(task.spread, part_roughness=0.0)))
    sigmas = {"pm": 0.08, "hf": 0.15, "fc": 0.10, "Gref": 0.15, "ra_scale": 0.07, "spare_ra_scale": 0.07}
    for name, split in SPLITS.items():
        if split.leaves_task:
            continue
        given = read_options(simulation.task, {"split": name}, Given())
        count = 300
        tape = simulation.start([np.random.default_rng(i) for i in range(count)], [given] * count).tape
        columns = TapeRow(*np.moveaxis(tape, 2, 0))
        for factor, sigma in sigmas.items():
            z = np.log(getattr(columns, factor)) / sigma
            assert set(np.digitize(z.ravel(), DECILES)) == set(split.ranges or range(10)), (name, factor)
    plain = start(simulation, 300).tape
    z = np.log(TapeRow(*np.moveaxis(plain, 2, 0)).hf[:, 0]) / 0.15
    assert set(np.digitize(z, DECILES)) == set(range(10))


def test_the_roughness_scatters_from_part_to_part_about_that_of_the_wheel() -> None:
    task = load_task("CBN")
    smooth = BlockSimulation(replace(task, spread=replace(task.spread, part_roughness=0.0)))
    for options in ({}, {"split": "interpolation"}):
        seeds, given = range(300), [read_options(task, options, Given())] * 300
        tapes = [
            each.start([np.random.default_rng(i) for i in seeds], given).tape
            for each in (BlockSimulation(task), smooth)
        ]
        plain, even = (TapeRow(*np.moveaxis(tape, 2, 0)) for tape in tapes)
        part = np.log(plain.ra_scale / even.ra_scale)
        np.testing.assert_allclose(part, np.log(plain.spare_ra_scale / even.spare_ra_scale), rtol=1e-9, atol=1e-12)
        # a rough and a finish block belong to one part
        np.testing.assert_allclose(part[:, 0::2], part[:, 1::2], rtol=1e-9, atol=1e-12)
        z = np.random.default_rng(0).standard_normal(1_000_000).clip(-CUT, CUT)
        assert part[:, 0::2].std() == pytest.approx(0.15 * z.std(), rel=0.02)
        assert np.abs(part).max() == pytest.approx(0.15 * CUT)
        following = np.corrcoef(part[:, 0:-2:2].ravel(), part[:, 2::2].ravel())[0, 1]
        assert following == pytest.approx(0.0, abs=0.03)


def test_a_fixed_material_changes_the_readings_but_is_not_shown() -> None:
    for name, flags in (("power_limited", []), ("job_shop", [0.0, 0.0])):
        env = task_env_factory.make(name, observation="full")
        names = [entry.name for entry in env.observation_info()]
        told = [k for k, each in enumerate(names) if each.startswith("material_")]
        powers = []
        for material in (None, "inconel_718"):
            context = None if material is None else {"material": material}
            first = env.reset(seed=0, options={"context": context})[0]
            assert env.observation_space.contains(first)
            assert first[told].tolist() == ([] if not flags else flags if material else [0.0, 1.0])
            powers.append(env.step(np.zeros(2, np.float32))[0][names.index("peak_power")])
        assert powers[0] != powers[1]


@pytest.mark.parametrize("env_id", every_id())
def test_options_that_are_no_dict_are_refused_in_one_sentence(env_id: str) -> None:
    envs = gym.make(env_id).unwrapped, native(env_id, 2).unwrapped
    for env, options in product(envs, ([1], "x", 3, [])):
        told = f"options is {options!r}, but must be a dict of reset options, or None"
        assert refusal(ContextError, env.reset, options=options) == told

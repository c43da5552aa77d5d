import dataclasses
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.error import ResetNeeded
from hypothesis import given, settings
from hypothesis import strategies as st

from grind_env.control import read
from grind_env.envs.actions import ActionError
from grind_env.envs.blocks.program import conditions, job
from grind_env.envs.contexts import ContextError
from grind_env.envs.drawing import STROKE, deviation, words_of
from grind_env.envs.env import GrindEnv
from grind_env.envs.gauge import GAUGE
from grind_env.envs.ids import stroke
from grind_env.envs.strokes.simulation import StrokeEpisodes, StrokeSimulation
from grind_env.envs.strokes.step import TOGETHER
from grind_env.envs.tables import Outcome
from grind_env.envs.tape import KEY_0, KEY_1, NOISE_FACTOR, TapeRow
from grind_env.envs.tasks import TaskError, read_task
from grind_env.machine.grind import grind
from grind_env.machine.record import GrindingRecord
from grind_env.policies.evaluation import episode_seeds, run_seeds
from grind_env.policies.problem import find_problem
from grind_env.policies.registry import make_policy
from grind_env.process.process import PROCESS
from grind_env.scores import reference
from tests.envs.harness import Array, assert_same, native, row_of, whole_tape

ID = "grind/Stroke-v0"


def ground(env: GrindEnv) -> GrindingRecord:
    """The program of the episode, run with the operator's requests."""
    drawn = env.simulation.start([np.random.default_rng(env.np_random_seed)], [env.given])
    shop = job(env.task, *env.task.kinds)
    shop = dataclasses.replace(shop, wheel=dataclasses.replace(shop.wheel, diamond_flat=drawn.wheel(0).wd))
    control = dataclasses.replace(shop.control, operator_dress_at=env.operator_dress_at())
    return grind(read(env.part_program()), shop, control=control, conditions=conditions(env.task, drawn.tape[0]))


def tape_of(env: GrindEnv) -> list[TapeRow]:
    """The parts of its episode."""
    assert env.episodes is not None
    return [TapeRow(*row) for row in whole_tape(env).tolist()]


def noise_of(env: GrindEnv) -> Array:
    """The noise of the strokes of its episode."""
    assert isinstance(env.episodes, StrokeEpisodes)
    first, second, factor = env.episodes.source[0, [KEY_0, KEY_1, NOISE_FACTOR]].tolist()
    strokes = range(env.simulation.most_steps)
    return np.array([deviation(factor, words_of(first, second, STROKE, stroke)[0]) for stroke in strokes])


def play(env: GrindEnv, seed: int, policy_seed: int, dress: float, fastest: float = 1.0) -> list[dict[str, Any]]:
    """An episode at random speeds, up to an action; every stroke has a dress before it with a probability."""
    rng = np.random.default_rng(policy_seed)
    env.reset(seed=seed)
    infos, terminated = [], False
    while not terminated:
        action = np.array([rng.uniform(-1, fastest), 0.5 if rng.random() < dress else -0.5], np.float32)
        _, reward, terminated, truncated, info = env.step(action)
        assert not truncated
        assert reward == pytest.approx(sum(info["reward_terms"].values()), rel=1e-12)
        infos.append(info)
    return infos


@settings(max_examples=8, deadline=None)
@given(seed=st.integers(0, 10_000), policy_seed=st.integers(0, 10_000), dress=st.sampled_from([0.0, 0.05, 0.3, 1.0]))
def test_the_part_program_of_an_episode_grinds_the_same_record(seed: int, policy_seed: int, dress: float) -> None:
    env = stroke.make(info="full")
    infos = play(env, seed, policy_seed, dress)
    record = ground(env)
    # random speeds ask a lot of the spindle, and of nothing else
    assert all("the spindle s" in warning for warning in record.warnings)
    assert record.strokes["E"].tolist() == [info["E"] for info in infos]
    dressed = [k for k, info in enumerate(infos) if info["D"]]
    assert record.dresses["after"].tolist() == dressed
    first = np.flatnonzero(np.diff(record.strokes["part"], prepend=0)).tolist()
    causes = ["pre" if k in first else "operator" for k in dressed]
    assert record.dresses["cause"].tolist() == causes
    ends = np.append(first[1:], len(infos))
    starts = np.array(first)
    for name, key in (("seconds", "seconds"), ("survival", "good_parts")):
        sums = [sum(info[key] for info in infos[a:b]) for a, b in zip(starts, ends, strict=True)]
        assert record.parts[name] == pytest.approx(sums, rel=1e-9, abs=1e-12), name
    handover = -infos[-1]["reward_terms"]["handover"] * env.task.reference_cost
    cost = sum(info["block_cost"] for info in infos)
    assert cost == pytest.approx(record.parts["total_cost"].sum() + handover, rel=1e-9)
    assert env.episodes is not None
    assert record.strokes["A"][-1] == pytest.approx(env.episodes.wheel(0).A, rel=1e-12)


def test_the_program_of_a_stroke() -> None:
    env = stroke.make()
    env.reset(seed=0)
    blocks = [
        env.step(env.codec.encode(speed, executions)[0])[4]["block"].split("\n")
        for speed, executions in ((12_000.0, 1), (9000.0, 0), (6000.0, 1))
    ]
    assert blocks[0][-2:] == ["G01 Y-.02 F60.", "G81.1 X330. I-30. E12000. P9100"]
    # a stroke of 360 mm at 200 mm/s decelerates after 360/200 s
    assert blocks[1] == ["G04 X1.8", "G01 Y-.04 E9000."]
    assert blocks[2][1] == "G01 Y-.06 E6000."
    assert blocks[2][2].endswith("(OPERATOR ASKS FOR A DRESS)")
    assert len(env.operator_dress_at()) == 1


def test_a_part_is_ground_in_picks_to_its_stock() -> None:
    env = stroke.make()
    infos = play(env, 3, 0, 0.1)
    record = ground(env)
    for number, row in enumerate(tape_of(env), 1):
        Z = record.strokes["Z"][record.strokes["part"] == number]
        assert Z[0] == pytest.approx(0.02)
        assert Z[-3:] == pytest.approx(row.stock)
        assert np.diff(Z)[:-3] == pytest.approx(0.02)
        assert Z[-4] < row.stock
    assert len(infos) == len(record.strokes)


def seen(env: GrindEnv, observation: Any) -> dict[str, float]:
    return {e.name: float(e.offset + e.scale * v) for e, v in zip(env.observation_info(), observation, strict=True)}


def test_what_is_seen() -> None:
    env = stroke.make(observation="full")
    first = seen(env, env.reset(seed=1)[0])
    assert (first["starts_part"], first["remaining"]) == (1.0, 1.0)
    assert first["pick"] == pytest.approx(0.02, abs=1e-7)
    views = [seen(env, env.step(env.codec.encode(10_000.0, int(k == 3))[0])[0]) for k in range(6)]
    strokes, noise = ground(env).strokes, noise_of(env)
    readings = strokes["load"] * (1.0 + 0.03 * noise[:6]) + 20.0 * noise[:6]
    assert [view["power"] for view in views] == pytest.approx(readings, rel=1e-5)
    assert views[2]["mean_power"] == pytest.approx(readings[:3].mean(), rel=1e-5)
    assert views[5]["mean_power"] == pytest.approx(readings[3:].mean(), rel=1e-5)
    assert views[5]["peak_power"] == pytest.approx(readings.max(), rel=1e-5)
    assert [view["last_dress"] for view in views] == [0.0, 0.0, 0.0, 1.0, 0.0, 0.0]
    assert [view["volume"] for view in views] == pytest.approx([6, 12, 18, 6, 12, 18], rel=1e-5)
    assert [view["strokes_left"] for view in views] == pytest.approx(first["strokes_left"] - np.arange(1, 7))
    assert [view["wear_flat"] for view in views] == pytest.approx(strokes["A"], rel=1e-5)
    assert views[0]["last_speed"] == pytest.approx(10.0)
    rises = np.array([view["part_rise"] for view in (first, *views[:5])])
    (kind,) = env.task.kinds
    grown = strokes["grown"] / (env.task.catalogue.material(kind.material).thermal_expansion * kind.height)
    # the part cools while the wheel is dressed
    assert rises[[0, 1, 2, 4, 5]] == pytest.approx(grown[[0, 1, 2, 4, 5]], rel=1e-6)
    assert 0.0 < grown[3] < rises[3]


def test_the_size_gauge_and_the_roughness_gauge() -> None:
    env = stroke.make()
    env.reset(seed=2)
    views, terminated = [], False
    while not terminated:
        observation, _, terminated, _, info = env.step(env.codec.encode(10_000.0, 0)[0])
        if info["good_parts"] or info["cost"]:
            views.append(seen(env, observation))
    parts = ground(env).parts
    tape = tape_of(env)
    errors = [part["size_error"] + 0.7 * row.size_noise for part, row in zip(parts, tape, strict=True)]
    assert [view["size_error"] for view in views] == pytest.approx(np.clip(errors, -100.0, 100.0), rel=1e-4)
    gauged = parts["Ra"][0] / env.task.kinds[0].roughness_limit * (1.0 + 0.06 * tape[0].roughness_noise)
    assert [view["roughness"] for view in views[:4]] == pytest.approx([0.0, gauged, gauged, gauged], rel=1e-5)
    assert [view["parts_since_gauged"] for view in views[:5]] == pytest.approx([1, 1, 2, 3, 1])
    assert [view["remaining"] for view in views] == pytest.approx(np.arange(9, -1, -1) / 10.0)


def test_a_stalled_spindle_grinds_the_part_no_more_and_costs_its_time_once() -> None:
    env = stroke.make()
    infos = play(env, 0, 0, 0.03, fastest=0.2)
    record, task = ground(env), env.task
    strokes, parts = record.strokes, record.parts
    stalled = parts["peak_torque"] >= 1.0
    assert stalled.any() and not stalled.all()
    assert (parts["survival"][stalled] == 0.0).all()
    for number in np.flatnonzero(stalled) + 1:
        at = np.flatnonzero(strokes["part"] == number)
        first = at[int(np.argmax(strokes["torque"][at] >= 1.0))]
        after = at[at > first]
        assert (strokes["ae"][after] == 0.0).all() and (strokes["power"][after] == 0.0).all()
        lost = [info["seconds"] > task.machine.stall_time for info in np.array(infos)[at]]
        assert np.flatnonzero(lost).tolist() == [first - at[0]]
    for number in np.flatnonzero(~stalled) + 1:
        assert max(info["seconds"] for info in np.array(infos)[strokes["part"] == number]) < task.machine.stall_time


def test_a_fixed_plan_earns_in_the_environment_what_its_evaluation_says() -> None:
    simulation, seeds = find_problem("stroke").simulation(), range(3)
    env, run = stroke.make(show_block=False), run_seeds(make_policy("interval", simulation), simulation, seeds)
    assert (run.executions == 1).any(axis=1).all()
    for episode in seeds:
        env.reset(seed=episode)
        made = np.isfinite(run.speeds[episode])
        plan = env.codec.encode(run.speeds[episode, made], run.executions[episode, made])
        *before, last = [env.step(action) for action in plan]
        assert [terminated for _, _, terminated, _, _ in (*before, last)] == [False] * len(before) + [True]
        earned = sum(reward for _, reward, *_ in (*before, last))
        assert earned == pytest.approx(-run.cost[episode] / env.task.reference_cost, rel=1e-6)


def test_the_best_fixed_plan_earns_minus_one_a_stroke() -> None:
    scale, simulation = reference("grind/Stroke-v0"), find_problem("stroke").simulation()
    run = run_seeds(make_policy(scale.fixed_plan, simulation), simulation, episode_seeds("evaluation", 256))
    strokes = np.isfinite(run.speeds).sum(axis=1).mean()
    assert run.cost.mean() / strokes == pytest.approx(simulation.task.reference_cost, rel=0.01)


def test_the_noise_does_not_depend_on_the_policy() -> None:
    envs = [stroke.make(), stroke.make()]
    for policy_seed, env in enumerate(envs):
        play(env, 5, policy_seed, 0.1)
    assert_same(noise_of(envs[0]), noise_of(envs[1]))
    assert envs[0].np_random.random() == envs[1].np_random.random()
    assert len(noise_of(envs[0])) >= len(envs[0].blocks)


def test_what_is_out_of_turn_or_out_of_range_is_refused() -> None:
    env = stroke.make()
    for call in (lambda: env.step(np.zeros(2)), env.part_program):
        with pytest.raises(ResetNeeded):
            call()
    play(env, 0, 0, 0.0)
    with pytest.raises(ResetNeeded):
        env.step(np.zeros(2))
    env.reset()
    for action in (np.zeros(3), [np.nan, 0.0], "fast"):
        with pytest.raises(ActionError):
            env.step(action)
    with pytest.raises(TaskError, match="measured, full"):
        stroke.make(observation="hidden")
    for make in (stroke.make, stroke.make_vector):
        with pytest.raises(ActionError, match=r"^predress is True, but D = 1 in grind/Stroke-v0 is the dress before"):
            make(predress=True)


def test_each_stroke_env_takes_a_context_and_a_split_of_its_own() -> None:
    options = {"split": ["inner", "interpolation"], "context": [{"stock": 0.5}, None]}
    vector = native("grind/Stroke-v0", 2)
    singles = [gym.make("grind/Stroke-v0") for _ in range(2)]
    begun = vector.reset(seed=3, options=options)[0]
    for _ in range(2):  # both hold
        for i, env in enumerate(singles):
            own = {name: values[i] for name, values in options.items()}
            assert_same(env.reset(seed=3 + i, options=own)[0], begun[i])
        for i, env in enumerate(singles):
            assert_same(env.unwrapped.episodes.tape[0], vector.unwrapped.episodes.tape[i])
        begun = vector.reset(seed=3)[0]
    vector.reset(options={"split": ["all", "all"], "reset_mask": np.array([False, True])})
    assert [len(given.split.ranges) for given in vector.unwrapped.given] == [6, 0]


def test_a_context_does_not_change_the_random_numbers_of_a_later_episode() -> None:
    tapes = []
    for context in (None, {"stock": 0.5}, {"stock": 3.0, "noise": 0.0}):
        env = gym.make("grind/Stroke-v0").unwrapped
        env.reset(seed=0, options={"context": context})
        assert len(noise_of(env)) >= sum(env.task.strokes(env.task.kinds[0], row.stock) for row in tape_of(env))
        env.reset(options={"context": None})
        tapes.append((whole_tape(env), noise_of(env), env.np_random.random()))
    assert_same(tapes[0], tapes[1])
    assert_same(tapes[0], tapes[2])


def test_a_stroke_takes_a_context_and_a_split() -> None:
    env = gym.make("grind/Stroke-v0").unwrapped
    starts = [env.reset(seed=seed, options={"context": "nominal"})[0] for seed in (0, 1)]
    assert_same(starts[0], starts[1])
    steps = []
    for seed in (0, 1):
        env.reset(seed=seed)  # the context holds
        steps.append([env.step(np.zeros(2, np.float32)) for _ in range(20)])
    assert_same(steps[0], steps[1])
    env.reset(seed=0, options={"context": {"noise": 2.0, "stock": 0.5}})
    assert all(row.stock == pytest.approx(0.5 * env.task.kinds[0].stock) for row in tape_of(env))
    noise = noise_of(env)
    env.reset(seed=0, options={"context": {"noise": 1.0, "stock": 0.5}})
    np.testing.assert_allclose(noise, 2.0 * noise_of(env))
    with pytest.raises(ContextError, match="no factor 'ka'"):
        env.reset(options={"context": {"ka": 1.0}})
    assert env.given.fixed.noise == 1.0


@settings(max_examples=6, deadline=None)
@given(
    seed=st.integers(0, 10_000),
    dress=st.sampled_from([0.0, 0.1, 0.5]),
    material=st.sampled_from([None, "inconel_718"]),
)
def test_every_stroke_is_that_of_the_machine(seed: int, dress: float, material: str | None) -> None:
    env = stroke.make(show_block=False)
    env.reset(options={"context": {"material": material} if material else None})
    infos = play(env, seed, seed, dress)
    record, shown = ground(env), Outcome(*np.array(env.outcomes).T)
    strokes, dresses = record.strokes, record.dresses
    assert len(strokes) == len(infos)
    assert shown.peak_power == pytest.approx(strokes["power"], rel=1e-12)
    limit = env.task.limits(env.task.kinds[0]).power
    assert shown.power_ratio == pytest.approx(strokes["load"] / limit, rel=1e-12)
    assert shown.roughness == pytest.approx(strokes["Ra"], rel=1e-12)
    lost = strokes["worn"].copy()
    lost[dresses["after"]] += dresses["removed"]
    assert shown.wheel_cost == pytest.approx(env.task.rates.wheel * lost, rel=1e-9)


def test_episodes_that_are_stepped_apart_are_each_what_it_is_alone() -> None:
    count, steps = TOGETHER + 3, 40
    plan = np.random.default_rng(4).uniform(-1.0, 1.0, (steps, count, 2)).astype(np.float32)
    vector = native(ID, count)
    vector.reset(seed=0)
    stepped = [vector.step(actions) for actions in plan]
    for i in (0, TOGETHER - 1, TOGETHER, count - 1):
        env = gym.make(ID, show_block=False)
        env.reset(seed=i)
        for k in range(steps):
            assert_same(env.step(plan[k, i]), row_of(stepped[k], i))


def test_all_episodes_are_stepped_by_one_call(monkeypatch: pytest.MonkeyPatch) -> None:
    env: Any = native(ID, 5).unwrapped
    calls = []
    step = env.simulation._step_of(PROCESS, GAUGE)
    monkeypatch.setattr(env.simulation, "_step_of", lambda *_: lambda *arguments: calls.append(step(*arguments)))
    env.reset(seed=0)
    for _ in range(3):
        env.step(np.zeros((5, 2), np.float32))
    assert len(calls) == 3


def test_a_planner_branches_an_episode() -> None:
    simulation = StrokeSimulation(read_task("stroke"))
    episodes = simulation.start([np.random.default_rng(seed) for seed in range(3)])
    for speed in np.linspace(5000.0, 9000.0, 20):
        simulation.step(episodes, np.full(3, speed), np.zeros(3))
    branches = episodes.pick([2, 0, 2])
    E, D = np.array([6000.0, 7000.0, 8000.0]), np.array([0.0, 1.0, 0.0])
    found, _ = simulation.step(branches, E[[2, 0, 2]], D[[2, 0, 2]])
    wanted, _ = simulation.step(episodes, E, D)
    assert_same(found, wanted[[2, 0, 2]])
    assert_same(simulation.observe(branches), simulation.observe(episodes)[[2, 0, 2]])
    assert_same(branches.strokes, episodes.strokes[[2, 0, 2]])


def test_a_stroke_that_sparks_out_adds_no_heat_that_counts() -> None:
    env = stroke.make()
    env.reset(seed=1)
    strokes = env.task.strokes(env.task.kinds[0], tape_of(env)[0].stock)
    for _ in range(strokes):
        env.step(env.codec.encode(9000.0, 0)[0])
    *plunges, sparkout, last = (block.rise for block in env.view().ground)
    assert sparkout == 0.0 < min(plunges)
    assert last in plunges[-3:]

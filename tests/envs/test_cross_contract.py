from collections.abc import Callable
from dataclasses import replace
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.error import ResetNeeded
from hypothesis import given
from hypothesis import strategies as st

from grind_env.envs import any_task
from grind_env.envs.actions import ActionError
from grind_env.envs.blocks.program import job_from_surface
from grind_env.envs.contexts import nominal_context
from grind_env.envs.ids import wide_plates
from grind_env.envs.strips.simulation import StripSimulation
from grind_env.envs.tasks import TaskError, read_task
from grind_env.pages import page, summary
from tests.envs.harness import FORMS, assert_same
from tests.examples import examples

ID = "grind/WidePlates-v0"

CONTEXTS: list[dict[str, Any]] = [
    {"stock": 1.3},
    {"kA": 4.0},
    {"pm": 1.5},
    {"wheel_kA": 3.0},
    {"ra_scale": 1.4},
    {"fc": 0.5},
    {"Gref": 0.5},
    {"hf": 0.5},
    {"diamond_flat": 0.3},
    {"noise": 3.0},
    {"material": "inconel_718"},
]


@pytest.mark.parametrize("context", CONTEXTS, ids=lambda context: next(iter(context)))
def test_every_factor_changes_the_trajectory(context: dict[str, Any]) -> None:
    env = wide_plates.make()
    nominal = nominal_context(env.task)
    ends = []
    for given_context in (nominal, {**nominal, **context}):
        env.reset(seed=0, options={"context": given_context})
        steps = [env.step(np.array([0.2, -0.5], np.float32)) for _ in range(3)]
        ends.append([step[0].tobytes() for step in steps])
    assert ends[0] != ends[1]


def test_the_nominal_context_leaves_nothing_to_chance() -> None:
    env = wide_plates.make()
    runs = []
    for seed in (0, 1):
        observation, _ = env.reset(seed=seed, options={"context": "nominal"})
        runs.append([observation, *(env.step(np.array([0.1, -0.4], np.float32))[:2] for _ in range(3))])
    assert_same(*runs)


@pytest.mark.bits
def test_the_same_seed_is_the_same_episode_whatever_was_ground_before() -> None:
    env = wide_plates.make()
    runs = []
    for seed in (5, 6, 5):
        observation, _ = env.reset(seed=seed)
        runs.append([observation, *(env.step(np.array([0.1 * k, -0.4], np.float32)) for k in range(4))])
        assert env.episodes is not None
        runs[-1].append(env.episodes.tape[0].copy())
    assert_same(runs[0], runs[2])
    assert runs[0][1][1] != runs[1][1][1]


def test_all_forms_of_the_action_take_the_same_decision() -> None:
    ends: list[Any] = []
    for form in FORMS:
        env = wide_plates.make(action=form)
        E = float(np.floor(np.geomspace(3000.0, 30_000.0, 24)[12] + 0.5))
        batch = env.codec.encode(E, 2.0)
        action = {name: values[0] for name, values in batch.items()} if isinstance(batch, dict) else batch[0]
        env.reset(seed=2)
        ends.append(env.step(action)[:4])
    for other in ends[1:]:
        assert_same(ends[0], other)


def test_contexts_are_given_to_each_sub_environment() -> None:
    env = gym.make_vec(ID, 2)
    env.reset(seed=[4, 4], options={"context": [{"kA": 0.2}, {"kA": 8.0}]})
    for _ in range(3):
        _, rewards, *_ = env.step(np.full((2, 2), -0.7, np.float32))
    assert rewards[0] > rewards[1]


def test_picked_episodes_go_on_like_the_ones_they_were_picked_from() -> None:
    simulation = StripSimulation(read_task("wide_plates"))
    episodes = simulation.start([np.random.default_rng(seed) for seed in (0, 1)])
    E, D = np.array([9000.0, 14_000.0]), np.array([0.0, 1.0])
    simulation.step(episodes, E, D)
    branches = episodes.pick([1, 0, 1])
    outcomes, _ = simulation.step(branches, E[[1, 0, 0]], D[[1, 0, 0]])
    expected, _ = simulation.step(episodes, E, D)
    assert_same(outcomes[:2], expected[::-1].copy())
    assert outcomes[2].tobytes() != outcomes[0].tobytes()
    assert_same(simulation.observe(branches)[:2], simulation.observe(episodes)[::-1].copy())


def test_a_cycle_that_does_not_suit_the_wheel_is_refused() -> None:
    task = read_task("wide_plates")
    with pytest.raises(TaskError, match=r"^a plate of wide_plates is 60 mm wide, the wheel 25 mm: a G82 .*cross_pick"):
        replace(task, cross_pick=0.0)
    with pytest.raises(TaskError, match=r"^a plate of wide_plates is 25 mm wide, the wheel 25 mm: .*leave out cross"):
        replace(task, kinds=(replace(task.kinds[0], width=25.0),))
    for make in (gym.make, gym.make_vec):
        with pytest.raises(TaskError, match=r"^cycle is 'G82', but the blocks of wide_plates are G83"):
            make(ID, cycle="G82")
        with pytest.raises(TaskError, match=r"^cycle is 'G83', but the blocks of wide_rails are G82"):
            make("grind/WideRails-v0", cycle="G83")
    with pytest.raises(TaskError, match=r"^cycle is 'G84', but must be one of G81, G82, G83"):
        wide_plates.make(cycle="G84")
    assert gym.make("grind/WideRails-v0", cycle="G82").unwrapped.task.cycle == "G82"


@pytest.mark.parametrize("make", [any_task.make, lambda **kwargs: any_task.make_vector(2, **kwargs)])
def test_a_task_refuses_a_cycle_that_is_not_its_own(make: Callable[..., Any]) -> None:
    for cycle in ("G81", "G83"):
        with pytest.raises(TaskError, match=rf"^cycle is '{cycle}', but the blocks of power_limited are G82: leave"):
            make(cycle=cycle)


DESTROYED = {"context": {"material": "inconel_718", "kA": 20}}
"""The slowest table overheats this lot so much that the wear flats of the wheel would grow beyond its face."""


def test_a_wheel_that_is_destroyed_grinds_on() -> None:
    env = wide_plates.make(observation="full")
    env.reset(seed=0, options=DESTROYED)
    observation, reward, *_ = env.step(np.array([-1.0, -1.0], np.float32))
    assert np.isfinite(reward) and env.observation_space.contains(observation)
    record = env.record()
    # it stands in the records as the wheel with the largest flats that there is
    assert record.strokes["A"].max() == job_from_surface(env.task).setup.wheel.wear_flat_limit
    assert sum("destroys the wheel; usual are " in warning for warning in record.warnings) == 1


def test_a_task_that_no_g83_can_grind_is_refused() -> None:
    task = read_task("wide_plates")
    with pytest.raises(TaskError, match=r"several kinds"):
        replace(task, kinds=(*task.kinds, replace(task.kinds[0], name="rail")))
    for pick in (0.1, 26.0):
        with pytest.raises(
            TaskError, match=r"^cross_pick is .*from 0.175 mm \(200 strokes\) to the width of the wheel, 25"
        ):
            replace(task, cross_pick=pick)
    with pytest.raises(TaskError, match=r"does not make 16 blocks of whole parts"):
        replace(task, kinds=(replace(task.kinds[0], ends_part=False),), sequence=("plate",))


def test_a_bad_action_and_a_record_of_nothing_are_refused() -> None:
    env = wide_plates.make()
    with pytest.raises(ResetNeeded):
        env.record()
    env.reset(seed=0)
    with pytest.raises(ResetNeeded, match=r"^nothing has been ground: "):
        env.record()
    for action in (np.zeros(3), [np.nan, 0.0], "fast"):
        with pytest.raises(ActionError):
            env.step(action)


@examples(4)
@given(seed=st.integers(0, 10_000), kA=st.sampled_from([0.05, 1.0, 20.0]), slow=st.booleans(), D=st.integers(0, 3))
def test_no_plan_leaves_the_space_or_the_range_that_the_page_states(seed: int, kA: float, slow: bool, D: int) -> None:
    stated = summary(ID).reward
    assert stated is not None
    least, most = stated
    env = wide_plates.make(observation="full", action="dict")
    env.reset(seed=seed, options={"context": {"kA": kA}})
    terminated = False
    while not terminated:
        action = {"E": np.array([3000.0 if slow else 30_000.0], np.float32), "D": D}
        observation, reward, terminated, _, _ = env.step(action)
        assert env.observation_space.contains(observation)
        assert least <= reward <= most


def test_the_page_describes_it() -> None:
    text = page(ID)
    assert "range of the size across the last finished part" in text
    assert "| `scrap` |" in text and "G83" in text

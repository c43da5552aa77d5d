from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.envs.registration import load_env_creator

from grind_env.envs.ids import job
from grind_env.envs.job.loading import EXAMPLE
from grind_env.errors import GrindError
from tests.envs.harness import accepts, assert_same, every_id, native, refusal

WRONG: dict[str, list[Any]] = {
    "observation": [3, "hidden", ["full"], np.array(["full"])],
    "show_block": ["x", 1, None],
    "action": [None, 2, "Box", ["box"], np.array(["box"]), np.array(["box", "box"])],
    "predress": ["no", 0, None],
    "cycle": [83, "G84", ["G82"]],
    "spread": ["1", None, True, -0.1, 2.1, float("nan")],
    "render_mode": [3, "svg", ["ansi"], np.array(["ansi", "ansi"])],
    "info": ["all", None, 1],
}
WRONG_VECTOR: dict[str, list[Any]] = {
    "num_envs": [2.5, "4", None, True, 0, -1, np.float64(2.0)],
    "autoreset_mode": [7, None, "Sometimes", ["NextStep"]],
    "render_mode": ["human"],
    "threads": [0, 1.5, "2", True, None],
    "max_episode_steps": [0, -1, 2.5, "3", True, [4]],
}
every_environment = pytest.mark.parametrize("env_id", every_id())


def refused(make: Any, name: str, value: Any) -> None:
    assert refusal(GrindError, make, **{name: value}).startswith(f"{name} is {value!r}, but ")


@every_environment
def test_an_argument_of_a_wrong_type_is_refused_in_one_sentence(env_id: str) -> None:
    spec = gym.spec(env_id)
    single = load_env_creator(spec.entry_point)
    vector = load_env_creator(spec.vector_entry_point)
    for name, values in WRONG.items():
        for value in values if accepts(env_id, name) else ():
            refused(single, name, value)
            refused(vector, name, value)
    for name, values in WRONG_VECTOR.items():
        for value in values:
            refused(vector, name, value)


def test_a_job_environment_refuses_observation_none() -> None:
    for make in (gym.make, gym.make_vec):
        with pytest.raises(GrindError, match=r"^observation is None, but must be one of measured, full$"):
            make("grind/Job-v0", observation=None)


@pytest.mark.parametrize("name", ["program", "job"])
@pytest.mark.parametrize("value", [3, "a\0b", "\ud800"])
def test_an_impossible_file_name_is_refused(name: str, value: Any) -> None:
    for make in (job.make, job.make_vector):
        refused(make, name, value)


@pytest.mark.parametrize("name", ["program", "job"])
def test_a_path_object_is_refused_and_its_text_accepted(name: str) -> None:
    path = EXAMPLE if name == "program" else EXAMPLE.with_suffix(".toml")
    for make in (job.make, job.make_vector):
        refused(make, name, path)
    for make in (gym.make, gym.make_vec):
        assert str(path) in make("grind/Job-v0", **{name: str(path)}).spec.to_json()


@every_environment
@pytest.mark.parametrize("observation", ["measured", "full"])
def test_every_id_accepts_the_same_keyword_arguments(env_id: str, observation: str) -> None:
    given = {"observation": observation, "show_block": False, "action": "box", "predress": False}
    for env in (gym.make(env_id, **given), native(env_id, 2, **given)):
        assert env.reset(seed=0)[0] in env.observation_space


def test_a_job_environment_refuses_a_cycle() -> None:
    for make in (gym.make, gym.make_vec):
        with pytest.raises(GrindError, match=r"^cycle is 'G82', but .*: leave it out$"):
            make("grind/Job-v0", cycle="G82")


@every_environment
def test_numpy_numbers_are_accepted_like_python_numbers(env_id: str) -> None:
    vector: Any = load_env_creator(gym.spec(env_id).vector_entry_point)
    env, twin = vector(num_envs=np.int64(2)), vector(num_envs=2)
    assert env.num_envs == 2 and type(env.num_envs) is int
    assert_same(env.reset(seed=0), twin.reset(seed=0))
    if accepts(env_id, "predress"):
        vector(predress=np.bool_(False))
    if accepts(env_id, "spread"):
        assert vector(spread=np.float64(0.5)).simulation.spread == 0.5


@every_environment
def test_an_unknown_argument_is_named_in_the_error(env_id: str) -> None:
    for make in (gym.make, gym.make_vec):
        with pytest.raises(TypeError, match="unexpected keyword argument 'obervation'"):
            make(env_id, obervation="full")


def test_the_task_of_an_id_can_be_overridden() -> None:
    env = gym.make("grind/Slot-v0", task="rush").unwrapped
    assert env.task.name == "rush" and native("grind/Slot-v0", 2, task="rush").unwrapped.task.name == "rush"

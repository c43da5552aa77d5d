import copy
import json
import pickle
import warnings
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.envs.registration import EnvSpec
from gymnasium.error import ResetNeeded
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode
from gymnasium.wrappers.vector import RecordEpisodeStatistics
from stable_baselines3.common.env_checker import check_env as sb3_check_env

from grind_env.envs.actions import ActionError
from grind_env.envs.env import GrindEnv
from grind_env.envs.tasks import TaskError
from grind_env.envs.vector_env import GrindVectorEnv
from grind_env.errors import GrindError
from tests.envs.harness import BLOCKS, FORMS, IDS, MODES, actions, assert_same, native

pytestmark = pytest.mark.filterwarnings("error")


def test_the_published_ids_are_registered() -> None:
    names = "Slot JobShop Rush PowerLimited WideRails Oracle6 Blades CBN"
    assert set(IDS) == {f"grind/{name}-v0" for name in names.split()}
    assert set(IDS) <= set(gym.registry)


@pytest.mark.parametrize("observation", ["measured", "full"])
@pytest.mark.parametrize("env_id", IDS)
def test_both_checkers_pass_without_a_warning(env_id: str, observation: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(gym.make(env_id, observation=observation).unwrapped)
        sb3_check_env(gym.make(env_id, observation=observation).unwrapped)


@pytest.mark.parametrize("predress", [False, True])
@pytest.mark.parametrize("form", FORMS)
def test_the_checkers_pass_with_every_form_of_action(form: str, predress: bool) -> None:
    env = gym.make("grind/Rush-v0", action=form, predress=predress)
    with warnings.catch_warnings():
        if form == "dict":  # which is in physical units on purpose
            warnings.filterwarnings("ignore", ".*symmetric and normalized space")
        check_env(env.unwrapped)
    if form != "dict":  # Stable-Baselines3 has no dict actions
        sb3_check_env(env.unwrapped)
    vector = native("grind/Rush-v0", 3, action=form, predress=predress)
    assert vector.single_action_space == env.action_space
    assert vector.action_space.contains(vector.action_space.sample())
    assert json.loads(env.spec.to_json())["kwargs"]["action"] == form


@pytest.mark.parametrize("env_id", IDS)
def test_types_are_those_of_the_python_api(env_id: str) -> None:
    env = gym.make(env_id)
    env.reset(seed=0)
    observation, reward, terminated, truncated, info = env.step(np.zeros(2, np.float32))
    assert isinstance(observation, np.ndarray) and observation.dtype == np.float32
    assert (type(reward), type(terminated), type(truncated)) == (float, bool, bool)
    assert all(type(value) in (float, str) for key, value in info.items() if key != "reward_terms")
    assert all(type(value) is float for value in info["reward_terms"].values())


@pytest.mark.parametrize("env_id", IDS)
def test_an_episode_ends_terminated_with_its_last_block(env_id: str) -> None:
    env = gym.make(env_id)
    published = {"Slot": 30, "JobShop": 96, "Rush": 96, "PowerLimited": 60, "WideRails": 100, "Oracle6": 6}
    blocks = {**published, "Blades": 80, "CBN": 120}[env_id.removeprefix("grind/").removesuffix("-v0")]
    assert blocks == BLOCKS[env_id]
    env.reset(seed=0)
    ends = [env.step(action[0])[2:4] for action in actions(blocks, 1)]
    assert ends == [(False, False)] * (blocks - 1) + [(True, False)]


@pytest.mark.parametrize("env_id", IDS)
def test_the_spec_survives_json(env_id: str) -> None:
    env = gym.make(env_id, observation="full")
    text = env.spec.to_json()
    json.loads(text)
    again = gym.make(EnvSpec.from_json(text))
    assert_same(env.reset(seed=3), again.reset(seed=3))

    spec = native(env_id, 2).spec
    assert spec is not None
    vector = gym.make_vec(env_id, 2, autoreset_mode="SameStep", observation="full")
    again = gym.make_vec(EnvSpec.from_json(vector.spec.to_json()))
    assert again.metadata["autoreset_mode"] is AutoresetMode.SAME_STEP
    assert_same(vector.reset(seed=3), again.reset(seed=3))


@pytest.mark.parametrize("mode", MODES)
def test_make_vec_takes_the_autoreset_mode_by_name_and_as_enum(mode: AutoresetMode) -> None:
    for value in (mode, mode.value):
        env = gym.make_vec("grind/Oracle6-v0", num_envs=3, autoreset_mode=value, observation="full")
        assert isinstance(env.unwrapped, GrindVectorEnv)
        assert env.metadata["autoreset_mode"] is mode
        assert env.num_envs == 3
        assert env.observation_space.shape == (3, *env.single_observation_space.shape)
        assert env.action_space.shape == (3, 2)
    assert "autoreset_mode" not in GrindVectorEnv.metadata


def test_spaces_of_the_single_and_of_the_vector_env_are_equal() -> None:
    for env_id in IDS:
        for observation in ("measured", "full"):
            single = gym.make(env_id, observation=observation)
            vector = native(env_id, 4, observation=observation)
            assert vector.single_observation_space == single.observation_space
            assert vector.single_action_space == single.action_space
            info = single.unwrapped.observation_info()
            assert len(info) == single.observation_space.shape[0]
            assert len({reading.name for reading in info}) == len(info)
            assert all(reading.meaning and reading.noise for reading in info)


@pytest.mark.parametrize("clone", [copy.deepcopy, lambda env: pickle.loads(pickle.dumps(env))])
@pytest.mark.parametrize("env_id", IDS)
def test_a_copied_env_goes_on_identically_and_alone(env_id: str, clone: Any) -> None:
    env = gym.make(env_id)
    env.reset(seed=7)
    plan = actions(env.unwrapped.task.blocks, 1)[:, 0]
    for action in plan[:3]:
        env.step(action)
    twin = clone(env)
    ahead = [twin.step(action) for action in plan[3:]]
    assert_same([env.step(action) for action in plan[3:]], ahead)
    assert env.unwrapped.part_program() == twin.unwrapped.part_program()
    assert_same(env.reset(), twin.reset())


@pytest.mark.parametrize("clone", [copy.deepcopy, lambda env: pickle.loads(pickle.dumps(env))])
@pytest.mark.parametrize("mode", MODES[:2])
def test_a_copied_vector_env_goes_on_identically_and_alone(mode: AutoresetMode, clone: Any) -> None:
    env = native("grind/Oracle6-v0", 3, mode)
    env.reset(seed=7)
    plan = actions(16, 3)
    for action in plan[:3]:
        env.step(action)
    twin = clone(env)
    ahead = [twin.step(action) for action in plan[3:]]
    assert_same([env.step(action) for action in plan[3:]], ahead)


def refusal(error: type[Exception], function: Any, *args: Any, **kwargs: Any) -> str:
    """The message of an error, which must be one line."""
    with pytest.raises(error) as caught:
        function(*args, **kwargs)
    message = str(caught.value)
    assert message and "\n" not in message
    return message


def test_unknown_choices_are_refused_with_the_legal_ones() -> None:
    for make in (GrindEnv, GrindVectorEnv):
        assert "oracle6, power_limited" in refusal(TaskError, make, task="power-limited")
        message = refusal(ActionError, make, action="continuous")
        assert "'continuous'" in message and "box, multidiscrete, discrete, dict" in message
        message = refusal(TaskError, make, observation="hidden")
        assert "'hidden'" in message and "measured, full" in message
        assert "'svg'" in refusal(TaskError, make, render_mode="svg")
    message = refusal(TaskError, gym.make_vec, IDS[0], 2, autoreset_mode="Sometimes")
    assert "'Sometimes'" in message
    assert all(repr(mode.value) in message for mode in MODES)
    assert "0" in refusal(TaskError, GrindVectorEnv, num_envs=0)
    assert issubclass(TaskError, GrindError) and issubclass(ActionError, GrindError)


BAD_ACTIONS: list[tuple[Any, str]] = [
    (np.zeros(3), "shape"),
    (np.zeros((1, 2)), "shape"),
    (0.5, "shape"),
    (None, "shape"),
    ([0.1, [0.2]], "numbers"),
    (["fast", "often"], "numbers"),
    ({"E": 0.1, "D": 0.0}, "numbers"),
    ([np.nan, 0.0], "nan for E"),
    ([0.0, np.nan], "nan for D"),
    ([0.0, np.inf], "inf for D"),
    ([1.0001, 0.0], "1.0001 for E"),
    ([0.0, -1.5], "-1.5 for D"),
]


bad_actions = pytest.mark.parametrize(("action", "part"), BAD_ACTIONS, ids=[str(action) for action, _ in BAD_ACTIONS])


@bad_actions
def test_a_bad_action_is_refused_and_changes_nothing(action: Any, part: str) -> None:
    env, twin = GrindEnv(), GrindEnv()
    env.reset(seed=1)
    twin.reset(seed=1)
    assert part in refusal(ActionError, env.step, action)
    good = np.zeros(2, np.float32)
    assert_same(env.step(good), twin.step(good))
    assert env.part_program() == twin.part_program()


@bad_actions
@pytest.mark.parametrize("mode", MODES)
def test_a_bad_vector_action_is_refused_and_changes_nothing(mode: AutoresetMode, action: Any, part: str) -> None:
    env, twin = (native("grind/PowerLimited-v0", 2, mode) for _ in range(2))
    env.reset(seed=1)
    twin.reset(seed=1)
    message = refusal(ActionError, env.step, [np.zeros(2), action])
    assert part in message or "numbers" in message or "shape" in message
    if "for" in part:
        assert part in message and message.startswith("action 1 ")
    good = np.zeros((2, 2), np.float32)
    assert_same(env.step(good), twin.step(good))


def test_actions_for_another_number_of_envs_are_refused() -> None:
    env = native("grind/PowerLimited-v0", 2)
    env.reset(seed=1)
    for shape in ((2,), (1, 2), (3, 2), (2, 3), (2, 2, 1), (0, 2)):
        message = refusal(ActionError, env.step, np.zeros(shape))
        assert str(shape) in message and "(2, 2)" in message


BAD_FORMS: list[tuple[str, Any, str]] = [
    ("multidiscrete", [0.5, 0], "0.5 for E"),
    ("multidiscrete", [24, 0], "24 for E"),
    ("multidiscrete", [0, 4], "4 for D"),
    ("multidiscrete", [0, -1], "-1 for D"),
    ("multidiscrete", [np.nan, 0], "nan for E"),
    ("multidiscrete", [0, 0, 0], "shape"),
    ("discrete", 96, "96 for E and D"),
    ("discrete", 1.5, "1.5 for E and D"),
    ("discrete", -1, "-1 for E and D"),
    ("discrete", [1, 2], "shape"),
    ("dict", {"E": [2999.0], "D": 0}, "2999 for E"),
    ("dict", {"E": [np.nan], "D": 0}, "nan for E"),
    ("dict", {"E": [9000.0], "D": 0.5}, "0.5 for D"),
    ("dict", {"E": [9000.0], "D": 4}, "4 for D"),
    ("dict", {"E": [9000.0]}, "keys E, D"),
    ("dict", {"E": [9000.0], "D": 0, "predress": 1}, "keys E, D"),
    ("dict", {"E": [9000.0, 1.0], "D": 0}, "shapes E (1, 2)"),
    ("dict", {"E": "fast", "D": 0}, "numbers"),
    ("dict", [0.0, 0.0], "keys E, D"),
]


@pytest.mark.parametrize(("form", "action", "part"), BAD_FORMS)
def test_a_bad_action_of_another_form_is_refused_alike_everywhere(form: str, action: Any, part: str) -> None:
    env, twin = GrindEnv(action=form), GrindEnv(action=form)
    env.reset(seed=1)
    twin.reset(seed=1)
    message = refusal(ActionError, env.step, action)
    assert part in message
    good = env.action_space.sample()
    assert_same(env.step(good), twin.step(good))
    vector = native("grind/PowerLimited-v0", 1, action=form)
    vector.reset(seed=1)
    batch = {name: [value] for name, value in action.items()} if isinstance(action, dict) else [action]
    assert refusal(ActionError, vector.step, batch) == message


def test_stepping_out_of_turn_is_refused() -> None:
    env = GrindEnv("oracle6")
    refusal(ResetNeeded, env.step, np.zeros(2))
    env.reset(seed=0)
    for _ in range(6):
        env.step(np.zeros(2))
    refusal(ResetNeeded, env.step, np.zeros(2))
    env.reset()
    env.step(np.zeros(2))


def test_stepping_a_vector_env_out_of_turn_is_refused() -> None:
    for mode in MODES:
        env = native("grind/Oracle6-v0", 2, mode)
        refusal(ResetNeeded, env.step, np.zeros((2, 2)))
        env.reset(options={"reset_mask": np.array([True, False])})
        refusal(ResetNeeded, env.step, np.zeros((2, 2)))
        env.reset(options={"reset_mask": np.array([False, True])})
        env.step(np.zeros((2, 2)))
    for _ in range(5):
        env.step(np.zeros((2, 2)))
    assert "episode 0" in refusal(ResetNeeded, env.step, np.zeros((2, 2)))
    env.reset(options={"reset_mask": np.array([True, False])})
    assert "episode 1" in refusal(ResetNeeded, env.step, np.zeros((2, 2)))


@pytest.mark.parametrize(
    "mask", [[True, False], None, np.zeros(2, bool), np.ones(2, int), np.ones(3, bool), np.ones((1, 2), bool)]
)
def test_a_bad_reset_mask_is_refused(mask: Any) -> None:
    env = native("grind/Oracle6-v0", 2)
    assert "(2,)" in refusal(GrindError, env.reset, options={"reset_mask": mask})


def test_bad_seeds_are_refused() -> None:
    env = native("grind/Oracle6-v0", 2)
    assert "list of 2" in refusal(GrindError, env.reset, seed=[1, 2, 3])
    for seed in (-1, [1, -1], 0.5, "one", [1, "two"]):
        refusal((GrindError, gym.error.Error), env.reset, seed=seed)


@pytest.mark.parametrize("mode", MODES)
def test_episode_statistics_of_gymnasium_work_on_the_native_env(mode: AutoresetMode) -> None:
    env = RecordEpisodeStatistics(native("grind/Oracle6-v0", 2, mode))
    env.reset(seed=0)
    plan = actions(6, 2)
    total, finished = np.zeros(2), {}
    for action in plan:
        _, rewards, terminated, _, finished = env.step(action)
        total += rewards
    assert terminated.all()
    assert finished["episode"]["l"].tolist() == [6, 6]
    np.testing.assert_allclose(finished["episode"]["r"], total, rtol=1e-12)

    if mode == AutoresetMode.DISABLED:
        env.reset(options={"reset_mask": np.array([True, True])})
    if mode == AutoresetMode.NEXT_STEP:
        env.step(plan[0])
    for action in plan:
        *_, finished = env.step(action)
    assert finished["episode"]["l"].tolist() == [6, 6]
    assert env.episode_count == 4


def test_the_example_of_the_readme_works() -> None:
    namespace: dict[str, Any] = {}
    exec(
        """
import gymnasium as gym
import grind_env

env = gym.make("grind/PowerLimited-v0")
observation, info = env.reset(seed=1)
terminated = False
cost = 0.0
while not terminated:
    observation, reward, terminated, truncated, info = env.step(env.action_space.sample())
    cost += info["block_cost"]
print(info["block"])
""",
        namespace,
    )
    assert namespace["info"]["block"].startswith("G82 X330. I-30. Y-.")
    assert namespace["cost"] > 0.0
    assert namespace["env"].unwrapped.part_program().count("G82") == 60

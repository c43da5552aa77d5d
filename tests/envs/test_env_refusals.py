from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.error import ResetNeeded

from grind_env.envs import task_env_factory
from grind_env.envs.actions import ActionError
from grind_env.envs.tasks import TaskError
from grind_env.errors import GrindError
from tests.envs.harness import IDS, MODES, assert_same, every_id, native, refusal, sync

pytestmark = pytest.mark.filterwarnings("error")


def test_unknown_choices_are_refused_with_the_legal_ones() -> None:
    for make in (task_env_factory.make, task_env_factory.make_vector):
        assert "oracle6, power_limited" in refusal(TaskError, make, task="power-limited")
        assert "box, multidiscrete, discrete, dict" in refusal(ActionError, make, action="continuous")
    message = refusal(TaskError, gym.make_vec, IDS[0], 2, autoreset_mode="Sometimes")
    assert all(repr(mode.value) in message for mode in MODES)


BAD_ACTIONS: list[tuple[Any, str]] = [
    (np.zeros(3), "shape"),
    (0.5, "shape"),
    ([0.1, [0.2]], "numbers"),
    ({"E": 0.1, "D": 0.0}, "numbers"),
    ([np.nan, 0.0], "nan for E"),
    ([0.0, np.inf], "inf for D"),
    ([1.0001, 0.0], "1.0001 for E"),
    ([0.0, -1.5], "-1.5 for D"),
    ([10**400, 10**400], "numbers"),
    ([0.5 + 0.0j, 0.0], "numbers"),
    (np.zeros(2, "m8[s]"), "numbers"),
    (["0", "0"], "numbers"),
    (np.array(["0", 0], object), "numbers"),
    ([b"0", b"0"], "numbers"),
]


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
    ("multidiscrete", [0, np.nan], "nan for D"),
    ("multidiscrete", [0, 0, 0], "shape"),
    ("discrete", 96, "96 for E and D"),
    ("discrete", 1.5, "1.5 for E and D"),
    ("discrete", np.nan, "nan for E and D"),
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


@pytest.mark.parametrize(("form", "action", "part"), [*(("box", *bad) for bad in BAD_ACTIONS), *BAD_FORMS])
def test_a_bad_action_changes_nothing_and_gives_the_same_error_in_a_vector(form: str, action: Any, part: str) -> None:
    arguments = {"action": form, "out_of_range": "raise"}
    env, twin = task_env_factory.make(**arguments), task_env_factory.make(**arguments)
    env.reset(seed=1)
    twin.reset(seed=1)
    message = refusal(ActionError, env.step, action)
    assert part in message
    if part == "shape":
        assert message.startswith(f"the action has shape {np.shape(action)}, but must have shape ")
    good = env.action_space.sample()
    assert_same(env.step(good), twin.step(good))
    assert env.part_program() == twin.part_program()
    vector = native("grind/PowerLimited-v0", 1, **arguments)
    vector.reset(seed=1)
    batch = {name: [value] for name, value in action.items()} if isinstance(action, dict) else [action]
    told = refusal(ActionError, vector.step, batch)
    assert told == message or ("an array of numbers" if part == "numbers" else f"shape {np.shape(batch)}") in told


def test_stepping_out_of_turn_is_refused() -> None:
    env = task_env_factory.make("oracle6")
    refusal(ResetNeeded, env.step, np.zeros(2))
    refusal(ResetNeeded, env.record)
    env.reset(seed=0)
    assert refusal(ResetNeeded, env.record).startswith("nothing has been ground: ")
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
    env, twin = (native("grind/Oracle6-v0", 2) for _ in range(2))
    assert_same(env.reset(seed=7), twin.reset(seed=7))
    assert "list of 2" in refusal(GrindError, env.reset, seed=[1, 2, 3])
    arrays = (np.array(-3), np.array(0.5), np.array([[1, 2]]), np.array([1.0, 2.0]), np.array("a"))
    for seed in (-1, [1, -1], 0.5, "one", [1, "two"], True, [True, False], *arrays):
        refusal((GrindError, gym.error.Error), env.reset, seed=seed)
    assert_same(env.reset(), twin.reset())


@pytest.mark.parametrize("env_id", every_id())
def test_a_vector_env_reports_its_seeds_like_gymnasium(env_id: str) -> None:
    env, twin = native(env_id, 3), sync(env_id, 3)
    drawn = [each.unwrapped.np_random_seed for each in (env, native(env_id, 3))]
    assert drawn[0] != drawn[1] and len(set(drawn[0])) == 3
    for given in (5, [7, None, 8], None, np.array(3)):
        env.reset(seed=given)
        twin.reset(seed=int(given) if isinstance(given, np.ndarray) else given)
        assert env.unwrapped.np_random_seed == twin.unwrapped.np_random_seed
    assert env.unwrapped.np_random_seed == (3, 4, 5)
    env.reset(seed=20, options={"reset_mask": np.array([False, True, False])})
    assert env.unwrapped.np_random_seed == (3, 21, 5)

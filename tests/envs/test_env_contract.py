"""The contract of every registered environment with every kind of action."""

import copy
import functools
import itertools
import json
import pickle
import warnings
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium import spaces
from gymnasium.envs.registration import EnvSpec
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode, VectorEnv

from grind_env.envs import task_env_factory
from grind_env.envs.actions import ActionCodec, ActionError
from grind_env.envs.env import GrindEnv
from grind_env.envs.simulation import Simulation
from grind_env.envs.vector_env import GrindVectorEnv
from tests.envs import harness
from tests.envs.contract import check_vector_env
from tests.examples import few

pytestmark = pytest.mark.filterwarnings("error")

SHORT = {"wide_plates": 2}  #: blocks of a shortened episode; 8 for the other tasks

SPACES = dict(zip(harness.FORMS, (spaces.Box, spaces.MultiDiscrete, spaces.Discrete, spaces.Dict), strict=True))

#: environments without a pre-dress in their action, and the reason
NO_PRE_DRESS = {"grind/Job-v0": "the program says which cycles begin with a dress"}


def kinds_of(env_id: str) -> list[dict[str, Any]]:
    """Return keyword arguments for every kind of action, with a pre-dress for one kind (Oracle6: for every kind)."""
    forms: list[dict[str, Any]] = [{"action": form} for form in harness.FORMS]
    dressing = forms if env_id == "grind/Oracle6-v0" else forms[:1]
    return [*forms, *({**form, "predress": True} for form in dressing if env_id not in NO_PRE_DRESS)]


def parametrized(cases: list[tuple[str, dict[str, Any]]]) -> pytest.MarkDecorator:
    names = ["-".join([env_id.removeprefix("grind/"), *map(str, kwargs.values())]) for env_id, kwargs in cases]
    return pytest.mark.parametrize(("env_id", "kwargs"), cases, ids=names)


CASES = [(env_id, kwargs) for env_id in harness.every_id() for kwargs in kinds_of(env_id)]
ALL_KINDS = ("grind/Oracle6-v0", "grind/Job-v0")
every_environment = pytest.mark.parametrize("env_id", harness.every_id())
every_kind = parametrized(CASES)
#: most environments have one kind of action here, in turn: another test shows that all kinds are equivalent
a_kind_of_each = parametrized(
    [
        (env_id, kwargs)
        for k, env_id in enumerate(harness.every_id())
        for kinds in [kinds_of(env_id)]
        for kwargs in (kinds if env_id in ALL_KINDS else [kinds[k % len(kinds)]])
    ]
)
every_clone = pytest.mark.parametrize(
    "clone", [copy.deepcopy, lambda env: pickle.loads(pickle.dumps(env))], ids=["deepcopy", "pickle"]
)


@functools.cache
def short_simulation(env_id: str, observation: str = "measured", predress: bool = False) -> Simulation:
    """Return the simulation of an environment with few blocks, so that its episodes end sooner.

    It is cached: all state of an environment is in its episodes, and the simulation does not change.
    """
    simulation: Simulation = gym.make(env_id, observation=observation).unwrapped.simulation
    if env_id == "grind/Job-v0":
        return simulation
    task = simulation.task
    task = replace(task, blocks=min(task.blocks, SHORT.get(task.name, 8)))
    return task_env_factory.simulation_of(task, observation=observation, predress=predress)


def short_vector(env_id: str, mode: AutoresetMode, **kwargs: Any) -> VectorEnv:
    """Return the native vector form of an environment with short episodes."""
    own = {name: kwargs.pop(name) for name in ("observation", "predress") if name in kwargs}
    return GrindVectorEnv(short_simulation(env_id, **own), 2, autoreset_mode=mode, **kwargs)


def short_single(env_id: str, **kwargs: Any) -> gym.Env[Any, Any]:
    """Return the single form of an environment with short episodes."""
    own = {name: kwargs.pop(name) for name in ("observation", "predress") if name in kwargs}
    return GrindEnv(short_simulation(env_id, **own), **kwargs)


def play(env: gym.Env[Any, Any], most: int, seed: int = 0) -> list[Any]:
    """Return random actions up to the end of an episode, at most `most`."""
    env.action_space.seed(0)
    env.reset(seed=seed)
    plan: list[Any] = []
    terminated = False
    while not terminated and len(plan) < most:
        plan.append(env.action_space.sample())
        terminated = env.step(plan[-1])[2]
    return plan


def test_the_published_ids_are_registered() -> None:
    names = "Slot JobShop Rush PowerLimited WideRails Oracle6 Blades CBN Memory Noise Credit"
    assert set(harness.IDS) == {f"grind/{name}-v0" for name in names.split()}
    assert set(harness.IDS) | {f"grind/{name}-v0" for name in ("Job", "Reciprocation")} <= set(harness.every_id())
    assert set(harness.every_id()) >= NO_PRE_DRESS.keys()


def made(env_id: str, **kwargs: Any) -> list[gym.Space[Any]]:
    """Return the action spaces of the single and of the vector environment."""
    return [gym.make(env_id, **kwargs).action_space, harness.native(env_id, 2, **kwargs).single_action_space]


def refused(env_id: str, **kwargs: Any) -> None:
    for make in (gym.make, gym.make_vec):
        assert env_id in harness.refusal(ActionError, make, env_id, **kwargs)


@every_environment
def test_every_id_has_every_kind_of_action_or_says_why_not(env_id: str) -> None:
    for form, space in SPACES.items():
        assert [type(each) for each in made(env_id, action=form)] == [space, space]
    if env_id not in NO_PRE_DRESS:
        assert [each.shape for each in made(env_id, predress=True)] == [(3,), (3,)]
    elif harness.accepts(env_id, "predress"):
        refused(env_id, predress=True)


@pytest.mark.parametrize("env_id", harness.every_id())
def test_the_same_decisions_make_the_same_episode_in_every_form(env_id: str) -> None:
    rng, runs = np.random.default_rng(0), []
    codec: ActionCodec = gym.make(env_id, action="discrete").unwrapped.codec
    plan = [(float(rng.choice(codec.levels)), float(rng.integers(codec.executions + 1))) for _ in range(6)]
    for form in harness.FORMS:
        env = gym.make(env_id, action=form).unwrapped
        env.reset(seed=4)
        steps: list[Any] = []
        while len(steps) < len(plan) and not (steps and steps[-1][2]):
            steps.append(env.step(harness.rows_of(env.codec.encode(*plan[len(steps)]), 1)[0]))
        runs.append(steps)
    for run in runs[1:]:
        harness.assert_same(runs[0], run)
    chosen = [(step[4]["E"], step[4]["D"]) for step in runs[0]]
    assert chosen == plan[: len(chosen)]


@every_kind
def test_both_checkers_pass_without_a_warning(env_id: str, kwargs: dict[str, Any]) -> None:
    shown = {"observation": ("measured", "full")[CASES.index((env_id, kwargs)) % 2]}
    env = gym.make(env_id, **kwargs, **(shown if harness.accepts(env_id, "observation") else {}))
    with warnings.catch_warnings():
        if kwargs.get("action") == "dict":  # dict actions have physical units on purpose
            warnings.filterwarnings("ignore", ".*symmetric and normalized space")
        check_env(env.unwrapped)
    if kwargs.get("action") != "dict":  # Stable-Baselines3 has no dict actions
        harness.sb3_check_env(env.unwrapped)


@pytest.mark.bits
@a_kind_of_each
def test_the_vector_form_keeps_the_contract(env_id: str, kwargs: dict[str, Any]) -> None:
    # every other case shows the blocks, the full observation and the full info
    odd = bool(CASES.index((env_id, kwargs)) % 2)
    shown = "full" if odd else "measured"
    kwargs = {**kwargs, "show_block": odd, "observation": shown, "info": shown}
    longest = max(len(play(short_single(env_id, **kwargs), 10_000, seed)) for seed in range(4))
    check_vector_env(
        lambda mode: short_vector(env_id, mode, **kwargs), lambda: short_single(env_id, **kwargs), 2 * longest + 4
    )


@pytest.mark.parametrize("mode", harness.MODES)
def test_no_two_arrays_of_a_result_share_memory(mode: AutoresetMode) -> None:
    env = harness.native("grind/Oracle6-v0", 2, mode, show_block=True)
    env.reset(seed=1)
    env.step(np.zeros((2, 2)))
    env.reset(options={"reset_mask": np.array([True, False])})
    for _ in range(5):
        result = env.step(np.zeros((2, 2)))
    assert result[2].tolist() == [False, True]
    found = arrays(result)
    assert len(found) > 20
    assert not any(np.shares_memory(a, b) for a, b in itertools.combinations(found, 2))


def arrays(value: Any) -> list[np.ndarray]:
    """Return all arrays of a result, also those within arrays of objects."""
    if isinstance(value, np.ndarray):
        return [value, *(part for each in value if value.dtype == object for part in arrays(each))]
    parts = value.values() if isinstance(value, dict) else value if isinstance(value, tuple) else ()
    return [array for part in parts for array in arrays(part)]


@pytest.mark.bits
@a_kind_of_each
def test_workers_and_the_native_form_give_the_same_bits(env_id: str, kwargs: dict[str, Any]) -> None:
    assert_workers_are_alike(env_id, 2, harness.sampled(env_id, 4, 2, **kwargs), "fork", **kwargs)


def assert_workers_are_alike(env_id: str, count: int, plan: list[Any], context: str, **kwargs: Any) -> None:
    kwargs |= harness.quiet(env_id)
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", ".*use of fork", DeprecationWarning)
        workers = gym.make_vec(env_id, count, vectorization_mode="async", vector_kwargs={"context": context}, **kwargs)
    try:
        env = harness.native(env_id, count, **kwargs)
        harness.assert_same(env.reset(seed=5), workers.reset(seed=5))
        for batch in plan:
            harness.assert_same(env.step(batch), workers.step(batch))
    finally:
        workers.close()


@pytest.mark.bits
@pytest.mark.parametrize("env_id", few(["grind/PowerLimited-v0", "grind/Job-v0"]))
def test_spawned_workers_and_the_native_form_give_the_same_bits(env_id: str) -> None:
    # one worker: each takes seconds to start
    assert_workers_are_alike(env_id, 1, harness.sampled(env_id, 3, 1), "spawn")


def assert_resumed(env: Any, clone: Callable[[Any], Any], plan: list[Any]) -> None:
    """Step half of the plan; then the environment and a copy of it must do the same in the rest."""
    env.reset(seed=7)
    half = len(plan) // 2
    for action in plan[:half]:
        env.step(action)
    twin = clone(env)
    ahead = [twin.step(action) for action in plan[half:]]
    harness.assert_same([env.step(action) for action in plan[half:]], ahead)
    if hasattr(env.unwrapped, "part_program"):
        assert env.unwrapped.part_program() == twin.unwrapped.part_program()
    harness.assert_same(env.reset(), twin.reset())


@every_clone
@every_kind
def test_a_copied_env_continues_identically_and_independently(env_id: str, kwargs: dict[str, Any], clone: Any) -> None:
    assert_resumed(gym.make(env_id, **kwargs), clone, play(gym.make(env_id, **kwargs), 9, seed=7))
    mode = harness.MODES[CASES.index((env_id, kwargs)) % 2]
    assert_resumed(short_vector(env_id, mode, **kwargs), clone, harness.sampled(env_id, 14, 2, **kwargs))


@every_kind
def test_the_spec_survives_json(env_id: str, kwargs: dict[str, Any]) -> None:
    env = gym.make(env_id, **kwargs)
    assert env.spec is not None
    text = env.spec.to_json()
    assert json.loads(text)["kwargs"] | kwargs == json.loads(text)["kwargs"]
    again = gym.make(EnvSpec.from_json(text))
    harness.assert_same(env.reset(seed=3), again.reset(seed=3))
    action = env.action_space.sample()
    harness.assert_same(env.step(action), again.step(action))

    vector = harness.native(env_id, 2, "SameStep", **kwargs)
    assert vector.spec is not None
    twin = gym.make_vec(EnvSpec.from_json(vector.spec.to_json()))
    assert twin.metadata["autoreset_mode"] is AutoresetMode.SAME_STEP
    assert twin.action_space == vector.action_space
    harness.assert_same(vector.reset(seed=3), twin.reset(seed=3))
    actions = vector.action_space.sample()
    harness.assert_same(vector.step(actions), twin.step(actions))


@every_environment
def test_step_returns_the_types_of_the_gymnasium_api(env_id: str) -> None:
    env = gym.make(env_id)
    env.reset(seed=0)
    observation, reward, terminated, truncated, info = env.step(env.action_space.sample())
    assert isinstance(observation, np.ndarray) and observation.dtype == np.float32
    assert (type(reward), type(terminated), type(truncated)) == (float, bool, bool)
    assert all(type(value) is float for value in info.values())


@every_environment
def test_every_entry_of_an_observation_has_a_name_a_meaning_and_its_noise(env_id: str) -> None:
    env = gym.make(env_id, observation="full")
    info = env.unwrapped.observation_info()
    assert len(info) == env.observation_space.shape[0] == len({reading.name for reading in info})
    assert all(reading.meaning and reading.noise for reading in info)

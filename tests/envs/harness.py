"""Helpers of the environment tests: ids, actions, rollouts and exact comparison."""

import inspect
from collections.abc import Callable
from dataclasses import replace
from importlib.util import find_spec
from types import SimpleNamespace
from typing import Any, NamedTuple

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.envs.registration import load_env_creator
from gymnasium.vector import AutoresetMode, VectorEnv
from numpy.typing import NDArray

import grind_env
from grind_env.envs.cost import Outcome
from grind_env.envs.episode_state import NOISE, Episodes
from grind_env.envs.job.job_noise_tape import NEW_LOT, JobGenerator, conditions_of
from grind_env.envs.noise_tape import SOURCE, TapeRow
from grind_env.envs.reset_options import Given
from grind_env.envs.simulation import Simulation
from grind_env.envs.task_names import environment_id, task_names
from grind_env.envs.tasks import Task, load_task
from grind_env.machine.job import Lots, PartConditions
from grind_env.machine.loops.row_io import OWN_FROM
from grind_env.machine.loops.stroke_totals import Tally
from grind_env.process.stroke_types import WheelState

gym.register_envs(grind_env)

IDS = [environment_id(name) for name in task_names()]
BLOCKS = {environment_id(name): load_task(name).blocks for name in task_names()}
FORMS = ("box", "multidiscrete", "discrete", "dict")
MODES = list(AutoresetMode)

Array = NDArray[Any]


def every_id() -> list[str]:
    """Return the ids of all environments of the package."""
    return sorted(name for name in gym.registry if name.startswith("grind/"))


def accepts(env_id: str, name: str) -> bool:
    """Return whether an environment has a keyword argument of the given name."""
    return name in inspect.signature(load_env_creator(gym.spec(env_id).entry_point)).parameters


def quiet(env_id: str) -> dict[str, Any]:
    """Return the keyword argument that keeps the text of the blocks out of the info."""
    return {"show_block": False} if accepts(env_id, "show_block") else {}


def sb3_check_env(env: gym.Env[Any, Any]) -> None:
    """Run the checker of Stable-Baselines3, which `make contract` does without."""
    if find_spec("stable_baselines3") is not None:
        from stable_baselines3.common.env_checker import check_env

        check_env(env)


def reward_terms_of(info: dict[str, Any]) -> dict[str, Any]:
    """Return the terms of the reward by name, numbers or arrays of shape (N,)."""
    return {name.removeprefix("reward_"): value for name, value in info.items() if name.startswith("reward_")}


def actions(steps: int, num_envs: int, seed: int = 0) -> Array:
    """Return uniform actions, shape (steps, num_envs, 2), float32."""
    return np.random.default_rng(seed).uniform(-1.0, 1.0, (steps, num_envs, 2)).astype(np.float32)


def sampled(env_id: str, steps: int, num_envs: int, **kwargs: Any) -> list[Any]:
    """Return batches of actions sampled from the action space of the vector env."""
    space = native(env_id, num_envs, **kwargs).action_space
    space.seed(0)
    return [space.sample() for _ in range(steps)]


NOTHING_GIVEN = Given()
USUAL_LOTS = Lots()


class JobTape(NamedTuple):
    """Draws of an episode of a job: its parts, a flag where a part begins a lot, and the noise of each block."""

    conditions: tuple[PartConditions, ...]
    new_lot: tuple[bool, ...]
    noise: Array


def job_tape(tape: Array, conditions: tuple[PartConditions, ...], part_of_block: Array) -> JobTape:
    """Return the draws on a tape of shape (blocks, fields of `TapeRow`)."""
    first = np.flatnonzero(np.diff(part_of_block, prepend=-1))
    return JobTape(conditions, tuple((tape[first, NEW_LOT] > 0.0).tolist()), tape[:, NOISE])


def job_drawn(
    rng: np.random.Generator, parts: int, spread: float, given: Given = NOTHING_GIVEN, lots: Lots = USUAL_LOTS
) -> JobTape:
    """Draw an episode of a job with `parts` parts of one block each."""
    blocks, wheel = np.arange(parts), np.zeros(len(WheelState._fields))
    tape, source = np.empty((1, parts, len(TapeRow._fields))), np.zeros((1, SOURCE))
    numbers = {"block": np.zeros(1, np.int64), "schedule": np.zeros((1, parts), np.int16)}
    drawn: Any = SimpleNamespace(tape=tape, source=source, wheels=np.empty((1, len(wheel))), **numbers)
    generator = JobGenerator(blocks.tolist(), lots, [0.2] * parts, spread, wheel)
    generator.begin(drawn, np.array([0]), [rng], [given])
    return job_tape(tape[0], conditions_of(tape[0], blocks, parts, [0.2] * parts), blocks)


def whole_tape(env: Any) -> np.ndarray:
    """Return the tape of the current episode of an environment, shape (blocks, fields of `TapeRow`)."""
    return env.unwrapped.simulation.with_full_tapes(env.unwrapped.episodes).tape[0]


def tape_of_job(env: Any) -> JobTape:
    """Return the draws of the current episode of a job environment."""
    simulation, episodes = env.simulation, env.episodes
    return job_tape(episodes.tape[0], simulation.conditions(episodes, 0), simulation.part_of_block)


def rows_of(batch: Any, count: int) -> list[Any]:
    """Return the actions of a batch, one for each single env."""
    if isinstance(batch, dict):
        return [{name: values[i] for name, values in batch.items()} for i in range(count)]
    return [batch[i] for i in range(count)]


def without_expansion(task: Task) -> Task:
    """Return the task with materials without thermal expansion, so that the cooling time of a part has no effect."""
    materials = {name: replace(each, thermal_expansion=0.0) for name, each in task.catalogue.materials.items()}
    return replace(task, catalogue=replace(task.catalogue, materials=materials))


def native(env_id: str, num_envs: int, mode: AutoresetMode | str = AutoresetMode.NEXT_STEP, **kwargs: Any) -> VectorEnv:
    return gym.make_vec(env_id, num_envs, autoreset_mode=mode, **kwargs)


def sync(env_id: str, num_envs: int, mode: AutoresetMode = AutoresetMode.NEXT_STEP, **kwargs: Any) -> VectorEnv:
    return gym.make_vec(
        env_id,
        num_envs,
        vectorization_mode="sync",
        vector_kwargs={"autoreset_mode": mode},
        **{**quiet(env_id), **kwargs},
    )


def row_of(stepped: Any, i: int) -> Any:
    """Return the result of a step as the single env i would return it."""
    observations, rewards, terminated, truncated, info = stepped
    return observations[i], float(rewards[i]), bool(terminated[i]), bool(truncated[i]), info_of(info, i)


def info_of(info: dict[str, Any], i: int) -> dict[str, Any]:
    values = {}
    for name, value in info.items():
        if not name.startswith("_"):
            assert info[f"_{name}"][i]
            values[name] = info_of(value, i) if isinstance(value, dict) else value.tolist()[i]
    return values


def assert_same(a: Any, b: Any, place: str = "result") -> None:
    """Fail unless a and b have the same types, keys, shapes, dtypes and bits."""
    assert type(a) is type(b), f"{place}: {type(a)} and {type(b)}"
    if isinstance(a, dict):
        assert a.keys() == b.keys(), f"{place}: {sorted(a)} and {sorted(b)}"
        for key in a:
            assert_same(a[key], b[key], f"{place}[{key!r}]")
    elif isinstance(a, tuple | list):
        assert len(a) == len(b), place
        for k, (x, y) in enumerate(zip(a, b, strict=True)):
            assert_same(x, y, f"{place}[{k}]")
    elif isinstance(a, np.ndarray):
        assert (a.dtype, a.shape) == (b.dtype, b.shape), f"{place}: {a.dtype}{a.shape} and {b.dtype}{b.shape}"
        if a.dtype == object:
            assert_same(a.tolist(), b.tolist(), place)
        else:
            assert a.tobytes() == b.tobytes(), f"{place}: {a} and {b}"
    else:
        assert a == b, f"{place}: {a!r} and {b!r}"


def refusal(error: Any, function: Callable[..., Any], *args: Any, **kwargs: Any) -> str:
    """Return the message of the expected error, which must be one line."""
    with pytest.raises(error) as caught:
        function(*args, **kwargs)
    message = str(caught.value)
    assert message and "\n" not in message
    return message


def rollout(
    simulation: Simulation, episodes: Episodes, speeds: Array | float, executions: Array | float
) -> tuple[Outcome, Array, Array]:
    """Run whole episodes.

    Args:
        simulation: the simulation.
        episodes: N fresh episodes.
        speeds: E in mm/min, broadcast to (blocks, N).
        executions: D, broadcast to (blocks, N).

    Returns:
        Outcomes, each field of shape (blocks, N); cycle results, shape (blocks, N, fields of `Tally`);
        observations before every block and after the last one, shape (blocks + 1, N, entries).
    """
    shape = (simulation.task.blocks, len(episodes.block))
    outcomes, results, observations = [], [], [simulation.observe(episodes)]
    for E, D in zip(np.broadcast_to(speeds, shape), np.broadcast_to(executions, shape), strict=True):
        outcome, result = simulation.step(episodes, np.array(E, float), np.array(D, float))
        outcomes.append(outcome)
        results.append(result)
        observations.append(simulation.observe(episodes))
    return Outcome(*np.moveaxis(np.array(outcomes), 2, 0)), np.array(results), np.array(observations)


class Course:
    """Episodes of a task with their draws and results, arrays of shape (blocks, N) and (blocks + 1, N)."""

    def __init__(self, simulation: Simulation, speeds: Array, executions: Array) -> None:
        self.simulation, self.task = simulation, simulation.task
        self.speeds, self.executions = speeds, executions
        episodes = start(simulation, speeds.shape[1])
        self.tape = TapeRow(*np.moveaxis(episodes.tape, 2, 0))
        self.kinds = self.tape.kind.T.astype(int)
        outcomes, results, wheels, observations = [], [], [], []
        for E, D in [*zip(speeds, executions, strict=True), (None, None)]:
            wheels.append(episodes.wheels.copy())
            observations.append(simulation.observe(episodes))
            if E is not None:
                outcome, result = simulation.step(episodes, E, D)
                outcomes.append(outcome)
                results.append(result)
        self.outcome = Outcome(*np.moveaxis(np.array(outcomes), 2, 0))
        self.result = Tally(*np.moveaxis(np.array(results), 2, 0))
        self.wheels = WheelState(*np.moveaxis(np.array(wheels)[:, :, :OWN_FROM], 2, 0))
        self.observations = np.array(observations)

    def of_kind(self, field: str) -> Array:
        """Return a field of the kind of every block, shape (blocks, N)."""
        return np.array([getattr(kind, field) for kind in self.task.kinds])[self.kinds]


def start(simulation: Simulation, count: int, seed: int = 0) -> Episodes:
    """Return fresh episodes with the seeds `seed`, `seed + 1`, ..."""
    return simulation.start([np.random.default_rng(seed + i) for i in range(count)])

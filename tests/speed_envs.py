"""Speed of the environments against their kernel and plain Python: part of `make speed`."""

import time
import tracemalloc
from collections.abc import Callable, Iterator
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium import spaces
from rich.table import Table

from grind_env.array_types import Array
from grind_env.control.cycles.plunge import PlungeCycle
from grind_env.envs.blocks.task_simulation import NO_SETTINGS
from grind_env.envs.step_arrays import Choices, EpisodeArrays, Scratch, Tables
from grind_env.envs.task_gauges import GAUGE
from grind_env.envs.transition import stages_of
from grind_env.kernel import compile_at_once
from grind_env.machine.loops.machine_lanes import NO_MOTIONS, longest_first_of
from grind_env.machine.loops.stroke_totals import Tally
from grind_env.process.process_interface import PROCESS
from tests.batches import PLUNGES

compile_at_once()

#: tasks of G82 blocks, timed beside their kernel
TASKS = ("Slot", "PowerLimited", "WideRails", "Blades", "Rush", "JobShop", "CBN", "Oracle6")
SIZES = (64, 256, 1024, 4096)  #: numbers of environments in a vector env
WITH_RESETS, BYTES = 1.3, 5000.0  #: targets: vector steps over their kernel; bytes that an environment takes up
SECONDS = 1.0  #: approximate time of the measurement of each task and size


class EmptyEnv(gym.Env[Any, Any]):
    """Environment that only returns a Box observation of `size` numbers."""

    def __init__(self, size: int) -> None:
        self.observation_space = spaces.Box(-1.0, 1.0, (size,), np.float32)
        self.action_space = spaces.Box(-1.0, 1.0, (2,), np.float32)
        self.values = [0.0] * size

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        return np.array(self.values, np.float32), 0.0, False, False, {}


def seconds(clock: Callable[[], float], call: Callable[..., object], *arguments: Any) -> float:
    """Return the time of one call, s."""
    begin = clock()
    call(*arguments)
    return clock() - begin


def actions_of(env_id: str, n: int) -> Any:
    """Return a random action for every block of an episode, shape (blocks, n, 2)."""
    blocks = gym.make(env_id).unwrapped.task.blocks
    return np.random.default_rng(0).uniform(-1.0, 1.0, (blocks, n, 2)).astype(np.float32)


def vector_rounds(
    env_id: str, actions: Any, clock: Callable[[], float] = time.process_time
) -> Iterator[tuple[Array, Array, float]]:
    """Yield for each round the seconds of every vector step of an episode, of each kernel, and of the restart.

    The last step includes a restart. Every step is timed once a round, and its kernel just before it. CPU time by
    default: other work on the machine counts less in it than in wall time.
    """
    blocks, n, _ = actions.shape
    env = gym.make_vec(env_id, n, autoreset_mode="SameStep").unwrapped
    episodes, simulation = env.episodes, env.simulation
    results = np.zeros((n, len(Tally._fields)))
    everyone, order = np.arange(n), np.empty(n, np.int64)
    nothing, longest_first = np.zeros(n), longest_first_of(PlungeCycle)
    prepare, grind, _ = stages_of(PROCESS, GAUGE, True)
    tables = Tables(*simulation._tables(Scratch().take(n)))
    cycles, parameters = tables.cycles, tables.parameters

    def kernel() -> None:
        longest_first(cycles, everyone, order)
        PLUNGES.lanes(cycles, parameters, episodes.wheels, episodes.parts, results, NO_MOTIONS, order, 0, 1)

    for _ in rounds(time.perf_counter() + SECONDS):
        steps, cores = np.empty(blocks), np.empty(blocks)
        env.reset(seed=0)
        for k, action in enumerate(actions):
            wheels, parts = episodes.wheels.copy(), episodes.parts.copy()
            memory, stages = episodes.memory.copy(), episodes.stages.copy()
            choices = Choices(*env.codec.decode(action), nothing, NO_SETTINGS)
            state = EpisodeArrays(*episodes.in_order())
            results[:] = 0.0
            prepare(tables, state, choices, everyone, results)
            ready, tallies = (episodes.wheels.copy(), episodes.parts.copy()), results.copy()
            grind(tables, state, choices, everyone, results)  # also writes the cycles
            (episodes.wheels[:], episodes.parts[:]), results[:] = ready, tallies
            cores[k] = seconds(clock, kernel)
            episodes.wheels[:], episodes.parts[:] = wheels, parts
            episodes.memory[:], episodes.stages[:] = memory, stages
            steps[k] = seconds(clock, env.step, action)
        yield steps, cores, seconds(clock, env.reset)


def vector_episode(
    env_id: str, actions: Any, clock: Callable[[], float] = time.process_time
) -> tuple[float, float, float]:
    """Return the seconds of an episode in the vector env: steps with the final restart, kernel, restart alone.

    Each step, kernel and restart counts with its shortest time of all rounds.
    """
    steps, cores, restarts = zip(*vector_rounds(env_id, actions, clock), strict=True)
    return float(np.min(steps, axis=0).sum()), float(np.min(cores, axis=0).sum()), min(restarts)


def rounds(end: float) -> Iterator[int]:
    """Count rounds until a time, but at least three."""
    number = 0
    while number < 3 or time.perf_counter() < end:
        yield number
        number += 1


def single_step(env_id: str) -> tuple[float, float]:
    """Return the mean seconds of a step of the single env without its strokes, and of an empty step.

    Wall time: reading the CPU clock takes as long as an empty step.
    """
    clock = time.perf_counter
    actions = actions_of(env_id, 1)
    env = gym.make(env_id, show_block=False).unwrapped
    empty = EmptyEnv(env.observation_space.shape[0])
    steps, nothing = np.full(len(actions), np.inf), np.full(len(actions), np.inf)
    for _ in rounds(time.perf_counter() + SECONDS):
        env.reset(seed=0)
        for k, (action,) in enumerate(actions):
            steps[k] = min(steps[k], seconds(clock, env.step, action))
            nothing[k] = min(nothing[k], seconds(clock, empty.step, action))
    _, core, _ = vector_episode(env_id, actions, clock)
    return float(steps.sum() - core) / len(actions), float(nothing.mean())


def over_kernel(env_id: str, n: int) -> Array:
    """Return the time ratio of the vector steps of an episode, resets included, to their kernel; one a round."""
    return np.array([steps.sum() / cores.sum() for steps, cores, _ in vector_rounds(env_id, actions_of(env_id, n))])


def bytes_each(env_id: str, n: int) -> float:
    """Return the memory of a vector env per environment between two steps, bytes."""
    gym.make_vec(env_id, 1)
    tracemalloc.start()
    env = gym.make_vec(env_id, n)
    env.reset(seed=0)
    env.step(actions_of(env_id, n)[0])
    held, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    return held / n


def quartiles(values: Array) -> str:
    """Return the median and the quartiles of some numbers as text."""
    low, middle, high = np.quantile(values, [0.25, 0.5, 0.75])
    return f"{middle:.2f} ({low:.2f} to {high:.2f})"


def table() -> Table:
    """Return a table of step times with quartiles and of the memory of an environment."""
    result, env_id = Table(title="Environments"), "grind/PowerLimited-v0"
    for name in ("measure", "value", "target"):
        result.add_column(name, justify="left" if name == "measure" else "right")
    for task in TASKS:
        for n in SIZES:
            values = over_kernel(f"grind/{task}-v0", n)
            measure = f"{task}: vector steps over their kernel, resets included, N = {n}"
            result.add_row(measure, quartiles(values), f"<= {WITH_RESETS}")
    result.add_row("memory of an environment", f"{bytes_each(env_id, SIZES[-1]):,.0f} bytes", f"<= {BYTES:,.0f}")
    return result

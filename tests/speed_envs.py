"""Speed of the environments against their kernel and plain Python: part of `make speed`."""

import time
from collections.abc import Callable

import gymnasium as gym
import numpy as np
from rich.table import Table

import grind_env
from grind_env.envs import step
from grind_env.machine.batch import longest_first
from grind_env.machine.block import run_blocks

EMPTY_STEP = 3.9
"""us; an `Env.step` that only makes a Box observation, as measured for the design."""

BLOCKS = 10
"""Steps into the episode at which a step is timed."""


def fastest(call: Callable[[], object], repeats: int = 200) -> float:
    """Shortest time of a call, s."""
    best = np.inf
    for _ in range(repeats):
        begin = time.perf_counter()
        call()
        best = min(best, time.perf_counter() - begin)
    return float(best)


def vector_step(env_id: str, n: int) -> tuple[float, float]:
    """Time of a whole vector step and of the kernel within it, s."""
    env = gym.make_vec(env_id, n, autoreset_mode="SameStep").unwrapped
    env.reset(seed=0)
    actions = np.random.default_rng(0).uniform(-1, 1, (BLOCKS + 1, n, 2)).astype(np.float32)
    for action in actions[:BLOCKS]:
        env.step(action)
    episodes, simulation = env.episodes, env.simulation
    saved = episodes.pick(np.arange(n))

    def restore() -> None:
        for name in ("block", "wheels", "parts", "memory"):
            getattr(episodes, name)[:] = getattr(saved, name)

    choice = env.codec.choose(env.codec.table(actions[-1], n))
    cycles = np.empty((n, step.CYCLE_FIELDS))
    parameters = np.empty((n, simulation.base.shape[1]))
    results = np.zeros((n, len(step.CycleResult._fields)))
    everyone, order = np.arange(n), np.empty(n, np.int64)
    strokes = np.empty((n, 0, step.STROKE_FIELDS))

    def kernel() -> None:
        longest_first(cycles, everyone, order)
        run_blocks(cycles, parameters, episodes.wheels, episodes.parts, results, strokes, order, 0, 1)

    whole, core = np.inf, np.inf
    for _ in range(150):
        restore()
        step.prepare(
            simulation.kinds,
            simulation.base,
            simulation.shop,
            episodes.tape,
            episodes.block,
            episodes.wheels,
            episodes.parts,
            episodes.memory,
            *choice,
            np.zeros(n),
            3,
            everyone,
            cycles,
            parameters,
        )
        core = min(core, fastest(kernel, 1))
        restore()
        whole = min(whole, fastest(lambda: env.step(actions[-1]), 1))
    return float(whole), float(core)


def single_step(env_id: str) -> float:
    """Time of a single step without its strokes, s."""
    env = gym.make(env_id, show_block=False).unwrapped
    action = np.zeros(2, np.float32)

    def episode() -> float:
        env.reset(seed=0)
        return min(fastest(lambda: env.step(action), 1) for _ in range(BLOCKS))

    whole = min(episode() for _ in range(50))
    _, core = vector_step(env_id, 1)
    return whole - core


def steps_per_second(env_id: str, workers: int, steps: int) -> None:
    """Print the steps a second of native (`workers` 0) or asynchronous vector environments."""
    assert grind_env.__version__
    vector = (
        gym.make_vec(env_id, 256, autoreset_mode="NextStep")
        if workers == 0
        else gym.make_vec(env_id, workers, vectorization_mode="async")
    )
    vector.reset(seed=0)
    actions = [vector.action_space.sample() for _ in range(steps)]
    vector.step(actions[0])
    begin = time.perf_counter()
    for action in actions:
        vector.step(action)
    print(vector.num_envs * steps / (time.perf_counter() - begin))
    vector.close()


def table(fresh_process: Callable[..., list[float]]) -> Table:
    """The ratios of the environments."""
    result = Table(title="Environments")
    for name in ("measure", "value", "target"):
        result.add_column(name, justify="left" if name == "measure" else "right")
    for env_id in ("grind/Slot-v0", "grind/PowerLimited-v0"):
        for n in (64, 256, 1024):
            whole, core = vector_step(env_id, n)
            target = "<= 1.2"
            result.add_row(f"{env_id}: vector step over its kernel, N = {n}", f"{whole / core:.2f}", target)
    own = 1e6 * single_step("grind/PowerLimited-v0")
    result.add_row("single step without its strokes", f"{own:.1f} us", f"<= {3 * EMPTY_STEP:.1f} us")
    call = "from tests.speed_envs import steps_per_second; steps_per_second('grind/PowerLimited-v0', {}, {})"
    (native,) = fresh_process(call.format(0, 200))
    (plain,) = fresh_process(call.format(8, 20), NUMBA_DISABLE_JIT="1")
    result.add_row("native N = 256 over AsyncVectorEnv(8) in plain Python", f"{native / plain:.0f}", ">= 100")
    return result

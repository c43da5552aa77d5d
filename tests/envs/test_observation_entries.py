"""Observations have no constant entries; hidden entries come last and change measured entries only."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

import grind_env
from grind_env.envs import task_env_factory
from grind_env.envs.noise_tape import TapeRow
from grind_env.envs.observations import HIDDEN, constant_readings, readings
from grind_env.envs.simulation import Simulation, advance
from grind_env.envs.task_names import shipped_names
from grind_env.envs.tasks import load_task, read_task
from grind_env.process.stroke_types import WheelState
from tests.envs.harness import every_id, start
from tests.examples import few

EXAMPLES = sorted((Path(grind_env.__file__).parent / "examples").glob("*.nc"))
STEPS = 700  #: more steps than any episode has
#: entries read from gauges and power meters
MEASURED = {
    *("mean_power", "first_power", "peak_power", "size_error", "taper", "roughness"),
    *("diameter", "executions_left"),
}
#: hidden fields of a tape, without the true stock
DRAWN = ("kA", "pm", "hf", "fc", "Gref", "ra_scale", "spare_kA", "spare_ra_scale")


def cases() -> Iterator[Any]:
    """Yield ids with arguments for every kind of observation."""
    for env_id in every_id():
        if env_id != "grind/Job-v0":
            yield pytest.param(env_id, {}, id=env_id)
            yield pytest.param(env_id, {"predress": True}, id=f"{env_id} predress", marks=pytest.mark.nightly)
    for program in EXAMPLES:
        # before the only block of a keyway nothing has been measured
        for parts in (3, 12) if "keyway" in program.stem else (1, 3, 12):
            marks = () if parts == 3 else pytest.mark.nightly
            arguments = {"program": str(program), "parts": parts}
            yield pytest.param("grind/Job-v0", arguments, id=f"{program.stem} x{parts}", marks=marks)


def contexts(env_id: str) -> list[Any]:
    """Return None and two contexts with factors at low and high values."""
    ends = [{"kA": 0.5, "fc": 0.8}, {"kA": 2.0, "Gref": 0.7}]
    stocks = [{}, {}] if env_id == "grind/Job-v0" else [{"stock": 0.7}, {"stock": 1.4}]
    return [None, *({**a, **b} for a, b in zip(ends, stocks, strict=True))]


@pytest.mark.parametrize(("env_id", "arguments"), list(cases()))
def test_no_measured_entry_is_constant(env_id: str, arguments: dict[str, Any]) -> None:
    env: Any = gym.make(env_id, observation="measured", show_block=False, **arguments).unwrapped
    env.action_space.seed(0)
    seen = []
    for seed, context in enumerate(contexts(env_id) * 2):
        # readings after the last block do not count
        observation, over = env.reset(seed=seed, options={"context": context})[0], False
        for _ in range(STEPS):
            if over:
                break
            seen.append(observation)
            observation, _, over, _, _ = env.step(env.action_space.sample())
        assert over
    spread = np.ptp(np.array(seen), axis=0)
    names = [entry.name for entry in env.observation_info()]
    assert [name for name, each in zip(names, spread, strict=True) if each == 0.0] == []


@pytest.mark.parametrize(("env_id", "arguments"), list(cases()))
def test_the_full_observation_starts_with_the_measured_one(env_id: str, arguments: dict[str, Any]) -> None:
    measured, full = (gym.make(env_id, observation=each, **arguments).unwrapped for each in ("measured", "full"))
    short, long = measured.observation_info(), full.observation_info()
    assert long[: len(short)] == short
    assert all((entry.noise == "hidden") == (k >= len(short)) for k, entry in enumerate(long))
    for env in (measured, full):
        env.action_space.seed(1)
    a, b = measured.reset(seed=5)[0], full.reset(seed=5)[0]
    for _ in range(8):
        np.testing.assert_array_equal(a, b[: len(short)])
        (a, _, over, *_), (b, *_) = (env.step(env.action_space.sample()) for env in (measured, full))
        if over:
            break


def simulation_of(name: str) -> Simulation:
    """Return the simulation of a task, or of twelve parts of an example program."""
    if name.endswith(".nc"):
        return gym.make("grind/Job-v0", program=str(EXAMPLES[0].with_name(name)), parts=12).unwrapped.simulation
    return task_env_factory.simulation_of(read_task(name), "measured")


@pytest.mark.parametrize("name", shipped_names())
def test_constant_readings_left_out_of_the_observation_can_be_read(name: str) -> None:
    simulation = simulation_of(name)
    seen = simulation.read(simulation.observe(start(simulation, 3)))
    kind = simulation.task.kinds[0]
    for reading in ("width", "length", "tolerance"):
        if len(simulation.task.kinds) == 1:
            assert seen[reading] == pytest.approx(getattr(kind, reading)), reading
    assert set(HIDDEN).isdisjoint(seen)


def test_the_task_decides_which_constant_entries_are_left_out() -> None:
    task = load_task("wide_rails")
    rough, finish = task.kinds
    names = {entry.name for entry in readings(task, full=False)}
    wider = replace(task, kinds=(replace(rough, width=50.0), finish))
    assert {entry.name for entry in readings(wider, full=False)} - names == {"width", "last_width"}
    free = replace(task, kinds=(rough, replace(finish, roughness_limit=0.0)))
    assert names - {entry.name for entry in readings(free, full=False)} == {
        "roughness",
        "parts_since_gauged",
        "roughness_limit",
    }
    lot = replace(task, spread=replace(task.spread, lot_probability=0.0))
    assert names - {entry.name for entry in readings(lot, full=False)} == {"new_lot"}
    undressed = replace(task, action=replace(task.action, executions=0))
    assert names - {entry.name for entry in readings(undressed, full=False)} == {"last_executions", "dresses"}
    with_pre_dress = {entry.name for entry in readings(undressed, full=False, pre_dress=True)}
    assert with_pre_dress - names == {"last_pre_dress"} and names - with_pre_dress == {"last_executions"}
    assert constant_readings(replace(task, blocks=2))["size_error"] == 0.0
    assert "size_error" not in constant_readings(replace(task, blocks=4))
    assert "roughness" in constant_readings(replace(task, blocks=4))


@pytest.mark.parametrize("name", few([*shipped_names(), *(each.name for each in EXAMPLES)], 3))
def test_hidden_quantities_change_measured_entries_only(name: str) -> None:
    simulation = simulation_of(name)
    names = [entry.name for entry in simulation.entries]
    episodes, measured = start(simulation, 4), set[str]()
    for field in (*DRAWN, "A"):
        other = changed(simulation, field)
        first, second = simulation.observe(episodes), simulation.observe(other)
        np.testing.assert_array_equal(first, second, err_msg=field)
        a, b = episodes.pick(np.arange(4)), other
        for k in range(6):
            choice = np.full(4, 12_000.0), np.full(4, float(k == 2))
            advance(simulation, a, *choice)
            advance(simulation, b, *choice)
            differs = (simulation.observe(a) != simulation.observe(b)).any(axis=0)
            measured |= {each for each, is_other in zip(names, differs, strict=True) if is_other}
    # times do not change here, and counters follow the program
    assert measured <= MEASURED
    assert "peak_power" in measured


def changed(simulation: Simulation, field: str) -> Any:
    """Return the episodes of the first four seeds with one hidden field changed."""
    other = start(simulation, 4)
    if field in TapeRow._fields:
        column = TapeRow._fields.index(field)
        other.tape[..., column] *= 1.2
    else:
        other.wheels[:, WheelState._fields.index(field)] *= 1.5
    return other


@pytest.mark.parametrize("name", [name for name in shipped_names() if read_task(name).spread.gauge > 0.0])
def test_the_true_stock_changes_neither_the_first_observation_nor_the_volume(name: str) -> None:
    simulation = simulation_of(name)
    episodes, other = start(simulation, 4), start(simulation, 4)
    column = TapeRow._fields.index("stock")
    # more than a pick, so that one stroke more is needed
    other.tape[:, 0, column] += 0.045
    np.testing.assert_array_equal(simulation.observe(episodes), simulation.observe(other))
    names = [entry.name for entry in simulation.entries]
    for each in (episodes, other):
        simulation.step(each, np.full(4, 12_000.0), np.zeros(4))
    volume = names.index("volume")
    a, b = simulation.observe(episodes), simulation.observe(other)
    # the volume follows the gauged stock, which is the same
    np.testing.assert_array_equal(a[:, volume], b[:, volume])

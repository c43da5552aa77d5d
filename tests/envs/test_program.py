from typing import Any

import gymnasium as gym
import numpy as np
import pytest

from grind_env.control import Rapid, Source, execute, read
from grind_env.envs.blocks.task_job import job
from grind_env.envs.blocks.task_program import number
from tests.envs.harness import every_id


def test_a_wheel_change_stands_in_the_program() -> None:
    env = gym.make("grind/CBN-v0").unwrapped
    env.reset(seed=0)
    changed = [env.step(np.array([0.5, 1.0]))[4]["reward_change"] < 0.0 for _ in range(12)]
    assert sum(changed) == 1
    after = changed.index(True) + 1
    stops = [line for line in env.part_program().splitlines() if line.startswith(("M00", "M01"))]
    assert [("CHANGE THE WHEEL" in stop) for stop in stops] == [k == after for k in range(1, 12)]


@pytest.mark.parametrize(
    "value, text", [(0.3, ".3"), (-30.0, "-30."), (-0.02, "-.02"), (11943.0, "11943."), (0.0, "0.")]
)
def test_numbers_are_written_as_the_control_reads_them(value: float, text: str) -> None:
    assert number(value) == text


def played(env_id: str, steps: int) -> Any:
    env = gym.make(env_id).unwrapped
    env.reset(seed=0)
    for k in range(steps):
        env.step(np.array([0.3, 0.9 if k % 5 == 4 else -0.9], np.float32))
    return env


WRITERS = [env_id for env_id in every_id() if env_id != "grind/Job-v0"]  # the user wrote the program of Job


@pytest.mark.parametrize("env_id", WRITERS)
def test_the_wheel_crosses_above_the_part_and_comes_down_with_a_feed(env_id: str) -> None:
    env = played(env_id, 4)
    programs, control = read(env.part_program()), job(env.task, *env.task.kinds).control
    rapids = 0
    for event in execute(programs, control):
        if isinstance(event, Rapid) and event.source is Source.PROGRAM:
            (x, y, z), (end_x, end_y, end_z) = event.start, event.end
            assert (end_x, end_z) == (x, z) or min(y, end_y) >= 20.0
            assert end_y >= 1.0
            rapids += 1
    assert rapids > 2


@pytest.mark.parametrize("env_id", WRITERS)
def test_the_wheel_lifts_first_after_every_start_and_stop(env_id: str) -> None:
    lines = played(env_id, 4).part_program().splitlines()
    starts = [k for k, line in enumerate(lines) if line.startswith(("M08", "M00", "M01"))]
    assert len(starts) >= 2
    for k in starts:
        assert lines[k + 1].startswith("G00 Y20. ")


@pytest.mark.parametrize("env_id", WRITERS)
def test_wheel_and_coolant_run_from_start_to_end(env_id: str) -> None:
    lines = played(env_id, 2).part_program().splitlines()
    start, end = next(k for k, line in enumerate(lines) if line.startswith("G00")), lines.index("M30")
    assert [line.split()[-1] for line in lines[:start]][-2:] == ["M03", "M08"]
    assert lines[end - 2 : end] == ["M09", "M05"]

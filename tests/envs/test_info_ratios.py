"""How near to its limits a block came, in the info of every form of environment, beside what the machine recorded."""

from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

import grind_env
from grind_env.control import read
from grind_env.envs.infos import RATIOS
from grind_env.envs.names import environment_id
from grind_env.envs.tasks import read_task
from grind_env.machine.grind import grind
from grind_env.machine.record import GrindingRecord
from tests.envs.harness import Array, every_id

PLATE = Path(grind_env.__file__).parent / "examples" / "plate_g82.nc"
CHOSEN = [name for name in every_id() if name != "grind/Wen-v0"]
OF_PARTS = ["power_limited", "wide_plates", "reciprocation"]


def arguments_of(env_id: str) -> dict[str, Any]:
    return {"program": str(PLATE)} if env_id == "grind/Job-v0" else {}


@pytest.mark.parametrize("env_id", CHOSEN)
def test_single_and_vector_infos_have_them(env_id: str) -> None:
    single = gym.make(env_id, **arguments_of(env_id)).unwrapped
    vector = gym.make_vec(env_id, num_envs=3, **arguments_of(env_id))
    single.reset(seed=0)
    vector.reset(seed=0)
    action = single.codec.encode(9000.0, 1.0)
    info, infos = single.step(action[0])[4], vector.step(np.repeat(action, 3, axis=0))[4]
    for name in RATIOS:
        assert type(info[name]) is float and info[name] >= 0.0
        assert infos[name].dtype == np.float64 and infos[name].shape == (3,) and infos[f"_{name}"].all()
        assert infos[name][0] == info[name]


def ratios_of_parts(name: str) -> tuple[Array, GrindingRecord]:
    """The ratios of five steps, shape (5, 3), and the record of the machine."""
    env: Any = gym.make(environment_id(name)).unwrapped
    env.reset(seed=2, options={"context": "nominal"})
    infos = [env.step(env.codec.encode(9000.0 + 1000.0 * k, k % 2)[0])[4] for k in range(5)]
    record = env.record()
    assert not any(record.unjudged)
    return np.array([[info[each] for each in RATIOS] for info in infos]), record


@pytest.mark.parametrize("name", OF_PARTS)
def test_they_are_peaks_over_limits(name: str) -> None:
    task = read_task(name)
    found, record = ratios_of_parts(name)
    limits = task.limits(task.kinds[0])
    strokes = record.strokes
    for part, number in enumerate(np.unique(strokes["part"])[:5]):
        mine = strokes[strokes["part"] == number]
        assert found[part, 1] == pytest.approx(mine["load"].max() / limits.power, rel=1e-9)
        assert found[part, 0] <= mine["Br"].max() * (1.0 + 1e-9)
        assert np.isclose(mine["Br"], found[part, 0], rtol=1e-9).any()
        assert found[part, 2] == pytest.approx(record.parts["Ra"][part] / limits.roughness, rel=1e-9)
    assert limits.power == task.machine.power_limit - task.machine.idle_power


def test_a_block_without_a_roughness_limit_has_a_ratio_of_0() -> None:
    env = gym.make("grind/WideRails-v0").unwrapped
    env.reset(seed=0)
    rough, finish = (env.step(env.codec.encode(9000.0, 0.0)[0])[4] for _ in range(2))
    assert rough["roughness_ratio"] == 0.0 < finish["roughness_ratio"]


def test_a_stroke_and_a_block_of_a_program_have_those_of_their_own() -> None:
    stroke = gym.make("grind/Stroke-v0").unwrapped
    stroke.reset(seed=0, options={"context": "nominal"})
    powers, over = [], False
    while not over:
        _, _, over, _, info = stroke.step(stroke.codec.encode(9000.0, 0.0)[0])
        powers.append(info["power_ratio"])
    limit = stroke.task.limits(stroke.task.kinds[0]).power
    assert powers == pytest.approx((stroke.record().strokes["load"] / limit).tolist(), rel=1e-9)
    mine: Any = gym.make("grind/Job-v0", program=str(PLATE), spread=0.0).unwrapped
    mine.reset(seed=0)
    infos = [mine.step(mine.codec.encode(9000.0, 0.0)[0])[4] for _ in mine.simulation.blocks]
    job = mine.simulation.job
    record, limits = grind(read(mine.part_program()), job), job.limits
    highest = max(info["power_ratio"] for info in infos)
    assert highest == pytest.approx(record.strokes["load"].max() / limits.power, rel=1e-9)
    assert infos[-1]["roughness_ratio"] == pytest.approx(record.parts["Ra"][-1] / limits.roughness, rel=1e-9)

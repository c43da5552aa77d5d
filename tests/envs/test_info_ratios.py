"""Infos: values known to a shop, and ratios of a block to its limits, against the record of the machine."""

from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

import grind_env
from grind_env.control import read
from grind_env.envs.infos import RATIOS, READ, READINGS, found_bad
from grind_env.envs.task_names import environment_id
from grind_env.envs.tasks import read_task
from grind_env.machine.grind import grind
from grind_env.machine.record import GrindingRecord
from tests.envs.harness import Array, every_id

PLATE = Path(grind_env.__file__).parent / "examples" / "plate_g82.nc"
OF_PARTS = ["power_limited", "wide_plates", "reciprocation"]


def arguments_of(env_id: str) -> dict[str, Any]:
    return {"program": str(PLATE)} if env_id == "grind/Job-v0" else {}


@pytest.mark.parametrize("env_id", every_id())
def test_the_default_info_holds_only_values_known_to_a_shop(env_id: str) -> None:
    envs: list[Any] = [gym.make(env_id, info=info, **arguments_of(env_id)).unwrapped for info in ("measured", "full")]
    default: Any = gym.make(env_id, **arguments_of(env_id)).unwrapped
    for env in (*envs, default):
        env.reset(seed=3)
    rng, over = np.random.default_rng(1), False
    while not over and len(default.blocks) < 25:
        action = rng.uniform(-1.0, 1.0, 2).astype(np.float32)
        (observation, reward, over, _, told), (_, paid, _, _, true) = (env.step(action) for env in envs)
        assert default.step(action)[4] == told and reward == paid
        seen = {name: values.item() for name, values in default.simulation.read(observation[None]).items()}
        shown = {entry.name for entry in default.simulation.entries}
        readings = {name: seen[name] for name in READINGS if name in shown}
        assert {name: told[name] for name in told if name in READINGS} == readings and readings.items() <= true.items()
        limits = {"power_ratio": default.task.machine.power_limit, "roughness_ratio": 1.0}
        ratios = {name: seen[read] / limits[name] for name, read in READ.items() if read in shown}
        assert {name: told[name] for name in READ if name in told} == pytest.approx(ratios)
        assert told.keys() | READ.keys() | {"burn_ratio"} == true.keys() | READ.keys() and "burn_ratio" not in told
        same = told.keys() - {"cost", "good_parts", *READ}
        assert {name: told[name] for name in same} == {name: true[name] for name in same}
        assert told["cost"] == float(true["cost"] > 0.5)
        assert told["cost"] + told["good_parts"] == pytest.approx(true["cost"] + true["good_parts"])


def test_a_part_counts_as_bad_if_scrap_is_more_likely_than_not() -> None:
    assert [found_bad(1.0, good) for good in (0.0, 0.49, 0.5, 0.51, 1.0)] == [1.0, 1.0, 0.0, 0.0, 0.0]
    assert (found_bad(0.0, 0.0), found_bad(3.0, 1.2), found_bad(3.0, 2.9)) == (0.0, 2.0, 0.0)


def ratios_of_parts(name: str) -> tuple[Array, GrindingRecord]:
    """Return the ratios of five steps, shape (5, 3), and the record of the machine."""
    env: Any = gym.make(environment_id(name), info="full").unwrapped
    env.reset(seed=2, options={"context": "nominal"})
    infos = [env.step(env.codec.encode(9000.0 + 1000.0 * k, k % 2)[0])[4] for k in range(5)]
    record = env.record()
    assert not any(record.unjudged)
    return np.array([[info[each] for each in RATIOS] for info in infos]), record


@pytest.mark.parametrize("name", OF_PARTS)
def test_info_ratios_are_peaks_over_limits(name: str) -> None:
    task = read_task(name)
    found, record = ratios_of_parts(name)
    limits = task.limits(task.kinds[0])
    strokes = record.strokes
    for part, number in enumerate(np.unique(strokes["part"])[:5]):
        mine = strokes[strokes["part"] == number]
        assert found[part, 1] == pytest.approx(mine["load"].max() / limits.power, rel=1e-9)
        assert found[part, 0] <= mine["burn_ratio"].max() * (1.0 + 1e-9)
        assert np.isclose(mine["burn_ratio"], found[part, 0], rtol=1e-9).any()
        assert found[part, 2] == pytest.approx(record.parts["Ra"][part] / limits.roughness, rel=1e-9)
    assert limits.power == task.machine.power_limit - task.machine.idle_power


def test_a_block_without_a_roughness_limit_has_a_ratio_of_0() -> None:
    env = gym.make("grind/WideRails-v0", info="full").unwrapped
    env.reset(seed=0)
    rough, finish = (env.step(env.codec.encode(9000.0, 0.0)[0])[4] for _ in range(2))
    assert rough["roughness_ratio"] == 0.0 < finish["roughness_ratio"]


def test_the_blocks_of_a_user_program_have_the_ratios_of_its_record() -> None:
    mine: Any = gym.make("grind/Job-v0", program=str(PLATE), spread=0.0, info="full").unwrapped
    mine.reset(seed=0)
    infos = [mine.step(mine.codec.encode(9000.0, 0.0)[0])[4] for _ in mine.simulation.blocks]
    job = mine.simulation.job
    record, limits = grind(read(mine.part_program()), job), job.limits
    highest = max(info["power_ratio"] for info in infos)
    assert highest == pytest.approx(record.strokes["load"].max() / limits.power, rel=1e-9)
    assert infos[-1]["roughness_ratio"] == pytest.approx(record.parts["Ra"][-1] / limits.roughness, rel=1e-9)

"""Environments on out-of-model machines. All held-out machines share one process."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

from grind_env.control import read
from grind_env.envs.plant_options import OtherMachine
from grind_env.envs.reset_options import ContextError
from grind_env.envs.simulation import with_start_of
from grind_env.envs.tasks import TaskError, read_task
from grind_env.envs.tasks.schema import document, toml_text
from grind_env.errors import GrindError
from grind_env.machine.grind import grind, grind_file
from grind_env.machine.job import JobError
from grind_env.machine.job.job_file import load_job
from grind_env.machine.job.job_writer import job_text
from grind_env.machine.loops.row_io import OWN_FROM
from grind_env.plants import PlantError, find_plant
from tests.envs.test_job_env import GROOVED, written

ID = "grind/PowerLimited-v0"
BLOCKS = 5


@pytest.fixture(scope="module")
def env() -> Iterator[Any]:
    made = gym.make(ID, plant="held-out", show_block=False).unwrapped
    yield made
    made.close()


def played(env: Any, **reset: Any) -> tuple[list[np.ndarray], list[float], str]:
    """Return observations and rewards of some blocks, and the name of the machine."""
    observation, info = env.reset(**reset)
    seen, rewards, actions = [observation], [], np.random.default_rng(1)
    for _ in range(BLOCKS):
        observation, reward, _, _, _ = env.step(actions.uniform(-1, 1, 2).astype(np.float32))
        seen.append(observation)
        rewards.append(float(reward))
    return seen, rewards, info.get("plant", "")


def test_reset_draws_a_machine_and_a_seed_repeats_it(env: Any) -> None:
    first, again = played(env, seed=3), played(env, seed=3)
    later = [env.reset()[1]["plant"] for _ in range(4)]
    assert first[1] == again[1] and first[2] == again[2] == env.reset(seed=3)[1]["plant"]
    assert len({first[2], *later}) == 5 and all(name.startswith("held-out:") for name in later)
    one = played(env, seed=3, options={"plant": first[2]})
    assert one[1] == first[1] and one[2] == first[2]
    assert env.reset()[1]["plant"] == first[2]  # until reset names another machine
    assert env.reset(options={"plant": None})[1]["plant"] != first[2]


def test_a_seed_draws_equal_lots_and_noise_with_and_without_a_plant(env: Any) -> None:
    with_one, without = env, gym.make(ID, show_block=False).unwrapped
    rewards = played(with_one, seed=7)[1], played(without, seed=7)[1]
    assert rewards[0] != rewards[1]
    for one in (with_one, without):
        one.reset(seed=7)
    for _ in range(2):  # this episode and the next one
        assert with_one.episodes.source.tobytes() == without.episodes.source.tobytes()
        assert with_one.episodes.tape.tobytes() == without.episodes.tape.tobytes()
        own = with_one.episodes.extra_state(0)
        assert own == find_plant(with_one.plant).own
        assert without.reset()[1] == {} and with_one.reset()[1] != {}
    assert without.plant == "" and without.part_program


@pytest.mark.nightly
@pytest.mark.parametrize("mode", ["NextStep", "SameStep"])
def test_native_vector_environments_equal_synchronous_ones_bit_for_bit(mode: str, tmp_path: Path) -> None:
    task = tmp_path / "short.toml"
    task.write_text('base = "power_limited"\nblocks = 3\nplant = "held-out"\n')
    arguments: dict[str, Any] = {"task": str(task), "show_block": False}
    single = gym.make_vec(
        "grind/Task-v0", 3, vectorization_mode="sync", vector_kwargs={"autoreset_mode": mode}, **arguments
    )
    native = gym.make_vec("grind/Task-v0", 3, vectorization_mode="vector_entry_point", autoreset_mode=mode, **arguments)
    names = []
    for at, envs in enumerate((single, native)):
        observation, info = envs.reset(seed=5, options={"plant": None} if at else None)
        results, actions = [observation], np.random.default_rng(0)
        machines = [info["plant"].tolist(), info["_plant"].tolist()]
        for _ in range(8):
            observation, reward, *_, info = envs.step(actions.uniform(-1, 1, (3, 2)).astype(np.float32))
            results += [observation, reward]
            if "plant" in info:
                machines += [info["plant"].tolist(), info["_plant"].tolist()]
        names.append((machines, [each.tobytes() for each in results]))
        envs.close()
    assert names[0] == names[1]
    assert len(names[0][0]) > 2 and len({*names[0][0][0], *names[0][0][2]}) == 6


def test_reset_can_name_a_machine_for_each_environment_of_a_batch() -> None:
    envs = gym.make_vec(ID, 2, vectorization_mode="vector_entry_point", plant="held-out:1")
    plants = ["held-out:4", "held-out"]
    names = envs.reset(seed=0, options={"plant": plants})[1]["plant"].tolist()
    assert names[0] == "held-out:4" and names[1] not in (None, "held-out", "held-out:1")
    envs.close()


@pytest.mark.bits
def test_program_and_job_of_an_episode_reproduce_its_record(env: Any, tmp_path: Path) -> None:
    played(env, seed=11)
    job, program = env.written().job, tmp_path / "part.nc"
    assert job.plant == env.plant and job.own == find_plant(env.plant).of_process
    (tmp_path / "part.toml").write_text(job_text(job))
    program.write_text(env.part_program(), newline="")
    read_again = load_job(tmp_path / "part.toml")
    assert read_again == replace(job, variables=read_again.variables)
    record, again = env.record(), grind_file(program)
    assert record.job.plant == again.job.plant == env.plant
    for table in ("strokes", "dresses", "parts"):
        assert getattr(record, table).tobytes() == getattr(again, table).tobytes()
    model = grind(read(env.part_program()), load_job(tmp_path / "part.toml", plant=find_plant("model")))
    assert model.strokes.tobytes() != record.strokes.tobytes()
    own = env.episodes.extra_state(0)[: len(job.process.own._fields)]
    assert own != find_plant(env.plant).of_process  # the episode has changed these numbers


def test_a_user_program_is_ground_on_the_plant_of_its_job(tmp_path: Path) -> None:
    from grind_env.envs.job.loading import EXAMPLE

    job = tmp_path / "job.toml"
    job.write_text(f'plant = "held-out:3"\n{EXAMPLE.with_suffix(".toml").read_text()}')
    by_file = gym.make("grind/Job-v0", job=str(job)).unwrapped
    by_name = gym.make("grind/Job-v0", plant="held-out:3").unwrapped
    plain = gym.make("grind/Job-v0").unwrapped
    costs = []
    for each in (by_file, by_name, plain):
        _, info = each.reset(seed=2)
        assert info == ({} if each is plain else {"plant": "held-out:3"})
        costs.append([each.step(each.action_space.high * 0.1)[1] for _ in range(2)])
        assert each.written().job.plant == each.plant
    assert costs[0] == costs[1] != costs[2]
    assert by_file.task.reference_cost == plain.task.reference_cost  # computed on the model
    written, ground = by_name.written(), by_name.record()
    again = grind(read(written.program), written.job)
    # the program goes on after the blocks that were run
    assert again.strokes[: len(ground.strokes)].tobytes() == ground.strokes.tobytes()


def test_a_program_without_a_script_is_ground_on_the_plant_too(tmp_path: Path) -> None:
    path = written(tmp_path, GROOVED)
    env, plain = (gym.make("grind/Job-v0", program=path, **given).unwrapped for given in ({"plant": "soft"}, {}))
    assert not env.simulation.compiled
    costs = []
    for each in (env, plain):
        each.reset(seed=4)
        costs.append([each.step(np.zeros(2, np.float32))[1] for _ in range(4)])
    assert costs[0] != costs[1]
    record, again = env.record(), grind(read(env.part_program()), env.written().job)
    assert env.written().job.own == find_plant(env.plant).of_process
    assert record.strokes.tobytes() == again.strokes.tobytes() and again.job.plant == env.plant


def test_cleared_episodes_begin_neutral_or_with_the_numbers_of_a_plant(env: Any) -> None:
    simulation, plant = env.simulation, find_plant("held-out:2")
    episodes = simulation.empty_episodes(1)
    for machine, own in ((simulation, tuple(plant.remembers())), (with_start_of(simulation, plant), plant.own)):
        machine.clear(episodes, np.array([0]))
        assert tuple(episodes.wheels[0, OWN_FROM:].tolist()) == own


@pytest.mark.parametrize(
    ("plant", "error", "said"),
    [
        ("meter:7", OtherMachine, "plant is 'meter:7', which grinds or shows otherwise than 'held-out'"),
        ("metre:7", PlantError, "there is no machine 'metre:7'"),
        (7, PlantError, "a machine is named by a text, but not by 7"),
    ],
)
def test_reset_rejects_machines_of_other_families(env: Any, plant: object, error: type[GrindError], said: str) -> None:
    with pytest.raises(error, match=said):
        env.reset(options={"plant": plant})


def test_an_environment_made_without_a_plant_rejects_the_plant_option() -> None:
    made = gym.make(ID).unwrapped
    with pytest.raises(OtherMachine, match="was made without one: make it with plant='meter:7'"):
        made.reset(options={"plant": "meter:7"})
    with pytest.raises(ContextError, match="legal are context, split, plant"):
        made.reset(options={"machine": "meter:7"})


@pytest.mark.parametrize("env_id", ["grind/Reciprocation-v0", "grind/WidePlates-v0", ID])
def test_task_environments_take_a_plant_and_reject_unknown_names(env_id: str) -> None:
    made = gym.make(env_id, plant="soft:3").unwrapped
    assert made.simulation.process == find_plant("soft:3").process
    with pytest.raises(PlantError, match="there is no machine 'sofa:3'"):
        gym.make(env_id, plant="sofa:3")


def test_a_user_defined_plant_is_an_argument_and_no_file_may_name_it(module: str, tmp_path: Path) -> None:
    name = f"{module}:MINE"
    made = gym.make(ID, plant=name).unwrapped
    assert made.reset(seed=0)[1] == {"plant": name}
    assert made.episodes.extra_state(0) == (0.0, 0.0, 0.0, 0.0, 0.25)
    made.reset(options={"plant": f"{module}:MINE"})
    task, job = tmp_path / "task.toml", tmp_path / "job.toml"
    task.write_text(f'base = "power_limited"\nplant = "{name}"\n')
    job.write_text(f'plant = "{name}"\n[part]\nmaterial = "aisi_52100"\n')
    with pytest.raises(TaskError, match="plant: 'my_machines:MINE' would run the code of a module"):
        gym.make("grind/Task-v0", task=str(task))
    with pytest.raises(JobError, match=r"part\.|plant: 'my_machines:MINE' would run the code of a module"):
        load_job(job)


def test_a_task_file_names_its_plant(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text('base = "power_limited"\nplant = "meter"\n')
    assert read_task(str(path)).plant == "meter"
    again = tmp_path / "again.toml"
    again.write_text(toml_text(document(read_task(str(path)))))
    assert read_task(str(again)).plant == "meter"
    made = gym.make("grind/Task-v0", task=str(path), plant="model").unwrapped
    assert made.simulation.plants.text == "model"
    path.write_text('base = "power_limited"\nplant = "metre"\n')
    with pytest.raises(TaskError, match=r"mine.toml: plant: there is no machine 'metre'"):
        read_task(str(path))

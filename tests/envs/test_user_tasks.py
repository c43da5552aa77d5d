"""Task files of users: `grind/Task-v0`, single and vector."""

import json
import math
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from grind_env.control import read
from grind_env.envs.blocks.task_job import conditions, job, job_of
from grind_env.envs.blocks.task_program_writer import request_times
from grind_env.envs.task_names import FOLDER, environment_id, shipped_names
from grind_env.envs.tasks import Kind, Task, TaskError, load_task, read_task
from grind_env.envs.tasks.reading import TABLES
from grind_env.envs.tasks.schema import document, json_schema, rows, toml_text
from grind_env.machine.grind import grind
from grind_env.machine.job import WheelStart
from grind_env.toml import tomllib
from tests.command import Grind
from tests.envs.contract import check_vector_env
from tests.envs.harness import assert_same, native, refusal, row_of, whole_tape
from tests.examples import examples, few

ID = "grind/Task-v0"

MINIMAL = """
[setup]
wheel = "a60j"

[[kind]]
material = "aisi_52100"
stock = 0.04
pick = 0.01
width = 20
length = 200
height = 20
"""
LOT = """
[material.hard_lot]
base = "aisi_52100"
wear_flat_growth = 5e-6

[wheel.a60j]
base = "a60j"
width = 30
"""
SPREAD = "\n[spread]\nstock = 0.2\nmeasurement = 1\nlot_probability = 0.3\nlot_growth = 0.5\ndiamond_flat = 0.1\n"
OWN = MINIMAL.replace("aisi_52100", "hard_lot") + LOT + SPREAD
CYCLES = {
    "G81": "reference_cost = 1.0\nblocks = 4\ninfeed = 0.5\n" + OWN,
    "G82": "reference_cost = 1.0\nblocks = 4\n" + OWN,
    "G83": "reference_cost = 1.0\nblocks = 4\ncross_pick = 12\n" + OWN.replace("width = 20", "width = 60"),
}
every_cycle = pytest.mark.parametrize("cycle", few(CYCLES))


def written(folder: Path, text: str, name: str = "shop") -> str:
    path = folder / f"{name}.toml"
    path.write_text(text, encoding="utf-8")
    return str(path)


@every_cycle
def test_the_cycle_follows_from_the_file(cycle: str, tmp_path: Path) -> None:
    env = gym.make(ID, task=written(tmp_path, CYCLES[cycle]), show_block=True).unwrapped
    env.reset(seed=0)
    assert env.step(np.zeros(2, np.float32))[4]["block"].startswith(cycle)
    assert env.task.parameters(env.task.kinds[0]).kA == 5e-6 and env.task.wheel.width == 30.0
    assert env.task.environment_id == ID


@every_cycle
def test_a_user_task_keeps_the_vector_environment_contract(cycle: str, tmp_path: Path) -> None:
    path = written(tmp_path, CYCLES[cycle])
    check_vector_env(
        lambda mode: native(ID, 2, mode, task=path),
        single=lambda: gym.make(ID, task=path, show_block=False),
        steps=12,
    )


@pytest.mark.parametrize("name", shipped_names())
def test_a_copy_of_a_bundled_file_gives_the_episodes_of_its_id(name: str, tmp_path: Path) -> None:
    path = written(tmp_path, (FOLDER / f"{name}.toml").read_text(encoding="utf-8"), name)
    mine, theirs = gym.make(ID, task=path), gym.make(environment_id(name))
    assert replace(mine.unwrapped.task, file="") == theirs.unwrapped.task
    assert_same(mine.reset(seed=7), theirs.reset(seed=7))
    theirs.action_space.seed(2)
    for _ in range(6):
        action = theirs.action_space.sample()
        assert_same(mine.step(action), theirs.step(action))
    assert mine.unwrapped.part_program() == theirs.unwrapped.part_program()


def test_a_task_refuses_a_material_with_a_free_exponent(tmp_path: Path) -> None:
    own = '\n[material.aisi_52100]\nbase = "aisi_52100"\npower_speed_exponent = 0.1\n'
    path = written(tmp_path, MINIMAL + own)
    with pytest.raises(TaskError, match="use it in a job"):
        load_task(path)


def test_a_material_may_be_given_by_its_standard_name(tmp_path: Path) -> None:
    assert 'material = "aisi_52100"' in MINIMAL
    named = written(tmp_path, MINIMAL.replace("aisi_52100", "100Cr6"))
    assert load_task(named).kinds == load_task(written(tmp_path, MINIMAL, "own")).kinds


@pytest.mark.parametrize("task", [None, 3, "", ".toml", "no/such.toml", "a\0.toml", ["slot"]])
def test_a_bad_task_argument_is_refused_in_one_line(task: Any) -> None:
    for make in (gym.make, gym.make_vec):
        message = refusal(TaskError, make, ID, task=task)
        assert message.isprintable() and ".toml" in message


# --- random files ------------------------------------------------------------------------------------------------

ROWS = [row for row in rows() if row.key != "base" and row.table not in ("catalogue", "orders", "due", "wheel_change")]
SLIPS = [None, True, "thin", -1, float("nan"), 1e300, [], {}, [1, "x"], {"a": 1}]


def numbers(row: Any) -> st.SearchStrategy[float]:
    """Return legal numbers of a key, in whole thousandths as required for lengths."""
    low, high = row.content.quantity.low, min(row.content.quantity.high, 1e4)
    if row.content.item is int:
        return st.integers(int(low), int(min(high, 60)))
    return st.floats(low, high).map(lambda value: min(max(round(value, 3), low), high))


def legal(row: Any) -> st.SearchStrategy[Any]:
    content = row.content
    if content.choices:
        return st.sampled_from(content.choices)
    if content.type is tuple and content.item is float:
        size = content.count or 3
        return st.lists(numbers(row), min_size=size, max_size=size, unique=True).map(sorted)
    if content.quantity and content.type in (int, float):
        return numbers(row)
    return st.booleans() if content.type is bool else st.just(SUITABLE.get(row.key, {}))


SUITABLE = {"material": "inconel_718", "wheel": "b126", "dresser": "single_point", "fluid": "emulsion"} | {
    "machine": "default", "sequence": ["part"], "title": "Flügel (2)\nO9 %", "name": "part"
}  # fmt: skip


@st.composite
def documents(draw: st.DrawFn) -> dict[str, Any]:
    """Draw the smallest file with a few more legal values, or with one key misspelt, missing or illegal."""
    content = tomllib.loads("blocks = 4\n" + MINIMAL)
    for row in draw(st.lists(st.sampled_from(ROWS), max_size=5, unique=True)):
        value = draw(legal(row))
        place = (
            content
            if not row.table
            else content["kind"][0]
            if row.table == "kind"
            else content.setdefault(row.table, {})
        )
        place[row.key] = value
    slip = draw(st.sampled_from(["none", "none", "value", "key", "missing"]))
    if slip != "none":
        place = draw(st.sampled_from([content, content["setup"], content["kind"][0]]))
        key = draw(st.sampled_from(sorted(place)))
        value = place.pop(key)
        if slip == "value":
            place[key] = draw(st.sampled_from(SLIPS[1:]))
        if slip == "key":
            place[f"{key}_"] = value
    return content


@examples(150)
@given(content=documents())
def test_a_file_makes_an_environment_or_an_error_of_one_line(content: dict[str, Any], tmp_path: Path) -> None:
    path = written(tmp_path, toml_text(content))
    try:
        env = gym.make(ID, task=path).unwrapped
    except TaskError as error:
        assert str(error).startswith(path) and str(error).isprintable()
        return
    observation, _ = env.reset(seed=0)
    vector = native(ID, 2, task=path)
    assert_same(vector.reset(seed=0)[0][0], observation)
    for action in (np.array([1.0, 1.0], np.float32), np.array([-1.0, -1.0], np.float32), np.zeros(2, np.float32)):
        if env.episodes.block[0] >= env.task.blocks:
            break
        stepped = env.step(action)
        assert env.observation_space.contains(stepped[0]) and np.isfinite(stepped[1])
        assert_same(row_of(vector.step(np.tile(action, (2, 1))), 0)[:3], stepped[:3])


LESS_THAN_A_PICK = {
    "title": "less than a pick",
    "reference_cost": 1.0,
    "blocks": 4,
    "setup": {"wheel": "a60j"},
    "kind": [{"material": "aisi_52100", "stock": 0.008, "pick": 0.01, "width": 20, "length": 200}],
}


def with_overrun(overrun: float) -> dict[str, Any]:
    """Return the smallest task with the given overrun, mm."""
    content = tomllib.loads("reference_cost = 1.0\nblocks = 4\n" + MINIMAL)
    content["setup"]["overrun"] = overrun
    return content


def test_an_overrun_is_refused_if_the_wheel_would_cut_the_part_coming_down(tmp_path: Path) -> None:
    # 0.01 mm above its lowest point the 300 mm wheel reaches sqrt(0.01 (300 - 0.01)) = 1.73202 mm to each side
    assert refusal(TaskError, load_task, written(tmp_path, toml_text(with_overrun(1.732)))).endswith(
        "setup.overrun is 1.732, but must be at least 1.733 mm, or the 300 mm wheel grinds the part as it comes down "
        "beside it, 0.01 mm deep in its first pick"
    )
    # no pick is deeper than the stock: sqrt(0.004 (300 - 0.004)) = 1.09544 mm
    thin = with_overrun(1.096)
    thin["kind"][0]["stock"] = 0.004
    assert load_task(written(tmp_path, toml_text(thin))).setup.overrun == 1.096
    with pytest.raises(TaskError, match=r"at least 1\.096 mm"):
        load_task(written(tmp_path, toml_text(thin | {"setup": thin["setup"] | {"overrun": 1.095}})))
    for own in ({"infeed": 0.5}, {"cross_pick": 12.0}):  # these cycles start from the surface
        content = with_overrun(1.0) | own
        content["kind"][0]["width"] = 60.0 if "cross_pick" in own else 20.0
        assert load_task(written(tmp_path, toml_text(content))).setup.overrun == 1.0


@examples(60)
@given(content=documents(), cycle=st.sampled_from(["G81", "G82", "G83"]), seed=st.integers(0, 10_000))
@example(content=LESS_THAN_A_PICK, cycle="G82", seed=0)
@example(content=with_overrun(1.0), cycle="G81", seed=0)
@example(content=with_overrun(1.0), cycle="G82", seed=0)
@example(content=with_overrun(1.0), cycle="G83", seed=0)
@example(content=with_overrun(1.733), cycle="G82", seed=0)
def test_the_machine_grinds_the_same_parts_from_the_program_of_a_file(
    content: dict[str, Any], cycle: str, seed: int, tmp_path: Path
) -> None:
    content = {key: value for key, value in content.items() if key not in ("infeed", "cross_pick")}
    own = {"G81": {"infeed": 0.5}, "G82": {}, "G83": {"cross_pick": 12.0}}[cycle]
    setup = content.setdefault("setup", {})
    if isinstance(setup, dict):
        setup["load"] = 600.0  # longer than any travel of the wheel to the part
    kinds = content.get("kind")
    if cycle == "G83" and isinstance(kinds, list) and kinds and isinstance(kinds[0], dict):
        kinds[0]["width"] = 60.0
    try:
        env = gym.make(ID, task=written(tmp_path, toml_text(content | own)), predress=True, info="full").unwrapped
    except TaskError:
        return
    env.reset(seed=seed)
    env.action_space.seed(seed)
    task, wheel = env.task, env.episodes.wheel(0)
    count = min(task.blocks, 3)
    infos = [env.step(env.action_space.sample())[4] for _ in range(count)]
    shop = job(task, *task.kinds[:1]) if cycle == "G82" else job_of(task, [])
    start = WheelStart(
        diameter=wheel.ds,
        diamond_flat=wheel.wd,
        wear_flat_area=task.start.wear_flat_area,
        volume_since_dress=task.start.volume,
    )
    programs = read(env.part_program())
    control = replace(shop.control, operator_dress_at=request_times(programs, shop)) if cycle == "G81" else None
    parts = tuple(conditions(task, whole_tape(env))[:count])
    record = grind(programs, replace(shop, wheel=start, parts=parts), control=control)
    assert record.parts["survival"] == pytest.approx([info["good_parts"] for info in infos], rel=1e-5, abs=1e-9)
    assert record.parts["seconds"] == pytest.approx([info["seconds"] for info in infos], rel=1e-9, abs=2e-6)
    left = env.episodes.wheel(0)
    for name in ("ds", "A", "W"):
        assert record.strokes[name][-1] == pytest.approx(getattr(left, name), rel=1e-9, abs=1e-12), name


# --- schema ------------------------------------------------------------------------------------------------------


def test_the_schema_has_every_key_with_its_meaning() -> None:
    found = {(row.table, row.key) for row in rows()}
    wanted = {(name, item.name) for name, kind in {**TABLES, "kind": Kind}.items() for item in fields(kind)}
    own = {("", item.name) for item in fields(Task)} - {
        ("", name) for name in ("name", "kinds", "catalogue", "file", *TABLES)
    }
    assert found == wanted | own | {("", "base"), ("catalogue", "files")}
    assert all(row.meaning for row in rows())


def test_every_bundled_file_fits_the_json_schema_and_a_mistake_does_not() -> None:
    jsonschema = pytest.importorskip("jsonschema")
    schema = json_schema()
    jsonschema.Draft202012Validator.check_schema(schema)
    validator = jsonschema.Draft202012Validator(schema)
    for text in [(FOLDER / f"{name}.toml").read_text(encoding="utf-8") for name in shipped_names()] + [
        *CYCLES.values()
    ]:
        validator.validate(tomllib.loads(text))
    for old, new in (("stock = 0.04", "stock = -1"), ("stock = 0.04", "stok = 1"), ("stock = 0.04", "")):
        assert not validator.is_valid(tomllib.loads(MINIMAL.replace(old, new)))


@pytest.mark.parametrize("name", [*shipped_names(), *CYCLES])
def test_the_printed_document_of_a_task_reads_back_as_the_task(name: str, tmp_path: Path) -> None:
    task = load_task(written(tmp_path, CYCLES[name])) if name in CYCLES else read_task(name)
    again = read_task(written(tmp_path, toml_text(document(task)), "again"))
    assert replace(again, name=task.name, file=task.file) == task


def test_grind_tasks_checks_a_file(grind: Grind, tmp_path: Path) -> None:
    path = written(tmp_path, CYCLES["G83"])
    status, out, err = grind("tasks", path)
    assert (status, err) == (0, "") and tomllib.loads(out) == document(load_task(path))
    assert json.loads(grind("tasks", path, "--json")[1]) == document(load_task(path))
    status, out, err = grind("tasks", written(tmp_path, MINIMAL.replace("pick", "pik")))
    assert (status, out) == (2, "")
    assert (
        err.startswith(f"grind: {path}: kind 1: there is no key kind.pik (did you mean pick?)") and err.count("\n") == 1
    )


def test_grind_tasks_prints_the_schema(grind: Grind) -> None:
    status, out, err = grind("tasks", "--schema")
    assert (status, err) == (0, "")
    assert "  wheel_speed: number, 5 to 150 m/s; default 30.0\n      surface speed of the new wheel\n" in out
    assert json.loads(grind("tasks", "--schema", "--json")[1]) == json_schema()


def test_a_gauging_time_shorter_than_the_travel_of_the_wheel_is_refused(tmp_path: Path) -> None:
    def made(gauge: float) -> object:
        (tmp_path / "mine.toml").write_text(f'base = "wide_rails"\n[setup]\ngauge = {gauge:.3f}\n', encoding="utf-8")
        return gym.make("grind/Task-v0", task=str(tmp_path / "mine.toml"))

    with pytest.raises(TaskError, match=r"gauge is 0\.0, but must be at least \d\.\d s, which the way takes") as told:
        made(0.0)
    least = float(str(told.value).partition("at least ")[2].partition(" s")[0])
    # 20 mm up, 360 mm to the farther side and 19 mm down at 20 m/min and 1 m/s2, then 1.3 mm at 60 mm/min
    assert 2.0 * math.sqrt(0.020) + 360.0 / (20_000.0 / 60.0) + 2.0 * math.sqrt(0.019) + 1.3 < least < 4.0
    with pytest.raises(TaskError, match="which the way takes"):
        made(least - 0.1)
    made(least + 0.1)

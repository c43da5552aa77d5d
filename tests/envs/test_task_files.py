import copy
import math
import pickle
from dataclasses import fields, replace
from pathlib import Path

import gymnasium as gym
import pytest

from grind_env.envs import names, tasks
from grind_env.envs.env import GrindEnv
from grind_env.envs.episode import EpisodeGenerator
from grind_env.envs.names import environment_id
from grind_env.envs.tasks import Kind, Orders, Task, TaskError, load_task, read_task, task_names

DUE = "[due]\nblocks = 6\nspeed = 12.0\nslack = [0.7, 1.3]\nlate = 1.0\n\n[spread]"
TEXT = {name: (tasks.FOLDER / f"{name}.toml").read_text(encoding="utf-8") for name in task_names()}


@pytest.mark.parametrize("name", task_names())
def test_every_task_loads_and_has_its_id(name: str) -> None:
    task = load_task(name)
    assert task.name == name and task.title and task.blocks > 0 and task.reference_cost > 0.0
    assert gym.spec(environment_id(name)).kwargs == {"task": name}
    assert load_task(name) is task


def test_ids_are_camel_case() -> None:
    assert environment_id("power_limited") == "grind/PowerLimited-v0"
    assert environment_id("oracle6") == "grind/Oracle6-v0"
    assert environment_id("CBN") == "grind/CBN-v0"


def test_an_unknown_task_is_refused() -> None:
    with pytest.raises(TaskError, match=r"'slots'.*oracle6, power_limited, rush, slot"):
        load_task("slots")


@pytest.mark.parametrize("name", ["reciprocation", "stroke"])
def test_the_task_of_an_environment_of_its_own_is_none_of_cycle_blocks(name: str) -> None:
    task = read_task(name)
    assert task.name == name and environment_id(name) in gym.registry
    assert name not in task_names()
    for make in (load_task, GrindEnv):
        with pytest.raises(TaskError, match=f"there is no task '{name}'"):
            make(name)


@pytest.mark.parametrize(
    ("name", "changed"),
    [
        ("reciprocation", {"name", "title", "reference_cost", "infeed"}),
        ("stroke", {"name", "title", "reference_cost", "blocks", "action"}),
    ],
)
def test_a_task_is_its_base_but_for_what_it_says(name: str, changed: set[str]) -> None:
    task, base = read_task(name), load_task("power_limited")
    assert {each.name for each in fields(Task) if getattr(task, each.name) != getattr(base, each.name)} == changed
    # of [action] only one key is said
    assert task.action.speed_range == base.action.speed_range


def put(folder: Path, monkeypatch: pytest.MonkeyPatch, **texts: str) -> None:
    """Let the task files be these."""
    for name, text in texts.items():
        (folder / f"{name}.toml").write_text(text, encoding="utf-8")
    monkeypatch.setattr(tasks, "FOLDER", folder)
    monkeypatch.setattr(names, "FOLDER", folder)


def test_tables_of_a_base_are_merged_and_lists_replaced(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # a slot of 1.6 mm in place of the plate of 0.3 mm
    kind = TEXT["slot"][TEXT["slot"].index("[[kind]]") :].partition("\n\n")[0]
    own = f"""
base = "from_which"
sequence = ["slot"]
[spread]
stock = 0.5
[start]
volume = 7.0
{kind}
"""
    put(tmp_path, monkeypatch, from_which=TEXT["power_limited"], merged=own)
    task, base = load_task("merged"), load_task("from_which")
    assert task.spread == replace(base.spread, stock=0.5) != base.spread
    assert task.start == replace(base.start, volume=7.0) != base.start
    assert (len(task.kinds), task.kinds[0].stock) == (1, 1.6)
    assert (task.blocks, task.setup) == (base.blocks, base.setup)


@pytest.mark.parametrize(
    ("own", "parts"),
    [
        ('base = "nothing"', ["there is no task 'nothing'", "from_which"]),
        ("base = 3", ["there is no task 3"]),
        ('base = "stroke"', ["there is no task 'stroke'"]),
        ('base = "second"', ["there is no base"]),
        ('base = "from_which"\nblock = 3', ["there is no block;"]),
        ('base = "from_which"\n[action]\nexecution = 3', ["[action]", "there is no execution"]),
        ('base = "from_which"\nblocks = "', ["TOML"]),
        ('base = "from_which"\naction = 3', ["[action]"]),
    ],
)
def test_a_slip_beside_a_base_is_named(
    own: str, parts: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    texts = {"from_which": TEXT["power_limited"], "second": 'base = "from_which"', "stroke": TEXT["slot"]}
    put(tmp_path, monkeypatch, slip=own, **texts)
    with pytest.raises(TaskError) as caught:
        load_task("slip")
    message = str(caught.value)
    assert message.startswith("slip.toml: ") and "\n" not in message
    assert all(part in message for part in parts), message


@pytest.mark.parametrize(
    ("old", "new", "parts"),
    [
        ("blocks = 60", "block = 60", ["there is no block;", "blocks"]),
        ("blocks = 60", "", ["blocks is missing"]),
        ('title = "', 'kinds = []\ntitle = "', ["there is no kinds"]),
        ("executions = 3", "execution = 3", ["[action]", "there is no execution"]),
        ("speed_range = [3.0, 30.0]", "", ["[action]", "speed_range", "speed_levels"]),
        ("overrun = 30.0", "over_run = 30.0", ["[setup]", "there is no over_run"]),
        ("[setup]", "[set_up]", ["set_up"]),
        ("load = 20.0", "", ["[setup]", "load is missing"]),
        ("lead = 0.10", "lead_mm = 0.10", ["[dress]", "there is no lead_mm"]),
        ("pick = 0.02", "picks = 0.02", ["[[kind]]", "there is no picks"]),
        ("pick = 0.02", "", ["[[kind]]", "pick is missing"]),
        ("lot_growth = 0.45", "lot_grow = 0.45", ["[spread]", "there is no lot_grow"]),
        ("width = 65.0", "widht = 65.0", ["[setup.wheel_changes]", "there is no widht"]),
        ("stiffness = 50_000.0", "stifness = 50_000.0", ["[setup.machine_changes]", "there is no stifness"]),
        ('wheel = "a60j"', 'wheel = "a60k"', ["a60k", "a60j"]),
        ('material = "aisi_52100"', 'material = "aisi_52101"', ["aisi_52101", "aisi_52100"]),
        ('sequence = ["plate"]', 'sequence = ["plates"]', ["sequence", "plates"]),
        ("[spread]", "[factors]\nka_factor = 2.0\n\n[spread]", ["[factors]", "there is no ka_factor"]),
        ("[spread]", "[start]\nwear = 0.1\n\n[spread]", ["[start]", "there is no wear"]),
        ("blocks = 60", "blocks = ", ["TOML"]),
        ('sequence = ["plate"]', "", ["sequence", "[orders]"]),
        ("[spread]", "[orders]\nmost_parts = 2\n\n[spread]", ["sequence", "[orders]"]),
        (
            'sequence = ["plate"]\nreference_cost = 4.20',
            "orders = {most_parts = 0}\nreference_cost = 4.20",
            ["most_parts"],
        ),
        ('name = "plate"', 'name = "plate"\nends_part = false', ["sequence", "whole parts"]),
        ('name = "plate"', 'name = "plate"\nstarts_part = false', ["sequence", "whole parts"]),
        ("[spread]", DUE.replace("blocks = 6", "blocks = 7"), ["[due]", "7", "60"]),
        ("[spread]", DUE.replace("late = 1.0", ""), ["[due]", "late is missing"]),
        ("[spread]", "[wheel_change]\nprice = 1.0\n\n[spread]", ["[wheel_change]", "seconds is missing"]),
    ],
)
def test_a_slip_in_a_task_file_is_named(
    old: str, new: str, parts: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert TEXT["power_limited"].count(old) == 1
    put(tmp_path, monkeypatch, mine=TEXT["power_limited"].replace(old, new))
    with pytest.raises(TaskError) as caught:
        load_task("mine")
    message = str(caught.value)
    assert message.startswith("mine.toml: ") and "\n" not in message
    assert all(part in message for part in parts), message


def test_the_flagship_has_the_published_parameters() -> None:
    task = load_task("power_limited")
    p = task.parameters(task.kinds[0])
    assert (p.ke, p.bs) == (50_000.0, 65.0)
    assert task.machine.power_limit == 7500.0
    assert 60.0 * task.wheel_revolutions == pytest.approx(1910, abs=0.5)
    assert task.dress_feed == pytest.approx(0.10 * 30000.0 / (math.pi * 300.0))
    wheel = EpisodeGenerator(task).wheel(0.0)
    assert (wheel.ds, wheel.lam, wheel.V, wheel.W, wheel.wd) == (300.0, 0.0, 0.0, 0.0, 0.0)


def test_oracle6_has_the_published_start() -> None:
    task = load_task("oracle6")
    wheel = EpisodeGenerator(task).wheel(0.0)
    assert (wheel.ds, wheel.A, wheel.V, wheel.lam, wheel.alw, wheel.wd) == (
        300.0,
        0.022,
        150.0,
        0.0,
        0.03,
        0.0,
    )
    order = [task.kinds[task.kind_of_block(k)].name for k in range(6)]
    assert order == ["plate", "gauge", "plate", "plate", "gauge", "gauge"]
    assert task.parameters(task.kinds[0]).kA == pytest.approx(2.5 * 1.24e-6)
    assert not any(getattr(task.spread, name) for name in task.spread.__slots__)


def test_a_task_of_orders_has_whole_parts_only() -> None:
    task = load_task("wide_rails")
    with pytest.raises(TaskError, match=r"\[orders\]: a rough is no whole part"):
        replace(task, sequence=(), orders=Orders(most_parts=8))


def published(task: Task) -> list[tuple[object, ...]]:
    """The kinds of a task in the order of the table of scenarios, section 4.1."""

    def row(k: Kind) -> tuple[object, ...]:
        return (k.material, k.stock, k.pick, k.sparkout, k.width, k.length, k.roughness_limit, k.tolerance)

    return [(*row(kind), kind.rise_allowance, kind.scrap, kind.least_stock) for kind in task.kinds]


GAUGE = ("aisi_52100", 0.06, 0.006, 4, 20, 200, 0.32, 5, 0, 60, 0.5)
PLATE = ("aisi_52100", 0.20, 0.010, 2, 25, 200, 0.50, 9, 0, 40, 0.5)
WEAR_PLATE = ("aisi_1020", 0.40, 0.020, 1, 20, 200, 1.0, 18, 0, 25, 0.5)
BLADE = ("inconel_718", 0.16, 0.010, 0, 20, 200, 0, 0, 150, 120, 0.4)
CBN_ROUGH = ("inconel_718", 0.20, 0.010, 0, 20, 200, 0, 0, 150, 200, 0.4)


@pytest.mark.parametrize(
    ("name", "kinds"),
    [
        ("slot", [("aisi_52100", 1.6, 0.016, 4, 20, 200, 0.50, 12, 0, 40, 0.4)]),
        ("job_shop", [GAUGE, PLATE, WEAR_PLATE]),
        ("rush", [GAUGE, PLATE, WEAR_PLATE]),
        ("power_limited", [("aisi_52100", 0.30, 0.020, 1, 50, 300, 1.0, 20, 150, 60, 0.4)]),
        (
            "wide_rails",
            [
                ("aisi_52100", 0.30, 0.015, 0, 60, 300, 0, 0, 150, 80, 0.4),
                ("aisi_52100", 0.03, 0.005, 2, 60, 300, 0.45, 7, 0, 80, 0.4),
            ],
        ),
        ("blades", [BLADE, ("inconel_718", 0.03, 0.005, 3, 20, 200, 0.50, 9, 0, 120, 0.4)]),
        ("CBN", [CBN_ROUGH, ("inconel_718", 0.03, 0.005, 3, 20, 200, 0.36, 8, 0, 200, 0.4)]),
    ],
)
def test_the_blocks_are_those_published(name: str, kinds: list[tuple[object, ...]]) -> None:
    assert published(load_task(name)) == kinds


@pytest.mark.parametrize(
    ("name", "speeds", "executions", "rpm", "stiffness", "width"),
    [
        ("slot", (6.0, 30.0), 4, 1909.86, 20_000, 25),
        ("job_shop", (3.0, 30.0), 3, 1909.86, 20_000, 25),
        ("rush", (3.0, 30.0), 3, 1909.86, 20_000, 25),
        ("power_limited", (3.0, 30.0), 3, 1909.86, 50_000, 65),
        ("wide_rails", (3.0, 30.0), 3, 1909.86, 50_000, 65),
        ("blades", (3.0, 30.0), 3, 1591.55, 20_000, 25),
        ("CBN", (3.0, 30.0), 3, 2228.17, 20_000, 25),
    ],
)
def test_the_set_ups_are_those_published(
    name: str, speeds: tuple[float, float], executions: int, rpm: float, stiffness: float, width: float
) -> None:
    task = load_task(name)
    p = task.parameters(task.kinds[0])
    assert (task.action.speed_range, task.action.executions) == (speeds, executions)
    assert 60.0 * task.wheel_revolutions == pytest.approx(rpm, rel=1e-5)
    assert (p.ke, p.bs, task.machine.power_limit) == (stiffness, width, 7500.0)
    assert p.dd == (0.005 if name == "CBN" else 0.010)


@pytest.mark.parametrize("name", [*task_names(), "reciprocation", "stroke", "wide_plates"])
def test_a_task_that_all_environments_share_cannot_be_changed(name: str) -> None:
    task = read_task(name)
    for table in (task.factors, task.setup.wheel_changes, task.setup.machine_changes):
        with pytest.raises(TypeError):
            table["kA"] = 2.0
        assert not hasattr(table, "update") and dict(table) == table
    for twin in (copy.deepcopy(task), pickle.loads(pickle.dumps(task))):
        assert twin == task and twin.wheel == task.wheel and repr(twin) == repr(task)

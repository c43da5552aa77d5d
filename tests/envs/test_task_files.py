import math
from pathlib import Path

import gymnasium as gym
import pytest

from grind_env.envs import names, tasks
from grind_env.envs.episode import EpisodeGenerator
from grind_env.envs.names import environment_id
from grind_env.envs.tasks import TaskError, load_task, task_names

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


def test_an_unknown_task_is_refused() -> None:
    with pytest.raises(TaskError, match=r"'slot'.*oracle6, power_limited"):
        load_task("slot")


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
    ],
)
def test_a_slip_in_a_task_file_is_named(
    old: str, new: str, parts: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert TEXT["power_limited"].count(old) == 1
    (tmp_path / "mine.toml").write_text(TEXT["power_limited"].replace(old, new), encoding="utf-8")
    monkeypatch.setattr(tasks, "FOLDER", tmp_path)
    monkeypatch.setattr(names, "FOLDER", tmp_path)
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

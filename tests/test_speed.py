"""The measurements of speed run to their end, with next to nothing measured."""

from collections.abc import Callable
from dataclasses import fields
from pathlib import Path
from typing import Any

import pytest

from agents.learning.curve import Point
from tests import speed, speed_base, speed_control, speed_envs, speed_public, speed_training


def ones(code: str, **environment: str) -> list[float]:
    """In place of what a fresh process prints."""
    count = 3 if "measure(" in code else 2 if "loaded" in code else 1
    return [1.0] * count


@pytest.fixture
def brief(monkeypatch: pytest.MonkeyPatch) -> None:
    """As little of everything as there can be."""
    least: dict[Any, dict[str, Any]] = {
        speed: {"SECONDS": 0.0, "MACHINES": 8, "fresh_process": ones},
        speed_envs: {
            "SECONDS": 0.0,
            "TASKS": ("Oracle6",),
            "SIZES": (2,),
            "FEW_AND_MANY": (1, 2),
            "OVER_KERNEL_OF": (2,),
        },
        speed_control: {"PARTS": 4, "seconds_of_run": lambda program: 1.0},
        speed_training: {"native": lambda: Point(**{each.name: 1.0 for each in fields(Point)} | {"aside": 0.0})},
    }
    for module, values in least.items():
        for name, value in values.items():
            monkeypatch.setattr(module, name, value)


def test_make_speed_ends(brief: None, capsys: pytest.CaptureFixture[str]) -> None:
    speed.main()
    printed = capsys.readouterr().out
    assert all(title in printed for title in ("Kernel speed", "Control and programs", "Environments", "Training"))


@pytest.mark.parametrize("measure", [lambda: speed_public.vector("Oracle6", 2, 7), speed_public.control])
def test_what_users_wait_for_is_a_positive_number(
    measure: Callable[[], dict[str, float]], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(speed_public, "BLOCKS", 50)
    assert all(value > 0.0 for value in measure().values())


def test_a_commit_is_measured_beside_this_tree(monkeypatch: pytest.MonkeyPatch) -> None:
    def measured(tree: Path, *arguments: str) -> dict[str, float]:
        return {"cold" if arguments else "warm": 2.0 if tree == speed_base.ROOT else 1.0}

    monkeypatch.setattr(speed_base, "measured", measured)
    shown = speed_base.table("HEAD")
    cells = [list(column.cells) for column in shown.columns]
    assert cells == [["warm", "cold"], ["1", "1"], ["2", "2"], ["0.50", "0.50"]]

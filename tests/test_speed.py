"""The speed measurements run to their end; they measure as little as possible here."""

from typing import Any

import numpy as np
import pytest

from tests import speed_envs
from tests.speed import __main__ as speed
from tests.speed import kernel, others, ratios, starts
from tests.speed.c_reference import compiler


@pytest.fixture
def brief(monkeypatch: pytest.MonkeyPatch) -> None:
    """Measure as little as possible."""
    least: dict[Any, dict[str, Any]] = {
        kernel: {"SECONDS": 0.0, "TURN": 1},
        others: {"SECONDS": 0.0, "N": 2, "STEPS": 1, "TIMES": 1},
        starts: {"cold": lambda: {"grind run, cold: s": 1.0}},
        speed_envs: {"SECONDS": 0.0, "TASKS": ("Oracle6",), "SIZES": (2,)},
    }
    for module, values in least.items():
        for name, value in values.items():
            monkeypatch.setattr(module, name, value)


@pytest.mark.nightly
def test_make_speed_prints_every_table(brief: None, capsys: pytest.CaptureFixture[str]) -> None:
    assert speed.main() == 0
    printed = capsys.readouterr().out
    titles = "ns per stroke", "Ratios", "First results", "Environments"
    assert all(title in printed for title in titles)
    assert ("No gcc here" in printed) == (compiler() is None)


def test_a_ratio_beyond_its_tolerance_fails_the_check(
    brief: None, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    measured = {name: np.array([0.5, about.last, 1e9]) for name, about in ratios.known().items()}
    first = next(iter(measured))
    monkeypatch.setattr(kernel, "strokes", dict)
    monkeypatch.setattr(ratios, "measured", lambda ns: measured)
    assert speed.main("--check") == 0
    measured[first] = np.array([3.0])
    assert speed.main("--check") == 1
    assert f"{first}: 3 is more than 1.25" in capsys.readouterr().out
    del measured[first]  # as without gcc
    assert speed.main("--check") == 0


@pytest.mark.nightly
def test_the_file_of_ratios_lists_every_measured_ratio(brief: None) -> None:
    of_c = {name for name in ratios.known() if "in C" in name}
    measured = ratios.measured(kernel.strokes())
    assert {*ratios.known()} - {*measured} == (set() if compiler() else of_c)
    assert {*measured} <= {*ratios.known()}

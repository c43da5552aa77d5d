"""Learning curves as a figure: each curve as it was written, and errors in one sentence."""

from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from agents.application import app
from agents.learning.curve import Point, write_curve
from agents.learning.figure import curves_figure, read_curves
from grind_env.errors import GrindError

TIMES = dict.fromkeys(("environment", "features", "policy", "optimisation", "aside"), 0.1)


def curve(path: Path, scores: list[float]) -> Path:
    points = [
        Point(steps=10_000 * (k + 1), seconds=k + 1.0, reward=-1.0, cost=2.0, score=score, **TIMES)
        for k, score in enumerate(scores)
    ]
    write_curve(path, points)
    return path


def test_each_training_is_a_line_with_its_scores(tmp_path: Path) -> None:
    files = [curve(tmp_path / f"ppo-{seed}-abcd.csv", [0.0, 40.0 + seed, 70.0]) for seed in (1, 2)]
    figure = curves_figure(read_curves([files[0], files[1].with_suffix(".safetensors")]))
    first, second, *_ = figure.axes[0].lines
    assert [first.get_label(), second.get_label()] == ["ppo-1", "ppo-2"]
    np.testing.assert_allclose(second.get_ydata(), [0.0, 42.0, 70.0])
    np.testing.assert_allclose(second.get_xdata(), [10.0, 20.0, 30.0])
    looks = [(line.get_linestyle(), line.get_marker()) for line in (first, second)]
    assert looks[0] != looks[1]


def test_trainings_of_one_seed_with_other_settings_are_told_apart(tmp_path: Path) -> None:
    files = [curve(tmp_path / f"ppo-1-{settings}.csv", [1.0, 2.0]) for settings in ("aa", "bb")]
    assert list(read_curves(files)) == ["ppo-1", "ppo-1-bb"]
    with pytest.raises(GrindError, match="name each once"):
        read_curves([*files, files[1]])


def test_it_is_one_command(tmp_path: Path) -> None:
    file = curve(tmp_path / "bc-1-abcd.csv", [-300.0, 50.0])
    done = CliRunner().invoke(app, ["figure", "learning-curves", str(file), "-o", str(tmp_path / "curves.pdf")])
    assert done.exit_code == 0 and (tmp_path / "curves.pdf").read_bytes().startswith(b"%PDF")


def test_a_curve_without_points_is_named(tmp_path: Path) -> None:
    with pytest.raises(GrindError, match=r"ppo-1-aa\.csv: the learning curve has no point"):
        read_curves([curve(tmp_path / "ppo-1-aa.csv", [])])
    (tmp_path / "ppo-1-bb.csv").write_text("", encoding="utf-8")
    with pytest.raises(GrindError, match=r"ppo-1-bb\.csv: the learning curve has no point"):
        read_curves([tmp_path / "ppo-1-bb.csv"])

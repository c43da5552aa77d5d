"""Figures for papers: sizes, units, formats and the plotted numbers."""

import itertools
import re
from pathlib import Path

import numpy as np
import pytest

import grind_env
from grind_env.errors import GrindError
from grind_env.machine.record import GrindingRecord
from grind_env.policies.problem_lookup import find_problem
from tests.command import Grind
from tests.examples import nightly

pytest.importorskip("matplotlib")

from grind_env.figures.dress_effect import around_dress, dress_figure, dressed_run
from grind_env.render.figures import PlotError, write_figure
from grind_env.render.paper_style import COLOURS, COLUMN, DASHES, MARKS, PAGE

PLATE = grind_env.examples.path("plate_g82.nc")
MM = 25.4


@pytest.fixture(scope="module")
def dressed() -> GrindingRecord:
    return dressed_run(find_problem("power_limited"), 6000.0, 3)


def test_figures_have_page_width_text_of_8_or_9_pt_and_units_on_every_axis(
    dressed: GrindingRecord,
) -> None:
    from matplotlib.text import Text

    plain = {"burn ratio", "", "stroke of the part"}
    unit = re.compile(r", (mm|µm|kW|K|%|m/min|mm³/mm)$|, %$")
    assert pytest.approx((85.0, 170.0)) == (COLUMN * MM, PAGE * MM)
    figure = dress_figure(dressed)
    figure.canvas.draw()
    assert figure.get_figwidth() == pytest.approx(PAGE)
    texts = [text for text in figure.findobj(Text) if text.get_text() and text.get_visible()]
    assert {text.get_fontsize() for text in texts} <= {8.0, 9.0}
    for axes in figure.axes:
        for label in (axes.get_xlabel(), axes.get_ylabel()):
            said = label.replace("\n", " ")
            assert said in plain or unit.search(said), said


def test_lines_differ_in_dashes_and_markers() -> None:
    looks = list(itertools.islice(zip(DASHES, MARKS, strict=True), len(COLOURS)))
    assert len(set(looks)) == len(set(MARKS)) == len(COLOURS)


@pytest.mark.parametrize("suffix", [nightly(".pdf"), nightly(".svg"), ".png"])
def test_the_same_figure_has_the_same_bytes(suffix: str, dressed: GrindingRecord, tmp_path: Path) -> None:
    for name in ("a", "b"):
        write_figure(dress_figure(dressed), tmp_path / f"{name}{suffix}")
    assert (tmp_path / f"a{suffix}").read_bytes() == (tmp_path / f"b{suffix}").read_bytes()


def test_a_dress_is_shown_between_whole_parts(dressed: GrindingRecord) -> None:
    record = dressed
    dull, sharp, seconds = around_dress(record)
    # D of the third block dresses within it
    assert (dull, sharp) == (2, 4)
    assert seconds == pytest.approx(record.dresses["seconds"][0])
    figure = dress_figure(record)
    power = figure.axes[1].lines
    for line, number in zip(power, (dull, sharp), strict=False):
        strokes = record.strokes[record.strokes["part"] == number]
        np.testing.assert_allclose(line.get_ydata(), 0.001 * strokes["power"])
    with pytest.raises(GrindError, match="no dress lies between two whole parts"):
        around_dress(dressed_run(find_problem("power_limited"), 6000.0, 99))


@pytest.mark.parametrize(
    "words",
    [
        ("dress", "--E", 4500, "--dress-every", 5),
        nightly(("dress", "--env", "reciprocation", "--dress-every", 6)),
        nightly(("dress", "--env", PLATE, "--parts", 6, "--E", 12_000, "--dress-every", 4)),
    ],
)
def test_one_command_writes_each_figure(words: tuple[object, ...], grind: Grind, tmp_path: Path) -> None:
    status, out, err = grind("figure", *words, "-o", tmp_path / "figure.svg")
    assert (status, out, err) == (0, "", "")
    width = re.search(r'width="([\d.]+)pt"', (tmp_path / "figure.svg").read_text(encoding="utf-8"))
    assert width is not None and float(width[1]) / 72.0 * MM == pytest.approx(170.0, abs=0.1)


def test_an_unknown_format_is_refused_before_any_work(grind: Grind, tmp_path: Path) -> None:
    status, _, err = grind("figure", "dress", "--env", "missing.nc", "-o", tmp_path / "a.jpg")
    assert status == 2 and ".png, .svg, .pdf" in err and "missing.nc" not in err


def test_another_suffix_is_refused(dressed: GrindingRecord, tmp_path: Path) -> None:
    with pytest.raises(PlotError, match="name such a file"):
        write_figure(dress_figure(dressed), tmp_path / "a.txt")

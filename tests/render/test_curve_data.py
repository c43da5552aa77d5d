"""The curves of a record picture against the record itself."""

from pathlib import Path

import numpy as np
import pytest

import grind_env
from grind_env.control import read, read_file
from grind_env.machine.grind import grind
from grind_env.machine.job.job_file import load_job
from grind_env.render.curve_data import MANY_PARTS, MOST_GROUPS, MOST_STROKES, Picture, depth_lag, picture, sparks_out
from grind_env.render.record_plots import plot_record
from tests.examples import nightly
from tests.machine.harness import DRESS

EXAMPLES = Path(grind_env.__file__).parent / "examples"
JOB = load_job(EXAMPLES / "plate_g82.toml")
PART = "G00 Y2.\nG00 X-30.\nG01 Y0 F500.\nG82 X230. I-30. Y-.2 J-.02 L{} F60. E12000. P9100 D{}\nG80\nG00 Y20.\n"


def example(name: str):
    return grind(read_file(EXAMPLES / f"{name}.nc"), load_job(EXAMPLES / f"{name}.toml"))


def parts(count: int, spark_out: int = 1):
    body = "M00\n".join(PART.format(spark_out, int(k % 4 == 0)) for k in range(count))
    return grind(read(f"G71 G94 G90 G19 S1910 M03\nG00 Y2. Z-2.5 M08\n{body}M30\n{DRESS}"), JOB)


def titled(shown: Picture, title: str):
    return next(curve for curve in shown.curves if curve.title == title)


def test_the_strokes_of_the_L_word_are_spark_out() -> None:
    record = example("plate_g82")  # L0, then L4: its last four strokes
    assert np.flatnonzero(sparks_out(record)).tolist() == [25, 26, 27, 28]


def test_the_traverse_of_the_L_word_is_spark_out() -> None:
    record = example("rail_g83")  # L0, then L1: the second of two traverses at depth
    found, strokes = sparks_out(record), record.strokes
    at_depth = np.flatnonzero(strokes["Z"] == strokes["Z"].max())
    assert np.flatnonzero(found).tolist() == at_depth[-(len(at_depth) // 2) :].tolist()


def test_strokes_without_infeed_before_them_are_spark_out() -> None:
    record = example("keyway_g81")
    Z = record.strokes["Z"].tolist()
    assert sparks_out(record).tolist() == [k > 0 and Z[k] == Z[k - 1] for k in range(len(Z))]


@pytest.mark.parametrize("name", ["plate_g82", "rail_g83", "keyway_g81"])
def test_the_final_depth_lag_is_the_size_error(name: str) -> None:
    record = example(name)
    assert depth_lag(record)[-1] == pytest.approx(record.parts["size_error"][-1], abs=1e-6)


def test_the_depth_lag_restarts_with_every_part() -> None:
    record = parts(3)
    lasts = np.searchsorted(record.strokes["part"], [1, 2, 3], side="right") - 1
    np.testing.assert_allclose(depth_lag(record)[lasts], record.parts["size_error"], atol=1e-6)


def test_every_stroke_has_the_same_width_however_long_a_dress_takes() -> None:
    record = example("plate_g82")
    shown = picture(record)
    assert np.diff(shown.edges).tolist() == [1.0] * record.strokes.size
    assert shown.dresses == ((record.dresses["after"][0] + 0.5, record.dresses["seconds"][0]),)
    assert [span.label for span in shown.spans] == ["N50", "N70"]
    np.testing.assert_allclose(titled(shown, "power above idle").mean, 0.001 * record.strokes["power"])


def test_axes_begin_at_zero_and_show_the_limits() -> None:
    record = example("plate_g82")
    for curve in picture(record).curves:
        low, high = curve.span
        assert low <= 0.0 < high
        assert all(low < limit.value < high for limit in curve.limits)
        assert low <= np.nanmin(curve.low) and np.nanmax(curve.high) <= high


def test_many_parts_are_drawn_as_bands() -> None:
    count = 2 * MOST_GROUPS + 7
    record = parts(count)
    assert record.strokes.size > MOST_STROKES and count >= MANY_PARTS
    shown = picture(record)
    assert shown.axis == "part" and shown.banded and len(shown.at) <= MOST_GROUPS
    assert (shown.edges[0], shown.edges[-1]) == (0.5, count + 0.5)
    size, power = 3, 0.001 * record.parts["peak_power"]
    curve = titled(shown, "highest power above idle")
    for k, (low, mean, high) in enumerate(zip(curve.low, curve.mean, curve.high, strict=True)):
        group = power[k * size : (k + 1) * size]
        assert (low, high) == (group.min(), group.max())
        assert mean == pytest.approx(group.mean())


def test_many_strokes_of_one_part_are_drawn_as_bands() -> None:
    record = parts(1, spark_out=999)
    shown = picture(record)
    assert shown.axis == "stroke" and shown.banded and len(shown.at) <= MOST_GROUPS


@pytest.mark.parametrize("suffix", [".png", nightly(".svg"), nightly(".pdf")])
def test_a_plot_takes_any_title(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"plate{suffix}"
    plot_record(example("keyway_g81"), path, "a $\\frac{b$ <&> \x1b[31m.nc")
    assert path.stat().st_size > 10_000

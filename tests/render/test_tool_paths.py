"""Tool path plots draw every motion of `grind trace` in its place, in the style of its source."""

import matplotlib.style
import numpy as np
import pytest
from matplotlib.figure import Figure

from grind_env.control import Control, Motion, execute, read, record
from grind_env.render.tool_paths import STYLES, PathError, draw_over_time, draw_path

CONTOUR = """G71 G90 G18
N10 G00 Z-5. X-5.
N20 G41 G01 Z0 X0 F600.
N30 X10.
N40 G02 Z10. X20. R10.
N50 G39.1
N60 G01 X15.
N70 G40 Z20. X5.
N80 G04 P.5
N90 G00 Z-5.
"""
DRESSED = """G71 G90 G19
N10 G00 X-30. Y2.
N15 G01 Y0 F500.
N20 G82 X30. Y-.02 J-.01 F60. E6000. P9100 D1
N30 M30
O9100
G90 G00 Y50.
G01 Z5. F100.
M99
"""


def axes():
    return Figure().subplots()


def events(text: str, **settings: object) -> list:
    return list(execute(read(text), Control(**settings)))


def test_every_motion_in_the_plane_is_drawn_from_the_previous_end_to_its_end():
    found, shown = events(CONTOUR, radius=2.0), axes()
    draw_path(shown, found, "ZX")
    traced = [(each["end"][2], each["end"][0]) for each in map(record, found) if each]
    moves = [k for k in range(len(traced)) if traced[k] != ([(0.0, 0.0), *traced][k])]
    ends = [(line.get_xdata()[-1], line.get_ydata()[-1]) for line in shown.lines]
    starts = [(line.get_xdata()[0], line.get_ydata()[0]) for line in shown.lines]
    np.testing.assert_allclose(ends, [traced[k] for k in moves], atol=1e-8)
    np.testing.assert_allclose(starts[1:], ends[:-1], atol=1e-8)
    assert len(moves) < len(traced)  # the dwell is no line


def test_an_arc_keeps_its_distance_from_its_centre():
    shown = axes()
    draw_path(shown, events(CONTOUR), "ZX")
    (arc,) = [line for line in shown.lines if len(line.get_xdata()) > 2]
    distances = np.hypot(arc.get_xdata() - 0.0 - 10.0, arc.get_ydata() - 10.0)
    np.testing.assert_allclose(distances, 10.0, atol=1e-6)


def test_the_legend_names_each_source_once_and_line_styles_differ():
    found, shown = events(DRESSED), axes()
    draw_path(shown, found, "XY")
    names = [text.get_text() for text in shown.get_legend().get_texts()]
    sources = {event.source.value for event in found if isinstance(event, Motion)}
    assert len(names) == len(set(names)) and set(names) == sources | {"rapid"}
    looks = [(str(style["ls"]), style["lw"]) for style in STYLES.values()]
    assert len(looks) == len(set(looks))


def test_the_legend_uses_the_given_name_for_programmed_moves():
    shown = axes()
    draw_path(shown, events(CONTOUR, radius=2.0), "ZX", programmed="compensated path")
    names = [text.get_text() for text in shown.get_legend().get_texts()]
    assert names == ["rapid", "compensated path"]


def test_the_plot_over_time_reaches_the_traced_coordinate_at_every_end():
    found, shown = events(CONTOUR), axes()
    draw_over_time(shown, found, "X")
    traced = [each for each in map(record, found) if each]
    ends = [(line.get_xdata()[-1], line.get_ydata()[-1]) for line in shown.lines]
    clock = np.cumsum([each["seconds"] for each in traced])
    np.testing.assert_allclose(ends, list(zip(clock, [each["end"][0] for each in traced], strict=True)), atol=1e-6)
    assert shown.get_xlabel() == "time, s" and shown.get_ylabel() == "X, mm"


@pytest.mark.parametrize("plane", ["XX", "X", "ZXY", "AB"])
def test_an_unknown_plane_or_axis_is_refused(plane):
    with pytest.raises(PathError, match="two of the axes"):
        draw_path(axes(), [], plane)
    with pytest.raises(PathError, match="X, Y or Z"):
        draw_over_time(axes(), [], plane + "Z")


def test_the_style_of_the_package_has_six_distinct_line_styles():
    with matplotlib.style.context("grind_env.render.grind"):
        cycle = [str(each["linestyle"]) for each in matplotlib.rcParams["axes.prop_cycle"]]
    assert len(cycle) == len(set(cycle)) == 6

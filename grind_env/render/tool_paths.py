"""Tool paths of the control, drawn into axes of matplotlib: in a plane, or one coordinate over time."""

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from grind_env.array_types import Floats
from grind_env.control import Arc, Dwell, Event, Motion, Rapid, Source
from grind_env.control.motion_paths import AXES
from grind_env.control.path_geometry import Circular
from grind_env.errors import GrindError
from grind_env.message_text import quoted
from grind_env.render.curve_data import BLUE, GREEN, GREY, ORANGE, RED

if TYPE_CHECKING:
    from matplotlib.axes import Axes

ARC_POINTS = 33  #: number of points drawn of an arc

#: line style of a motion by its source, or of a rapid of the program; distinct without colours, too
STYLES: dict[str, dict[str, Any]] = {
    "rapid": {"color": GREY, "ls": (0, (1, 2)), "lw": 1.2},
    Source.PROGRAM.value: {"color": BLUE, "ls": "-", "lw": 1.8},
    Source.COMPENSATION.value: {"color": ORANGE, "ls": "-", "lw": 3.6},
    Source.CYCLE.value: {"color": "#444444", "ls": "-", "lw": 1.2},
    Source.DRESS.value: {"color": GREEN, "ls": "--", "lw": 1.6},
    Source.RETRACE.value: {"color": RED, "ls": "-.", "lw": 1.6},
    Source.INTERRUPT.value: {"color": "#6a51a3", "ls": (0, (5, 1, 1, 1, 1, 1)), "lw": 1.6},
}


class PathError(GrindError):
    """A path that cannot be drawn as asked."""


def draw_path(axes: "Axes", events: Iterable[Event], plane: str = "ZX", programmed: str = "program") -> None:
    """Draw the motions in a plane, each in the line style of its source, with an arrow in its middle.

    Args:
        axes: axes of matplotlib; they get labels with units, a legend, and equal scales.
        events: events of `control.execute`; motions without a path in the plane are not drawn.
        plane: the axes to the right and upwards, such as `ZX`.
        programmed: legend text for the moves of the program; with G41 or G42 they differ from the written ones.

    Raises:
        PathError: the plane is not two different axes of X, Y and Z.
    """
    if len(set(plane)) != 2 or len(plane) != 2 or not set(plane) <= set(AXES):
        raise PathError(f"the plane is {quoted(plane)}, but must be two of the axes X, Y and Z, such as ZX")
    right, up = (AXES.index(name) for name in plane)
    for motion in _motions(events):
        points = _points(motion)[:, [right, up]]
        if np.ptp(points, axis=0).max() > 0.0:
            _draw(axes, motion, points[:, 0], points[:, 1], programmed)
            _arrow(axes, motion, points)
    axes.set(xlabel=f"{plane[0]}, mm", ylabel=f"{plane[1]}, mm")
    axes.set_aspect("equal")
    _legend(axes)


def draw_over_time(axes: "Axes", events: Iterable[Event], axis: str = "X") -> None:
    """Draw one coordinate over the time of the control, in the line styles of `draw_path`.

    Args:
        axes: axes of matplotlib; they get labels with units and a legend.
        events: events of `control.execute`.
        axis: X, Y or Z.

    Raises:
        PathError: the axis is none of X, Y and Z.
    """
    if axis not in tuple(AXES):
        raise PathError(f"the axis is {quoted(axis)}, but must be X, Y or Z")
    for motion in _motions(events):
        values = _points(motion)[:, AXES.index(axis)]
        _draw(axes, motion, np.linspace(motion.begin, motion.finish, len(values)), values)
    axes.set(xlabel="time, s", ylabel=f"{axis}, mm")
    _legend(axes)


def _motions(events: Iterable[Event]) -> Iterator[Motion]:
    return (event for event in events if isinstance(event, Motion))


def _name(motion: Motion) -> str:
    """Return the key of its line style in `STYLES`."""
    return "rapid" if isinstance(motion, Rapid) and motion.source is Source.PROGRAM else motion.source.value


def _points(motion: Motion) -> Floats:
    """Return points along a motion, shape (points, 3), mm."""
    if not isinstance(motion, Arc):
        return np.array([motion.start, motion.end])
    arc = Circular(motion.start, motion.end, motion.centre, motion.rotation, motion.plane)
    return np.array([arc.point(fraction) for fraction in np.linspace(0.0, 1.0, ARC_POINTS)])


def _draw(axes: "Axes", motion: Motion, right: Floats, up: Floats, programmed: str = "program") -> None:
    name = "dwell" if isinstance(motion, Dwell) else _name(motion)
    style = {"color": GREY, "ls": "-", "lw": 1.0} if isinstance(motion, Dwell) else STYLES[name]
    label = programmed if name == Source.PROGRAM.value else name
    drawn = axes.get_legend_handles_labels()[1]
    axes.plot(right, up, label="_" if label in drawn else label, **style)


def _arrow(axes: "Axes", motion: Motion, points: Floats) -> None:
    middle = len(points) // 2
    before, after = points[middle - 1], points[middle]
    tail, head = before + 0.49 * (after - before), before + 0.51 * (after - before)
    style = {"arrowstyle": "-|>", "color": STYLES[_name(motion)]["color"], "shrinkA": 0.0, "shrinkB": 0.0}
    axes.annotate("", head, tail, arrowprops=style)


def _legend(axes: "Axes") -> None:
    """Draw the legend above the axes, where it hides nothing."""
    _, labels = axes.get_legend_handles_labels()
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=max(len(labels), 1), fontsize=8, handlelength=2.6)

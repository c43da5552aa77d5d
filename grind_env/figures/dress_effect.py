"""The effect of a dress: the last part on a dull wheel and the next part after the dress, stroke by stroke."""

from typing import TYPE_CHECKING

import numpy as np

from grind_env.control import read
from grind_env.errors import GrindError
from grind_env.machine.grind import grind_file
from grind_env.machine.record import GrindingRecord
from grind_env.policies.evaluation import SEEDS
from grind_env.policies.played_episodes import play
from grind_env.policies.problem_lookup import Problem
from grind_env.policies.scripted.rules import Fixed
from grind_env.process.cost import NO_LIMIT, STALL
from grind_env.render.figures import new_figure
from grind_env.render.paper_style import COLOURS, DASHES, MARKS, PAGE, paper_style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: heading, factor and limit (a field of `process.cost.Limits`) of each panel, by the field of `record.STROKE_ROW`
PANELS = {
    "Z": ("depth, mm", 1.0, ""),
    "power": ("power, kW", 0.001, "power"),
    "T": ("temperature\nrise, K", 1.0, "rise"),
    "Ra": ("Ra, µm", 1.0, "roughness"),
    "A": ("wear-flat\narea, %", 100.0, ""),
}
HEIGHT = 0.85  #: height of a panel, in


def dressed_run(problem: Problem, speed: float, every: int) -> GrindingRecord:
    """Return the record of an episode with constant E, mm/min, and a dress every `every` blocks."""
    played = play(Fixed(speed, 1, every), problem, SEEDS["evaluation"])
    return grind_file(read(played.program), played.job, dress_at=played.requests)


def around_dress(record: GrindingRecord) -> tuple[int, int, float]:
    """Return the numbers of the parts before and after the first dress between two whole parts, and its time, s.

    Raises:
        GrindError: no dress lies between two whole parts.
    """
    part = record.strokes["part"]
    for dress in record.dresses:
        done, left = part[: int(dress["after"])], part[int(dress["after"]) :]
        # an auto-dress may fall within a part, which then counts to neither side
        whole = sorted({*done.tolist()} - {*left.tolist()}), sorted({*left.tolist()} - {*done.tolist()})
        if all(whole):
            return whole[0][-1], whole[1][0], float(dress["seconds"])
    raise GrindError("no dress lies between two whole parts of the run: dress after fewer blocks")


def dress_figure(record: GrindingRecord) -> "Figure":
    """Draw depth, power, temperature, Ra and wear flats of the parts before and after the first dress."""
    dull, sharp, seconds = around_dress(record)
    limits = record.job.of_part(dull).limits
    with paper_style():
        from matplotlib.ticker import MaxNLocator

        figure = new_figure(PAGE, 0.7 + HEIGHT * len(PANELS))
        panels = figure.subplots(len(PANELS), 1, sharex=True)
        for number, label, k in ((dull, "on a dull wheel", 2), (sharp, f"after a dress of {seconds:.0f} s", 1)):
            strokes = record.strokes[record.strokes["part"] == number]
            at = np.arange(1, strokes.size + 1)
            for axes, (name, (_, factor, _)) in zip(panels, PANELS.items(), strict=True):
                style = {"color": COLOURS[k], "ls": DASHES[k - 1], "marker": MARKS[k], "ms": 2.5}
                axes.plot(at, factor * strokes[name], label=label, **style)
            for stalled in np.flatnonzero(strokes["torque"] >= STALL)[:1]:
                place = at[stalled], 0.001 * strokes["power"][stalled]
                panels[1].annotate("the spindle stalls", place, (10, -24), textcoords="offset points", color=COLOURS[k])
        for axes, (heading, factor, limit) in zip(panels, PANELS.values(), strict=True):
            value = getattr(limits, limit) if limit else NO_LIMIT
            if value > NO_LIMIT:
                axes.axhline(factor * value, color="#8a8a8a", lw=0.8, ls=":")
                style = {"xycoords": ("axes fraction", "data"), "textcoords": "offset points", "color": "#6a6a6a"}
                axes.annotate("limit", (1.0, factor * value), (0, 2), ha="right", **style)
            axes.set_ylabel(heading)
            axes.set_ylim(0.0, 1.12 * max(axes.dataLim.ymax, factor * value))
            axes.grid(True)
        panels[0].invert_yaxis()
        panels[0].legend(loc="upper right", ncols=2, bbox_to_anchor=(1.0, 1.4))
        panels[-1].xaxis.set_major_locator(MaxNLocator(integer=True))
        panels[-1].set_xlabel("stroke of the part")
        figure.align_ylabels(panels)
    return figure

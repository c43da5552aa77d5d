"""The graph of an optimisation: cost of a part over its time, with the program as it was and the one chosen."""

from typing import TYPE_CHECKING

from grind_env.render.curves import BLUE, GREEN, GREY
from grind_env.render.figures import new_figure
from grind_env.render.graphs import Graph, RuleLine, Series, draw_graph
from grind_env.shop.optimise.outcome import Optimised

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def draw_optimised(found: Optimised) -> "Figure":
    """Draw `trade`."""
    figure = new_figure(6.4, 4.6)
    figure.suptitle(f"{found.program}: cost over time, batches of {found.parts} runs").set_parse_math(False)
    draw_graph(figure.subplots(), trade(found))
    return figure


def trade(found: Optimised) -> Graph:
    """Cost of a part over its time, on the lots of the search."""
    before, chosen = found.chosen
    after = "after" if found.verdict.is_written else "best one tried"
    return Graph(
        x="time of a part, s",
        y="cost of a part, $",
        series=(
            Series(
                name="cheapest tried",
                x=[each.seconds for each in found.cheapest],
                y=[each.cost for each in found.cheapest],
                color=BLUE,
                joined=True,
            ),
            Series(name="before", x=[before.seconds], y=[before.cost], color=GREY, mark="s", size=8.0),
            Series(name=after, x=[chosen.seconds], y=[chosen.cost], color=GREEN, mark="*", size=13.0),
        ),
        rules=tuple(
            RuleLine("x" if wish.name == "seconds" else "y", wish.most, f"asked: {wish.most:g} {wish.unit}")
            for wish in found.wishes
        ),
    )

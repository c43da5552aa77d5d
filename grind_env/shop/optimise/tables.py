"""An optimisation as tables for the terminal, as a graph of cost over time, and as plain data for JSON."""

from collections.abc import Iterable
from dataclasses import asdict, replace
from typing import TYPE_CHECKING, Any

from grind_env.data_table import Cell, Column, Kind, Table, table_of
from grind_env.message_text import printable
from grind_env.policies.score_statistics import Interval
from grind_env.process.cost import NO_LIMIT
from grind_env.render.curve_data import BLUE, GREEN, GREY
from grind_env.render.figures import new_figure
from grind_env.render.series_graphs import Graph, RuleLine, Series, draw_graph
from grind_env.shop.optimise.result import LimitUse, Optimised, PartMean
from grind_env.shop.trials import lots_text

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from rich.console import Console

NAMES = {
    "cost": "cost, $",
    "seconds": "time, s",
    "Ra": "Ra, µm",
    "power": "power, kW",
    "rise": "rise, K",
    "highest_rise": "highest rise, K",
    "size_error": "abs. size err., µm",
    "scrap": "scrap, %",
}
DIGITS = {"cost": 3, "seconds": 1, "Ra": 3, "power": 2, "rise": 0, "highest_rise": 0, "size_error": 2, "scrap": 2}


def tables_of(found: Optimised) -> list[Table]:
    """Return the tables: varied words, both programs side by side, and limits."""
    return [word_table(found), quantity_table(found), limit_table(found)]


def heading(found: Optimised) -> str:
    """Return the heading: subject, lots and machines of the judgement."""
    known = "not calibrated" if found.calibration is None else "calibrated"
    where = f", judged on {printable(found.plant)}" if found.plant else ""
    lots = lots_text(found.lots, "unseen lots")
    return f"{found.program}, {known}, batches of {found.parts} {found.counted}s, {lots}{where}"


def print_result(console: "Console", tables: Iterable[Table], sentences: Iterable[str]) -> None:
    """Print the last sentence, which is the result, then tables and the other sentences."""
    *details, result = sentences
    console.print(result, highlight=False, soft_wrap=True)
    for shown in tables:
        console.print()
        shown.print(console)
    console.print()
    for sentence in details:
        console.print(sentence, highlight=False, soft_wrap=True)


def sentences(found: Optimised) -> list[str]:
    """Return the sentences below the tables, the verdict last."""
    said = list(found.remarks)
    for word in found.words:
        if word.at_bound:
            said.append(
                f"{word.place}: {word.name} {word.after} is its {word.at_bound} value that was tried (--bounds)"
            )
    for each in found.requirements:
        kept = "" if each.kept else ": too much"
        said.append(f"at most {each.most:g} {each.unit} asked: {each.before:.4g} before, {each.after:.4g} after{kept}")
    said += [f"the limit of {each.name} binds: {binding(each)}" for each in found.limits if each.binds]
    if found.ended_early:
        said.append("the budget ended the search: a larger --budget may find more, and the next run may differ")
    programs = "program" if found.evaluations == 1 else "programs"
    if found.promised is not None:
        unit, one = objective_unit(found), found.quantity(found.objective).after
        low, high, off = found.promised.low, found.promised.high, "" if found.is_as_promised else ": promise not kept"
        said.append(f"promised {low:.3f} to {high:.3f} {unit} a part; on this machine {one.value:.3f}{off}")
    said.append(f"{found.evaluations} {programs} tried, {found.judged} judged, seed {found.seed}")
    return [*said, f"{found.verdict.value}: {found.reason}"]


def as_data(found: Optimised) -> dict[str, Any]:
    """Return the optimisation in JSON types."""
    same = "program job calibration confidence reason objective parts lots seed evaluations judged ended_early"
    return {
        **{name: getattr(found, name) for name in same.split()},
        **({"plant": found.plant} if found.plant else {}),
        **({"promised": found.promised._asdict()} if found.promised is not None else {}),
        "verdict": found.verdict.name.lower(),
        "words": [asdict(each) | {"changed": each.changed} for each in found.words],
        "quantities": [
            asdict(each) | {name: getattr(each, name)._asdict() for name in ("before", "after", "difference")}
            for each in found.quantities
        ],
        "limits": [
            asdict(each) | {"kept": each.kept, "price": None if each.price is None else each.price._asdict()}
            for each in found.limits
        ],
        "requirements": [each._asdict() | {"kept": each.kept} for each in found.requirements],
        "cheapest": [each._asdict() for each in found.cheapest],
        "chosen": dict(zip(("before", "after"), (each._asdict() for each in found.chosen), strict=True)),
        "remarks": list(found.remarks),
        "text": found.after,
    }


def values_table(found: Optimised) -> Table:
    """Return a table with a row for each varied value, and for each mean of a part with the ends of its intervals."""
    sides = [f"{side}.{end}" for end in Interval._fields for side in ("before", "after", "difference")]
    columns = [Column("name", "name"), Column("unit", "unit"), *(Column(each, each, ".6g") for each in sides)]
    words = [[*map(Cell, (f"{each.place} {each.name}", each.unit, each.before, each.after))] for each in found.words]
    means = table_of(columns, found.quantities)
    return means._replace(rows=[*words, *means.rows])


def word_table(found: Optimised, after: str = "after") -> Table:
    """Return the table of varied words."""
    columns = (
        Column("block", "place"),
        Column("word", "name"),
        Column("before", "before", right=True),
        Column(after, lambda word: Cell(word.after, "good") if word.changed else Cell("as it is"), right=True),
        Column("in", "unit"),
    )
    return table_of(columns, found.words)


def quantity_table(found: Optimised, after: str = "after", *, whole: bool = False) -> Table:
    """Return both programs side by side with the change and its interval; if `whole`, with all intervals."""
    rows: list[list[Cell]] = []
    for name, each in shown_quantities(found):
        digits, change = decimals(each), each.difference
        kind: Kind = "" if each.name != "cost" else "good" if change.high < 0.0 else "bad" if change.low > 0.0 else ""
        sides = [f"{side if whole else side.value:.{digits}f}" for side in (each.before, each.after)]
        expected = [f"{value:.{digits}f}" for value in each.expected]
        rows.append([*map(Cell, (name, *sides)), Cell(f"{change:+.{digits}f}", kind), *map(Cell, expected)])
    headings = ("of a part", "before", after, f"change ({covered(found)})", "one run: before", after)
    return table_of(headings, rows, left=1)


def shown_quantities(found: Optimised) -> list[tuple[str, PartMean]]:
    """Return the quantities with their names; the highest rise only if it is not the rise of the last stage."""
    shown = {NAMES[each.name]: each for each in found.quantities}
    rise, highest = shown.get(NAMES["rise"]), shown.get(NAMES["highest_rise"])
    if highest is None or replace(highest, name="rise") == rise:
        shown.pop(NAMES["highest_rise"], None)
        return list(shown.items())
    return [("last stage rise, K" if each is rise else name, each) for name, each in shown.items()]


def covered(found: Optimised) -> str:
    """Return the probability of an interval with both ends, as text."""
    return f"{100.0 * (2.0 * found.confidence - 1.0):g} %"


def decimals(quantity: PartMean) -> int:
    """Return the number of decimals of a quantity; fewer if it has many integer digits."""
    largest = max(abs(value) for value in (*quantity.before, *quantity.after, *quantity.expected))
    return max(min(DIGITS[quantity.name], 4 - len(f"{largest:.0f}")), 0)


def limit_table(found: Optimised, after: str = "after") -> Table:
    """Return the margins to the limits, and the objective without each limit."""
    columns = (
        Column("limit", "name"),
        Column("value", limit_text, right=True),
        Column("asked", "margin", ".0f", "%", right=True, factor=100.0),
        Column("before", "before", ".0f", "%", right=True, factor=100.0),
        Column(after, lambda each: Cell(f"{100.0 * each.after:.0f}", "" if each.kept else "bad"), unit="%", right=True),
        Column("change without limit", price_text, unit=objective_unit(found), right=True),
    )
    return table_of(columns, [each for each in found.limits if each.limit > 0.0])


def objective_unit(found: Optimised) -> str:
    """Return the unit of the objective."""
    return found.quantity(found.objective).unit


def limit_text(limit: LimitUse) -> str:
    """Return a limit with its unit; if stations differ, the limit of each."""
    if not limit.stations:
        return f"{limit.limit:.3g} {limit.unit}"
    said = (f"{name} {f'{value:.3g}' if value > NO_LIMIT else 'none'}" for name, value in limit.stations)
    return f"{', '.join(said)} {limit.unit}"


def price_text(limit: LimitUse) -> str:
    """Return the change of the objective without a limit, $ or s, and whether the limit binds."""
    if limit.price is None:
        return "binds" if limit.binds else "unknown"
    if limit.price.value == 0.0:
        return "0"
    return f"{negative(limit.price):+.3f} {'binds' if limit.binds else ''}".rstrip()


def negative(change: Interval) -> Interval:
    """Return a change with the opposite sign."""
    return Interval(-change.value, -change.high, -change.low)


def binding(limit: LimitUse) -> str:
    """Return the evidence that a limit binds, as text."""
    if limit.without is None:
        return f"parts reach {100.0 * limit.after:.0f} % of it, {100.0 * limit.margin:.0f} % is allowed"
    return f"cheaper settings reach {100.0 * limit.without:.0f} % of it"


def draw_optimised(found: Optimised) -> "Figure":
    """Draw the graph `trade`."""
    figure = new_figure(6.4, 4.6)
    figure.suptitle(f"{found.program}: cost over time, batches of {found.parts} {found.counted}s").set_parse_math(False)
    draw_graph(figure.subplots(), trade(found))
    return figure


def trade(found: Optimised) -> Graph:
    """Return the graph of cost over time of a part, on the lots of the search."""
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
            RuleLine("x" if each.name == "seconds" else "y", each.most, f"asked: {each.most:g} {each.unit}")
            for each in found.requirements
        ),
    )

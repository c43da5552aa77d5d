"""A table as data: columns say how to show a row; terminal, Markdown and HTML have a renderer each.

The columns take their cells from rows of any kind::

    table_of([Column("policy", "name"), Column("cost", "cost.value", ".2f", unit="$", right=True)], results)

or, given as plain titles, from rows that are texts already: `table_of(("policy", "cost"), [("constant", "2.31")])`.
"""

from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from html import escape
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from grind_env.message_text import printable

if TYPE_CHECKING:
    from rich.console import Console, RenderableType

NONE = "–"  #: text of a cell whose value is None
STYLES = {"bad": "red", "poor": "yellow", "dim": "dim"}  #: colours of a terminal by the kind of a cell
WIDEST = 10**6  #: greatest width of a table whose lines are not broken, characters

Kind = Literal["good", "poor", "bad", "code", "dim", ""]


class Cell(NamedTuple):
    """A cell of a table."""

    text: str  #: shown text
    kind: Kind = ""  #: judgement of the value; "" for neither good nor bad
    below: str = ""  #: lines below the text, indented, on a terminal


class Column(NamedTuple):
    """A column of a table."""

    title: str  #: heading; a terminal keeps its lines
    # attribute of the row, such as `cost.low`, or function of the row; by default the entry at the column's index
    value: str | Callable[[Any], object] = ""
    form: str = ""  #: format of a number, as in `format`, such as `.2f`
    unit: str = ""  #: unit of the values, below or behind the title
    right: bool = False  #: whether cells are right-aligned, as numbers are
    wrap: bool = False  #: whether a terminal may break its cells, for sentences
    factor: float = 1.0  #: factor from values to the unit

    @property
    def heading(self) -> str:
        """Title and unit in one line."""
        title = self.title.replace("\n", " ")
        return f"{title}, {self.unit}" if self.unit else title

    def cell(self, row: Any, place: int) -> Cell:
        """Return the cell of a row; `place` is the index of the column."""
        value: Any
        if callable(self.value):
            value = self.value(row)
        else:
            value = row if self.value else row[place]
            for name in filter(None, self.value.split(".")):
                value = None if value is None else getattr(value, name)
        if isinstance(value, Cell):
            return value
        if value is None:
            return Cell(NONE)
        return Cell(format(value if self.factor == 1.0 else value * self.factor, self.form))


class Table(NamedTuple):
    """A table: columns, rows of a cell each, and a title."""

    columns: Sequence[Column]
    rows: Sequence[Sequence[Cell]]
    title: str = ""

    @property
    def headings(self) -> list[str]:
        """Headings of the columns, each in one line."""
        return [column.heading for column in self.columns]

    def shortened(self, most: int, gap: str = "… {} more") -> "Table":
        """Return the table with only its first and last rows, `most` in total, and a row of one cell between them."""
        left_out = len(self.rows) - most
        if left_out <= 0:
            return self
        return self._replace(
            rows=[*self.rows[: most // 2], [Cell(gap.format(left_out))], *self.rows[most // 2 + left_out :]]
        )

    def markdown(self) -> str:
        """Return the table as Markdown; bars within a cell are escaped."""
        rules = ["---:" if column.right else "---" for column in self.columns]
        lines = [self.headings, rules, *([cell.text for cell in row] for row in self.rows)]
        return "\n".join(f"| {' | '.join(text.replace('|', chr(92) + '|') for text in line)} |" for line in lines)

    def plain(self) -> list[list[float | str]]:
        """Return headings and rows as a CSV file has them: numbers are numbers, no value is empty, `um` is µm."""
        return [[*map(_plain, self.headings)], *([_plain(cell.text) for cell in row] for row in self.rows)]

    def html(self, attributes: Callable[[bool, Kind], str]) -> str:
        """Return the <table> element with escaped texts; `attributes(right, kind)` returns the attributes of a cell."""

        def line(name: str, cells: Sequence[Cell]) -> str:
            span = "" if len(cells) == len(self.columns) else f' colspan="{len(self.columns)}"'
            right = [column.right and not span for column in self.columns]
            shown = (
                f"<{name}{span}{attributes(right[k], cell.kind)}>{escape(printable(cell.text))}</{name}>"
                for k, cell in enumerate(cells)
            )
            return f"<tr>{''.join(shown)}</tr>"

        head = line("th", [Cell(heading) for heading in self.headings])
        return f"<table><thead>{head}</thead><tbody>{''.join(line('td', row) for row in self.rows)}</tbody></table>"

    def print(self, console: "Console", **look: Any) -> None:
        """Print the table; `look` goes to `rich.table.Table`. No text is cut if no column may be broken."""
        from rich import table
        from rich.box import SIMPLE_HEAD

        compact: dict[str, Any] = {"box": SIMPLE_HEAD, "show_edge": False, "pad_edge": False, "padding": (0, 1, 0, 0)}
        made = table.Table(**compact | {"title": self.title or None, "title_justify": "left"} | look)
        titles = ["\n".join(filter(None, (column.title, column.unit))) for column in self.columns]
        height = max(title.count("\n") for title in titles)
        for column, title in zip(self.columns, titles, strict=True):
            lower = "\n" * (height - title.count("\n")) + title
            made.add_column(lower, justify="right" if column.right else "left", no_wrap=not column.wrap)
        for row in self.rows:
            made.add_row(*map(_rich, row))
        if not any(column.wrap for column in self.columns):
            made.width = console.measure(made, options=console.options.update(width=WIDEST)).maximum
        console.print(made, soft_wrap=made.width is not None)


def table_of(
    columns: Sequence[Column | str], rows: Iterable[Any], title: str = "", *, left: int | None = None
) -> Table:
    """Return a table of rows; of plain titles, the first `left` are columns of texts, the others columns of numbers."""
    made = [
        column if isinstance(column, Column) else Column(column, right=left is not None and k >= left)
        for k, column in enumerate(columns)
    ]
    return Table(made, [[column.cell(row, k) for k, column in enumerate(made)] for row in rows], title)


def _plain(text: str) -> float | str:
    with suppress(ValueError):
        return int(text) if text.isdecimal() else float(text)
    return "" if text == NONE else text.replace("µm", "um")  # Excel reads UTF-8 as Latin-1


def _rich(cell: Cell) -> "RenderableType":
    from rich.console import Group
    from rich.padding import Padding
    from rich.text import Text

    text = Text(printable(cell.text), STYLES.get(cell.kind, ""))
    return Group(text, Padding(Text(printable(cell.below)), (0, 0, 0, 2))) if cell.below else text

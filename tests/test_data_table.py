"""One table as Markdown, HTML and terminal text."""

import io
from typing import NamedTuple

import pytest
from rich.console import Console

from grind_env.data_table import Cell, Column, Table, table_of
from grind_env.policies.score_statistics import Interval


class Found(NamedTuple):
    name: str
    cost: Interval | None
    share: float


COLUMNS = (
    Column("policy", "name"),
    Column("cost", "cost", "±.2f", unit="$", right=True),
    Column("lowest", "cost.low", ".1f", right=True),
    Column(
        "scrap", lambda row: Cell(f"{100.0 * row.share:.0f}", "bad" if row.share > 0.1 else ""), unit="%", right=True
    ),
)
SHOWN = table_of(COLUMNS, [Found("a|<b>", Interval(2.0, 1.5, 3.5), 0.25), Found("long name", None, 0.0)])


def printed(table: Table, width: int) -> list[str]:
    console = Console(file=io.StringIO(), width=width)
    table.print(console)
    return [line.rstrip() for line in console.file.getvalue().splitlines()]


def test_markdown_aligns_numbers_and_escapes_bars():
    assert SHOWN.markdown().splitlines() == [
        "| policy | cost, $ | lowest | scrap, % |",
        "| --- | ---: | ---: | ---: |",
        "| a\\|<b> | 2.00 ± 1.00 | 1.5 | 25 |",
        "| long name | – | – | 0 |",
    ]


def test_html_escapes_text_and_marks_bad_cells():
    html = SHOWN.html(lambda right, kind: f' class="{kind}{right:d}"')
    assert '<td class="0">a|&lt;b&gt;</td>' in html
    assert '<td class="bad1">25</td>' in html
    assert html.count("<tr>") == 3


@pytest.mark.parametrize("width", [20, 200])
def test_a_terminal_of_any_width_shows_every_number(width):
    lines = printed(SHOWN, width)
    assert lines[0].split() == ["cost", "scrap"]
    assert lines[1].split() == ["policy", "$", "lowest", "%"]
    assert lines[3:] == ["a|<b>      2.00 ± 1.00     1.5     25", "long name            –       –      0"]


def test_a_wrapping_column_breaks_sentences():
    words = table_of([Column("what", wrap=True)], [("one two three four",)])
    assert printed(words, 10)[2:] == ["one two", "three four"]


def test_a_shortened_table_keeps_its_first_and_last_rows():
    short = table_of(("n", "m"), [(k, k) for k in range(9)]).shortened(4)
    assert [row[0].text for row in short.rows] == ["0", "1", "… 5 more", "7", "8"]
    assert 'colspan="2"' in short.html(lambda right, kind: "")
    assert (
        table_of(("n",), [(k,) for k in range(4)]).shortened(4).rows == table_of(("n",), [(k,) for k in range(4)]).rows
    )

"""Small HTML for notebook views, without scripts, page styles or external files.

Colours are those of the notebook, dark or light. Each function takes plain text and returns HTML with the text escaped.
"""

from collections.abc import Iterable, Sequence
from html import escape
from typing import Any

from grind_env.data_table import Column, table_of
from grind_env.message_text import printable

MOST_ROWS = 30  #: most rows of a table; a longer table shows its first and last rows
MOST_ITEMS = 10  #: most items of a list; a longer list shows its first and last items
MOST_LINES = 60  #: most lines of a listing; further lines are only counted
LONGEST_LINE = 160  #: most characters in a line of a listing

BAD = "color:#d8433b;font-weight:bold"  #: style of a bad value, readable on white and on black
LEFT, RIGHT = "text-align:left;padding:2px 8px", "text-align:right;padding:2px 8px"


def fragment(title: str, *bodies: str) -> str:
    """Return a notebook view: a title, then bodies from the functions below; dollar signs start no formulas."""
    heading = f"<p><b>{_escaped(title)}</b></p>" if title else ""
    return f'<div class="grind tex2jax_ignore mathjax_ignore">{heading}{"".join(bodies)}</div>'


def table(columns: Sequence[Column | str], rows: Iterable[Any], left: int = 1) -> str:
    """Return a table made by `grind_env.data_table.table_of`; its first `left` columns are text, the others numbers."""
    shown = table_of(columns, rows, left=left).shortened(MOST_ROWS)
    body = shown.html(lambda right, kind: f' style="{RIGHT if right else LEFT}{";" + BAD if kind == "bad" else ""}"')
    return f'<div style="overflow-x:auto;margin:0.5em 0">{body}</div>'


def paragraphs(lines: Iterable[str], *, bad: bool = False) -> str:
    """Return one paragraph for each line, in red if `bad`."""
    style = f' style="{BAD}"' if bad else ""
    return "".join(f"<p{style}>{_escaped(line)}</p>" for line in lines)


def items(lines: Iterable[str]) -> str:
    """Return a bulleted list; an empty text for no lines."""
    shown = [f"<li>{_escaped(line)}</li>" for line in lines]
    if len(shown) > MOST_ITEMS:
        half = MOST_ITEMS // 2
        shown = [*shown[:half], f"<li>… {len(shown) - MOST_ITEMS} more</li>", *shown[half - MOST_ITEMS :]]
    listed = "".join(shown)
    return f"<ul>{listed}</ul>" if listed else ""


def listing(lines: Sequence[str], more: int = 0) -> str:
    """Return numbered lines of a program, then the number of lines left out; `more` lines follow after `lines`."""
    width = len(str(len(lines)))
    hidden = max(len(lines) - MOST_LINES, 0) + more
    cut = [line if len(line) <= LONGEST_LINE else line[:LONGEST_LINE] + "…" for line in lines[:MOST_LINES]]
    shown = [f"{k:>{width}}  {line}" for k, line in enumerate(cut, 1)]
    end = [f"… {hidden} more lines"] if hidden else []
    return f'<pre style="text-align:left;overflow-x:auto">{_escaped(chr(10).join([*shown, *end]))}</pre>'


def _escaped(text: str) -> str:
    return escape(printable(text))

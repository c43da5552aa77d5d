"""Small HTML for notebook views, without scripts, page styles or external files.

Colours are those of the notebook, dark or light. Each function takes plain texts and gives HTML in which they are
escaped.
"""

from collections.abc import Iterable, Sequence
from html import escape
from typing import Any

from grind_env.errors import printable
from grind_env.table import Column, table_of

MOST_ROWS = 30
"""Most rows of a table; of more the first and the last are shown."""
MOST_ITEMS = 10
"""Most items of a list; of more the first and the last are shown."""
MOST_LINES = 60
"""Most lines of a listing; what follows is counted."""
LONGEST_LINE = 160
"""Characters of a line of a listing."""

BAD = "color:#d8433b;font-weight:bold"
"""Readable on white and on black."""
LEFT, RIGHT = "text-align:left;padding:2px 8px", "text-align:right;padding:2px 8px"


def fragment(title: str, *bodies: str) -> str:
    """Return a notebook view: a title, then bodies made by the functions below; dollars are no mathematics."""
    heading = f"<p><b>{_escaped(title)}</b></p>" if title else ""
    return f'<div class="grind tex2jax_ignore mathjax_ignore">{heading}{"".join(bodies)}</div>'


def table(columns: Sequence[Column | str], rows: Iterable[Any], left: int = 1) -> str:
    """Return a table as of `grind_env.table.table_of`; its first `left` columns are text, the others numbers."""
    shown = table_of(columns, rows, left=left).shortened(MOST_ROWS)
    body = shown.html(lambda right, kind: f' style="{RIGHT if right else LEFT}{";" + BAD if kind == "bad" else ""}"')
    return f'<div style="overflow-x:auto;margin:0.5em 0">{body}</div>'


def paragraphs(lines: Iterable[str], *, bad: bool = False) -> str:
    """Return a sentence or two each; in red what is bad."""
    style = f' style="{BAD}"' if bad else ""
    return "".join(f"<p{style}>{_escaped(line)}</p>" for line in lines)


def items(lines: Iterable[str]) -> str:
    """Return a list; empty for no lines."""
    shown = [f"<li>{_escaped(line)}</li>" for line in lines]
    if len(shown) > MOST_ITEMS:
        half = MOST_ITEMS // 2
        shown = [*shown[:half], f"<li>… {len(shown) - MOST_ITEMS} more</li>", *shown[half - MOST_ITEMS :]]
    listed = "".join(shown)
    return f"<ul>{listed}</ul>" if listed else ""


def listing(lines: Sequence[str], more: int = 0) -> str:
    """Numbered lines of a program, and how many `more` there are."""
    width = len(str(len(lines)))
    hidden = max(len(lines) - MOST_LINES, 0) + more
    cut = [line if len(line) <= LONGEST_LINE else line[:LONGEST_LINE] + "…" for line in lines[:MOST_LINES]]
    shown = [f"{k:>{width}}  {line}" for k, line in enumerate(cut, 1)]
    end = [f"… {hidden} more lines"] if hidden else []
    return f'<pre style="text-align:left;overflow-x:auto">{_escaped(chr(10).join([*shown, *end]))}</pre>'


def _escaped(text: str) -> str:
    return escape(printable(text))

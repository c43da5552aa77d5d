"""What every report is made of: a page of sections, and in them verdicts, tables, figures, lists and listings.

Each function takes plain texts and gives markup in which they are escaped; only such markup goes into a page::

    page("Sweep of plate.nc", [Section("Cost", [table(("E", "$"), rows), figure(plotly_figure, "cost over E")])])
"""

import functools
from collections.abc import Iterable, Mapping, Sequence
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from grind_env import __version__
from grind_env.errors import printable
from grind_env.extras import needing
from grind_env.files import FileError, check_target, write_atomically

if TYPE_CHECKING:
    from jinja2 import Environment
    from markupsafe import Markup

TEMPLATES = Path(__file__).with_name("templates")
SUFFIXES = (".html", ".htm")
GENERATOR = f"grind_env {__version__}"

Level = Literal["good", "poor", "bad", ""]
"""What a verdict, a cell or a note says of its matter; "" for neither good nor bad."""


class Cell(NamedTuple):
    """A cell of a table; a plain text is one without a kind."""

    text: str
    kind: Literal["good", "poor", "bad", "code", ""] = ""


class Section(NamedTuple):
    """A heading, and what stands below it: markup by the functions of this module."""

    title: str
    body: "Sequence[Markup]"


class Note(NamedTuple):
    """A remark below a line of a listing."""

    text: str
    kind: Level = ""


class Line(NamedTuple):
    """A line of a listing."""

    number: str
    text: str
    notes: Sequence[Note] = ()


def verdict(level: Level, headline: str, lines: Sequence[str] = ()) -> "Markup":
    """A sentence that sums up, and what is to be said to it."""
    return _block("verdict", level, printable(headline), [printable(line) for line in lines])


def table(headings: Sequence[str], rows: Iterable[Sequence[str | Cell]], caption: str = "", left: int = 1) -> "Markup":
    """A table; its first `left` columns are text, the others numbers."""
    cells = [[_cell(cell) for cell in row] for row in rows]
    return _block("table", [printable(heading) for heading in headings], cells, printable(caption), left)


def figure(drawn: Any, caption: str = "", height: int = 420) -> "Markup":
    """A figure of plotly, `height` px high and as wide as the page.

    Texts from outside that it shows must have passed through `plotly_text`.
    """
    from markupsafe import Markup

    return _block("figure", Markup(_no_tags(drawn.to_json())), printable(caption), height)


def items(lines: Sequence[str]) -> "Markup":
    """A list."""
    return _block("items", [printable(line) for line in lines])


def paragraph(text: str) -> "Markup":
    """A paragraph."""
    return _block("paragraph", printable(text))


def listing(lines: Sequence[Line]) -> "Markup":
    """Numbered lines of a program or a file, with remarks."""
    return _block(
        "listing",
        [
            Line(
                printable(line.number),
                printable(line.text),
                [Note(printable(note.text), note.kind) for note in line.notes],
            )
            for line in lines
        ],
    )


def plotly_text(text: str) -> str:
    """A text as a figure of plotly shows it, which would take tags in it for its own."""
    return escape(printable(text))


def page(title: str, sections: Sequence[Section], facts: Mapping[str, str] | None = None) -> str:
    """A whole page, HTML: title, facts such as the revision of a program by their names, and sections.

    The page loads nothing from anywhere, and its security policy forbids it to. Where it has a figure it holds all of
    plotly.js, 4.8 MB.

    Raises:
        MissingExtra: Jinja2 or plotly is not installed.
    """
    markup = _markup()
    has_plots = any('class="plot"' in part for section in sections for part in section.body)
    return (
        _environment()
        .get_template("page.html")
        .render(
            title=printable(title),
            facts={printable(name): printable(value) for name, value in (facts or {}).items()},
            sections=[Section(printable(section.title), section.body) for section in sections],
            generator=GENERATOR,
            style=markup((TEMPLATES / "page.css").read_text("utf-8")),
            script=markup((TEMPLATES / "page.js").read_text("utf-8")),
            plotly=markup(_plotly()) if has_plots else "",
        )
    )


def prepare_page(path: Path) -> None:
    """Find out, before long work for a page, whether it can be written.

    Raises:
        FileError: the folder does not exist, or the file has another suffix than `SUFFIXES`.
        MissingExtra: Jinja2 or plotly is not installed.
    """
    _check_suffix(path)
    check_target(path)
    _environment()
    _plotly()


def write_page(path: Path, html: str) -> None:
    """Write a page, whole or not at all.

    Raises:
        FileError: the folder does not exist or cannot be written to, or as of `prepare_page`.
    """
    _check_suffix(path)
    write_atomically(path, lambda temporary: temporary.write_text(html, encoding="utf-8"))


def _check_suffix(path: Path) -> None:
    """Keep a page from being written over a program or a job."""
    if path.suffix.lower() not in SUFFIXES:
        raise FileError(f"{path}: a page is written as {' or '.join(SUFFIXES)}; name such a file")


def _cell(cell: str | Cell) -> Cell:
    return Cell(printable(cell)) if isinstance(cell, str) else Cell(printable(cell.text), cell.kind)


def _block(name: str, *arguments: Any) -> "Markup":
    block: Markup = getattr(_environment().get_template("blocks.html").module, name)(*arguments)
    return block


def _no_tags(document: str) -> str:
    """A JSON document in which no script ends: its strings keep their meaning."""
    return document.replace("<", "\\u003c")


@functools.cache
def _environment() -> "Environment":
    with needing("shop", "reports need"):
        from jinja2 import Environment, FileSystemLoader, StrictUndefined
    return Environment(
        loader=FileSystemLoader(TEMPLATES),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )


def _markup() -> "type[Markup]":
    _environment()
    from markupsafe import Markup

    return Markup


def _plotly() -> str:
    with needing("shop", "reports need"):
        from plotly.offline import get_plotlyjs
    return str(get_plotlyjs())

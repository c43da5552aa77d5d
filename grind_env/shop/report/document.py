"""Building blocks of reports: a page of sections with verdicts, tables, figures, lists and listings.

Each function takes plain texts and gives markup in which they are escaped; only such markup goes into a page::

    page("Sweep of plate.nc", [Section("Cost", [table(table_of(("E", "$"), rows)), figure(graph, "cost over E")])])
"""

import functools
import re
from collections.abc import Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from grind_env import __version__
from grind_env.data_table import Kind, Table
from grind_env.files import FileError, check_target, write_atomically
from grind_env.message_text import printable
from grind_env.optional_libraries import needing
from grind_env.output_checks import FileKind

if TYPE_CHECKING:
    from jinja2 import Environment
    from markupsafe import Markup

    from grind_env.render.curve_data import Picture
    from grind_env.render.series_graphs import Graph

TEMPLATES = Path(__file__).with_name("templates")
SUFFIXES = (".html", ".htm")
TITLE = "Grinding report: "
#: page that `grind report` recognises as its own: under a default name it replaces no other file
PAGE = FileKind("page of `grind report`", re.compile(rb"(?s).*<title>" + TITLE.encode()).match)
MOST_LINES, LONGEST_LINE = 400, 1000  #: greatest number of lines of a listing, and of characters of a line


class Section(NamedTuple):
    """Section of a page: a heading, and a body made by the functions of this module."""

    title: str
    body: "Sequence[Markup]"


class Note(NamedTuple):
    """Note below a line of a listing."""

    text: str
    kind: Kind = ""


def verdict(level: Kind, headline: str, lines: Sequence[str] = ()) -> "Markup":
    """Return a summary sentence with its details."""
    return _block("verdict", level, headline, lines)


def table(content: Table, caption: str = "") -> "Markup":
    """Return a table."""
    return _block("table", _markup(content.html(_attributes)), caption)


def figure(content: "Picture | Graph", caption: str = "") -> "Markup":
    """Return a figure as wide as the page, drawn as SVG; any texts are escaped.

    Raises:
        MissingExtra: as in `page`.
    """
    from grind_env.shop.report.svg_figures import drawn

    return _block("figure", _markup(drawn(content)), caption)


def items(lines: Sequence[str]) -> "Markup":
    """Return a list."""
    return _block("items", lines)


def paragraph(text: str) -> "Markup":
    """Return a paragraph."""
    return _block("paragraph", text)


def listing(texts: Sequence[str], notes: Mapping[int, Sequence[Note]] = {}) -> "list[Markup]":
    """Return the lines of a program or a file, at most `MOST_LINES`, with notes by line number from 1."""
    lines = [
        (number, text[:LONGEST_LINE] + "…" * (len(text) > LONGEST_LINE), notes.get(number, ()))
        for number, text in enumerate(texts[:MOST_LINES], 1)
    ]
    hidden = len(texts) - len(lines)
    return [_block("listing", lines), *([paragraph(f"{hidden} more lines are not shown.")] if hidden else [])]


def page(title: str, sections: Sequence[Section], facts: Mapping[str, str] = {}) -> str:
    """Return a whole page, HTML: title, facts by name such as the revision of a program, and sections.

    The security policy of the page forbids it to load anything and to run any script.

    Raises:
        MissingExtra: Jinja2 or matplotlib is not installed.
    """
    return (
        _environment()
        .get_template("page.html")
        .render(
            title=title,
            facts=facts,
            sections=sections,
            generator=f"grind_env {__version__}",
            style=_markup((TEMPLATES / "page.css").read_text("utf-8")),
        )
    )


def prepare_page(path: Path) -> None:
    """Check, before long work, that a page can be written.

    Raises:
        FileError: the folder does not exist, or the file has another suffix than `SUFFIXES`.
        MissingExtra: as in `page`.
    """
    _check_suffix(path)
    check_target(path)
    _environment()


def write_page(path: Path, html: str) -> None:
    """Write a page atomically.

    Raises:
        FileError: the folder does not exist or cannot be written to, or as in `prepare_page`.
    """
    _check_suffix(path)
    write_atomically(path, lambda temporary: temporary.write_text(html, encoding="utf-8"))


def _check_suffix(path: Path) -> None:
    """Refuse other suffixes than `SUFFIXES`, so that no page replaces a program or a job."""
    if path.suffix.lower() not in SUFFIXES:
        raise FileError(f"{path}: a page is written as {' or '.join(SUFFIXES)}; name such a file")


def _attributes(right: bool, kind: Kind) -> str:
    names = " ".join(filter(None, (kind, "number" if right else "")))
    return f' class="{names}"' if names else ""


def _block(name: str, *arguments: Any) -> "Markup":
    block: Markup = getattr(_environment().get_template("blocks.html").module, name)(*arguments)
    return block


@functools.cache
def _environment() -> "Environment":
    with needing("shop", "reports need"):
        import_module("matplotlib")
        from jinja2 import Environment, FileSystemLoader, StrictUndefined
    return Environment(
        loader=FileSystemLoader(TEMPLATES),
        autoescape=True,
        finalize=lambda value: value if hasattr(value, "__html__") else printable(str(value)),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )


def _markup(text: str) -> "Markup":
    _environment()
    from markupsafe import Markup

    return Markup(text)

"""Building blocks of reports: no text can add markup to a page."""

import re
from html.parser import HTMLParser

import pytest
from hypothesis import given
from hypothesis import strategies as st

from grind_env.data_table import Cell, table_of
from grind_env.message_text import printable
from grind_env.render.curve_data import BLUE
from grind_env.render.series_graphs import Graph, RuleLine, Series
from grind_env.shop.report import document

pytest.importorskip("matplotlib")

HOSTILE = "</script><script>alert(1)</script><img src=x onerror=alert(1)>\"'&{{ 1 }}\x1b[31m\x00"


class Parsed(HTMLParser):
    """Tags, attributes and texts of a page."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.attributes: list[tuple[str, str]] = []
        self.texts: list[str] = []
        self.feed(html)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.attributes += [(name, value or "") for name, value in attrs]

    def handle_data(self, data: str) -> None:
        self.texts.append(data)


def loads_nothing(said: Parsed) -> bool:
    """Return whether a page runs no script and refers only to places within itself."""
    loading = {"script", "link", "img", "image", "iframe", "object", "embed", "base"} & set(said.tags)
    naming = ("src", "href", "xlink:href", "action", "data")
    addresses = [value for name, value in said.attributes if name in naming and not value.startswith("#")]
    return not loading and not addresses and any("default-src 'none'" in value for _, value in said.attributes)


def everything(text: str) -> str:
    return document.page(
        text,
        [
            document.Section(
                text,
                [
                    document.verdict("bad", text, [text]),
                    document.table(table_of([text, text], [[text, Cell(text, "code")]]), text),
                    document.items([text]),
                    document.paragraph(text),
                    *document.listing([text], {1: [document.Note(text, "poor")]}),
                ],
            )
        ],
        {text: text},
    )


@given(st.text(min_size=1))
def test_no_text_changes_the_tags_of_a_page(text: str) -> None:
    said, plain = Parsed(everything(text)), Parsed(everything("text"))
    assert said.tags == plain.tags
    assert [name for name, _ in said.attributes] == [name for name, _ in plain.attributes]


def graph(text: str) -> Graph:
    points = Series(name=text, x=[1.0, 2.0], y=[0.0, 1.0], color=BLUE)
    return Graph(x=text, y=text, series=(points,), rules=(RuleLine("x", 1.5, text),), rows=(text, text))


def drawn(text: str) -> str:
    return document.page("Title", [document.Section("Run", [document.figure(graph(text), text)])])


@pytest.mark.parametrize("text", [HOSTILE, "$x^{$", "a$b$c", "--><b>", "&lt;b&gt;", '" id="a" onload="b'])
def test_a_text_in_a_figure_is_shown_but_adds_no_markup(text: str) -> None:
    html = drawn(text)
    said, plain = Parsed(html), Parsed(drawn("text"))
    assert said.tags.count("text") == plain.tags.count("text") and said.texts.count(printable(text)) == 7
    names = {name for name, _ in said.attributes}
    assert set(said.tags) == set(plain.tags) and names == {name for name, _ in plain.attributes}
    assert not [name for name in names if name.startswith("on")] and "script" not in said.tags
    assert not re.search(r"[\x00-\x08\x0b-\x1f\x7f]", html)


def test_a_page_loads_and_runs_nothing() -> None:
    said = Parsed(drawn("text"))
    assert loads_nothing(said)
    assert next(value for _, value in said.attributes if "default-src" in value) == (
        "default-src 'none'; style-src 'unsafe-inline'"
    )


def test_figures_use_only_colours_defined_by_the_page() -> None:
    """A fixed colour might be invisible on a dark page."""
    html = drawn("text")
    svg = html[html.index("<svg") : html.index("</svg>")]
    assert not re.search(r"#[0-9a-f]{6}\b|url\((?!#)", svg)
    named = set(re.findall(r"var\(--(\w+)\)", svg))
    assert {"ink", "grid", "blue"} <= named <= set(re.findall(r"--(\w+):", html))


def test_figures_refer_to_exactly_the_ids_of_their_page() -> None:
    said = Parsed(
        document.page("Title", [document.Section("Run", [document.figure(graph("a")), document.figure(graph("b"))])])
    )
    ids = {value for name, value in said.attributes if name == "id"}
    referred = [value for name, value in said.attributes if name in ("xlink:href", "clip-path")]
    assert ids == {re.sub(r"url\(#(\w+)\)|#", r"\1", value) for value in referred}

"""The building blocks of reports: whatever texts go in, only markup of the templates comes out."""

import json
import re
from html.parser import HTMLParser

import pytest
from hypothesis import given
from hypothesis import strategies as st

from grind_env.shop.report.document import (
    Cell,
    Line,
    Note,
    Section,
    figure,
    items,
    listing,
    page,
    paragraph,
    plotly_text,
    table,
    verdict,
)

plotly = pytest.importorskip("plotly.graph_objects")

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


def everything(text: str) -> str:
    return page(
        text,
        [
            Section(
                text,
                [
                    verdict("bad", text, [text]),
                    table([text, text], [[text, Cell(text, "code")]], text),
                    items([text]),
                    paragraph(text),
                    listing([Line(text, text, [Note(text, "poor")])]),
                ],
            )
        ],
        {text: text},
    )


@given(st.text(min_size=1))
def test_a_text_changes_no_tag(text: str) -> None:
    said, plain = Parsed(everything(text)), Parsed(everything("text"))
    assert said.tags == plain.tags
    assert [name for name, _ in said.attributes] == [name for name, _ in plain.attributes]


def test_a_hostile_text_is_shown_and_nothing_else() -> None:
    html = everything(HOSTILE)
    said = Parsed(html)
    assert "script" not in said.tags and "img" not in said.tags
    assert not re.search(r"[\x00-\x08\x0b-\x1f\x7f]", html)
    assert any("<script>alert(1)</script>" in text and "\\x1b[31m\\x00" in text for text in said.texts)


def test_a_figure_ends_no_script_and_keeps_its_texts() -> None:
    drawn = plotly.Figure(plotly.Scatter(x=[1, 2], y=[3, 4], name=plotly_text(HOSTILE)))
    html = str(figure(drawn))
    document = html.partition('<script type="application/json">')[2].partition("</script>")[0]
    assert json.loads(document)["data"][0]["name"] == plotly_text(HOSTILE)
    assert "<" not in plotly_text(HOSTILE) and "\x1b" not in plotly_text(HOSTILE)
    assert Parsed(html).tags.count("script") == 1


def test_a_page_loads_nothing() -> None:
    html = page("Title", [Section("Run", [figure(plotly.Figure(plotly.Scatter(y=[1, 2])))])])
    said = Parsed(html)
    assert not {"link", "img", "iframe", "object", "embed", "base"} & set(said.tags)
    assert not [value for name, value in said.attributes if name in ("src", "href", "action", "data")]
    assert any("default-src 'none'" in value for _, value in said.attributes)
    assert html.count("Plotly.newPlot(plot") == 1


def test_plotly_is_in_a_page_with_a_figure_only() -> None:
    assert len(page("Title", [Section("Text", [paragraph('class="plot"')])])) < 10_000

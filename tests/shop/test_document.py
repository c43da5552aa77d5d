"""The building blocks of reports: whatever texts go in, only markup of the templates comes out."""

import json
import re
from html.parser import HTMLParser
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from grind_env.errors import printable
from grind_env.files import FileError
from grind_env.render.curves import BLUE
from grind_env.render.graphs import Graph, Rule, Series
from grind_env.shop.report.document import (
    PLOTLY,
    Cell,
    Line,
    Note,
    Section,
    figure,
    items,
    listing,
    page,
    paragraph,
    prepare_page,
    table,
    verdict,
    write_page,
)
from grind_env.shop.report.interactive import plotly_text

pytest.importorskip("plotly")
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
    """Whether a page names nothing but places within itself."""
    loading = {"link", "img", "image", "iframe", "object", "embed", "base"} & set(said.tags)
    naming = ("src", "href", "xlink:href", "action", "data")
    addresses = [value for name, value in said.attributes if name in naming and not value.startswith("#")]
    return not loading and not addresses and any("default-src 'none'" in value for _, value in said.attributes)


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


def graph(text: str) -> Graph:
    points = Series(name=text, x=[1.0, 2.0], y=[0.0, 1.0], color=BLUE, texts=[text, text])
    return Graph(x=text, y=text, series=(points,), rules=(Rule("x", 1.5, text),), rows=(text, text))


def drawn(text: str, *, interactive: bool) -> str:
    return page("Title", [Section("Run", [figure(graph(text), text)])], interactive=interactive)


@pytest.mark.parametrize("text", [HOSTILE, "$x^{$", "a$b$c", "--><b>", "&lt;b&gt;", '" id="a" onload="b'])
def test_a_text_in_a_drawn_figure_is_shown_and_nothing_else(text: str) -> None:
    html = drawn(text, interactive=False)
    said, plain = Parsed(html), Parsed(drawn("text", interactive=False))
    assert said.tags.count("text") == plain.tags.count("text") and said.texts.count(printable(text)) == 7
    names = {name for name, _ in said.attributes}
    assert set(said.tags) == set(plain.tags) and names == {name for name, _ in plain.attributes}
    assert not [name for name in names if name.startswith("on")] and "script" not in said.tags
    assert not re.search(r"[\x00-\x08\x0b-\x1f\x7f]", html)


def test_a_figure_ends_no_script_and_keeps_its_texts() -> None:
    html = drawn(HOSTILE, interactive=True)
    document = json.loads(html.partition('<script type="application/json">')[2].partition("</script>")[0])
    shown = plotly_text(HOSTILE)
    assert document["data"][0]["name"] == shown and document["data"][0]["text"] == [shown, shown]
    layout = document["layout"]
    assert {layout[f"{axis}axis"]["title"]["text"] for axis in "xy"} == {shown} == {*layout["yaxis"]["ticktext"]}
    assert layout["annotations"][0]["text"] == shown and document["data"][0]["hovertemplate"].count("<br>") == 1
    assert "<" not in shown and "\x1b" not in shown
    assert Parsed(html).tags.count("script") == 3


def test_a_page_runs_nothing_and_an_interactive_one_its_own_scripts_alone() -> None:
    """What a text could bring in would not know the nonce of the page, which is another for another text."""
    policies = []
    for text in ("one", "other"):
        still, moving = Parsed(drawn(text, interactive=False)), Parsed(drawn(text, interactive=True))
        assert "script" not in still.tags and loads_nothing(still)
        assert next(value for _, value in still.attributes if "default-src" in value) == (
            "default-src 'none'; style-src 'unsafe-inline'"
        )
        assert [value for name, value in moving.attributes if name == "src"] == [PLOTLY]
        policies += [value for _, value in moving.attributes if "default-src 'none'" in value]
        (nonce,) = {value for name, value in moving.attributes if name == "nonce"}
        assert f"script-src 'nonce-{nonce}';" in policies[-1] and "script-src 'unsafe" not in policies[-1]
    assert policies[0] != policies[1]


def test_colours_are_those_of_the_page() -> None:
    """A colour that the page gives no name to would not be seen on a dark one."""
    html = drawn("text", interactive=False)
    svg = html[html.index("<svg") : html.index("</svg>")]
    assert not re.search(r"#[0-9a-f]{6}\b|url\((?!#)", svg)
    named = set(re.findall(r"var\(--(\w+)\)", svg))
    assert {"ink", "grid", "blue"} <= named <= set(re.findall(r"--(\w+):", html))


def test_ids_within_a_page_are_what_figures_refer_to() -> None:
    said = Parsed(page("Title", [Section("Run", [figure(graph("a")), figure(graph("b"))])]))
    ids = {value for name, value in said.attributes if name == "id"}
    referred = [value for name, value in said.attributes if name in ("xlink:href", "clip-path")]
    assert ids == {re.sub(r"url\(#(\w+)\)|#", r"\1", value) for value in referred}


def test_the_script_is_written_once_beside_the_pages(tmp_path: Path) -> None:
    script, html = tmp_path / PLOTLY, drawn("text", interactive=True)
    write_page(tmp_path / "still.html", drawn("text", interactive=False))
    assert not script.exists()
    write_page(tmp_path / "a.html", html, interactive=True)
    first = script.stat()
    assert first.st_size > 1_000_000 > 10 * (tmp_path / "a.html").stat().st_size
    write_page(tmp_path / "b.html", html, interactive=True)
    assert script.stat().st_mtime_ns == first.st_mtime_ns and script.stat().st_ino == first.st_ino
    script.write_bytes(b"/**\n* plotly.js v0.0.1\n")
    prepare_page(tmp_path / "b.html", "-o", interactive=True)
    write_page(tmp_path / "b.html", html, interactive=True)
    assert script.stat().st_size == first.st_size


def test_a_file_of_this_name_that_is_no_script_of_plotly_stays(tmp_path: Path) -> None:
    (tmp_path / PLOTLY).write_text("mine")
    with pytest.raises(FileError, match=r"plotly\.min\.js is there already .* name another folder with --report"):
        prepare_page(tmp_path / "a.html", "--report", interactive=True)
    prepare_page(tmp_path / "a.html", "--report")


def test_beside_a_device_there_is_no_script(tmp_path: Path) -> None:
    (tmp_path / "out.html").symlink_to("/dev/null")
    prepare_page(tmp_path / "out.html", "-o")
    with pytest.raises(FileError, match=r"no file beside which plotly\.min\.js can be written"):
        prepare_page(tmp_path / "out.html", "-o", interactive=True)


def test_without_a_figure_there_is_no_script() -> None:
    html = page("Title", [Section("Text", [paragraph('class="plot"')])], interactive=True)
    assert len(html) < 10_000 and "script" not in Parsed(html).tags

"""The tools that make the documentation site."""

import io
import json
import sys
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from PIL import Image

from grind_env.control.facts import load_facts
from grind_env.process import equations

sys.path.insert(0, str(Path(__file__).parents[2] / "docs" / "tools"))

from commands import commands_page
from executed import as_page
from facts import facts_page
from formulas import formula
from latex2mathml.converter import convert
from links import broken
from pictures import lighter

from grind_env.cli import app

EQUATIONS = [name for name in equations.__all__ if callable(getattr(equations, name))]


@pytest.mark.parametrize(
    ("name", "latex"),
    [
        ("overlap_ratio", r"\frac{b_{\mathrm{d}}}{f_{\mathrm{d}}}"),
        ("fineness", r"\frac{0.25}{d_{\mathrm{g}}}"),
        ("chip_force", r"u_{\mathrm{ch}} \cdot Q \cdot {v_{\mathrm{s}}}^{-1}"),
        ("grit_roughness", r"R_{\mathrm{a}} \cdot z^{-0.7} \cdot s_{\mathrm{t}}^{-0.3}"),
    ],
)
def test_a_formula_is_that_of_the_code(name: str, latex: str) -> None:
    assert formula(getattr(equations, name)) == latex


@pytest.mark.parametrize("name", EQUATIONS)
def test_every_equation_has_a_formula_that_a_browser_can_draw(name: str) -> None:
    drawn = ElementTree.fromstring(convert(formula(getattr(equations, name))))
    texts = [element.text or "" for element in drawn.iter()]
    assert len(texts) > 3
    assert not [text for text in texts if "\\" in text or "_" in text], "commands or names that were not understood"


def test_links_that_lead_nowhere_are_found(tmp_path: Path) -> None:
    (tmp_path / "b.html").write_text('<h2 id="here">b</h2><a href="a.html">a</a>')
    (tmp_path / "a.html").write_text(
        '<a href="b.html#here">1</a><a href="b.html#there">2</a><a href="c.html">3</a><a href="#top">4</a>'
        '<img src="picture.png"><a href="https://example.com/x.html">5</a><p id="top"></p>'
    )
    assert broken(tmp_path) == ["a.html: b.html#there", "a.html: c.html", "a.html: picture.png"]


def test_the_page_of_facts_has_all_of_them() -> None:
    page = facts_page()
    rows = [line for line in page.splitlines() if line.startswith("| `")]
    assert len(rows) == len(load_facts())
    decided = sum(fact.mark == "decided" for fact in load_facts())
    assert sum("**DECIDED**" in row for row in rows) == decided and f"{decided} decided" in page


def test_the_page_of_commands_has_all_of_them() -> None:
    page = commands_page(app, "grind")
    for command in app.registered_commands:
        assert f"## `grind {command.callback.__name__.replace('_', '-')}`" in page
    assert "```console\n$ grind check slot.nc --json\n```" in page


def test_pieces_of_a_text_that_a_cell_prints_are_one() -> None:
    picture = {"output_type": "display_data", "data": {"image/png": "..."}, "metadata": {}}
    a, b, c = ({"output_type": "stream", "name": "stdout", "text": [text]} for text in ("a\n", "b", "c"))
    notebook = {"cells": [{"cell_type": "markdown"}, {"cell_type": "code", "outputs": [a, b, picture, c]}]}
    page = json.loads(as_page(json.dumps(notebook).encode()))
    assert page["cells"][1]["outputs"] == [{**a, "text": ["a\n", "b"]}, picture, c]


def test_a_picture_of_the_site_is_lighter_and_looks_the_same() -> None:
    """No colour of a drawing with few of them moves, and none of a smooth one by more than eyes see."""
    rng = np.random.default_rng(1)
    flat = np.repeat(np.repeat(rng.integers(0, 255, (10, 12, 3), np.uint8), 40, 0), 40, 1)
    smooth = np.stack(np.broadcast_arrays(np.arange(256)[:, None], np.arange(256)[None, :] // 2, 90), -1).astype(
        np.uint8
    )
    for pixels, most in ((flat, 0), (smooth, 24)):
        made = io.BytesIO()
        Image.fromarray(pixels).save(made, "PNG", compress_level=1)
        found = lighter(made.getvalue())
        shown = np.asarray(Image.open(io.BytesIO(found)).convert("RGB"))
        assert len(found) <= len(made.getvalue()) and lighter(found) == found
        assert np.abs(shown.astype(int) - pixels).max() <= most

"""The tools that make the documentation site."""

import inspect
import io
import math
import random
import re
import subprocess
import sys
from pathlib import Path
from tempfile import gettempdir
from xml.etree import ElementTree

import numpy as np
import pytest
from docutils import nodes
from docutils.utils import new_document
from PIL import Image

from grind_env.control.facts import load_facts
from grind_env.process import equations

sys.path.insert(0, str(Path(__file__).parents[2] / "docs" / "tools"))

from citation import bibtex, read_citation
from commands import commands_page
from facts import facts_page
from formulas import SYMBOLS, formula
from latex2mathml.converter import convert
from lean import lean
from links import broken
from pictures import lighter
from places import ROOT, anywhere
from shell_cells import unmarked
from shown import joined
from textbook import RESTATED

from grind_env.cli import app

EQUATIONS = [name for name, value in vars(equations).items() if callable(value)]


@pytest.mark.parametrize(
    ("name", "latex"),
    [
        ("overlap_ratio", r"U_{\mathrm{d}} = \frac{b_{\mathrm{d}}}{f_{\mathrm{d}}}"),
        ("fineness", r"z = \frac{0.25}{d_{\mathrm{g}}}"),
        ("chip_force", r"F'_{\mathrm{t,ch}} = \frac{u_{\mathrm{ch}} Q_{\mathrm{w}}'}{v_{\mathrm{s}}}"),
        ("grit_roughness", r"R_{\mathrm{a,z}} = R_{\mathrm{a}} z^{-0.7} s_{\mathrm{t}}^{-0.3}"),
        ("freshness", r"\varphi = \exp \left( -\frac{V_{\mathrm{w}}'}{V_{\mathrm{r}}} \right)"),
        ("restored_fraction", r"\eta_{\mathrm{d}} = 1 - \exp \left( -x_{\mathrm{d}} \right)"),
    ],
)
def test_a_formula_is_made_from_the_code_of_its_equation(name: str, latex: str) -> None:
    assert formula(getattr(equations, name)) == latex


def test_every_equation_has_a_formula_that_a_browser_can_draw() -> None:
    for name in EQUATIONS:
        drawn = ElementTree.fromstring(convert(formula(getattr(equations, name))))
        texts = [element.text or "" for element in drawn.iter()]
        assert len(texts) > 3, name
        assert not [text for text in texts if "\\" in text or "_" in text], f"{name}: commands were not understood"


def test_a_formula_has_the_symbols_of_textbooks() -> None:
    for name in EQUATIONS:
        text = formula(getattr(equations, name))
        first, _, rest = re.sub(r"\\begin\{array\}\{ll?\} ?", "", text).partition(" = ")
        assert first and rest and "per" not in text, name
        powers = re.findall(r"10\^\{(-?\d+)\}", text)
        assert all(int(power) >= -6 for power in powers), f"{name}: a number that only guards"
        bare = re.sub(r"_\{\\mathrm\{[a-z0-9,A-Z]{1,5}\}\}|\\mathrm\{(if|otherwise)\}|array|ll?\}", "", text)
        assert not re.findall(r"(?<![\\a-zA-Z])[a-zA-Z]{2,}", bare), f"{name}: names of the code"


def test_restated_equations_give_the_values_of_the_code() -> None:
    for name, stated in RESTATED.items():
        code, draw = getattr(equations, name), random.Random(1)
        for _ in range(200):
            given = [math.exp(draw.uniform(-3.0, 3.0)) for _ in inspect.signature(code).parameters]
            assert np.allclose(stated(*given), code(*given), rtol=1e-9), name


def test_every_symbol_stands_in_an_equation() -> None:
    assert set(SYMBOLS) == {"names", *EQUATIONS}
    for equation, names in SYMBOLS.items():
        functions = EQUATIONS if equation == "names" else [equation]
        text = " ".join(inspect.getsource(inspect.unwrap(getattr(equations, each))) for each in functions)
        unused = [name for name in names if name != "is" and not re.search(rf"\b(per_)?{name}\b", text)]
        assert not unused, equation


def test_broken_links_are_found(tmp_path: Path) -> None:
    (tmp_path / "b.html").write_text('<h2 id="here">b</h2><a href="a.html">a</a>')
    (tmp_path / "a.html").write_text(
        '<a href="b.html#here">1</a><a href="b.html#there">2</a><a href="c.html">3</a><a href="#top">4</a>'
        '<img src="picture.png"><a href="https://example.com/x.html">5</a><p id="top"></p>'
    )
    assert broken(tmp_path) == ["a.html: b.html#there", "a.html: c.html", "a.html: picture.png"]


def test_the_page_of_facts_lists_every_fact() -> None:
    page = facts_page()
    rows = [line for line in page.splitlines() if line.startswith("| `")]
    assert len(rows) == len(load_facts())
    decided = sum(fact.mark == "decided" for fact in load_facts())
    assert sum("**DECIDED**" in row for row in rows) == decided and f"{decided} decided" in page


def test_the_page_of_commands_lists_every_command() -> None:
    page = commands_page(app, "grind")
    for command in app.registered_commands:
        assert f"## `grind {command.callback.__name__.replace('_', '-')}`" in page
    assert "```console\n$ grind check slot.nc\n$ grind check slot.nc --job slot.toml --json\n```" in page


def test_consecutive_text_outputs_of_a_cell_are_joined() -> None:
    picture = {"output_type": "display_data", "data": {"image/png": "..."}, "metadata": {}}
    a, b, c = ({"output_type": "stream", "name": "stdout", "text": [text]} for text in ("a\n", "b", "c"))
    assert joined([a, b, picture, c]) == [{**a, "text": ["a\n", "b"]}, picture, c]


def test_a_picture_of_the_site_is_lighter_and_looks_the_same() -> None:
    """A drawing of few colours keeps them exactly; a smooth picture changes less than the eye sees."""
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


DOCS = Path(__file__).parents[2] / "docs"
SHELL = re.compile(r"^```(?:sh|\{code-cell\}\n%%bash)\n(.*?)^```$", re.DOTALL | re.MULTILINE)


def test_the_shell_blocks_of_a_page_are_bash() -> None:
    for path in DOCS.rglob("*.md"):
        text = "\n".join(SHELL.findall(path.read_text(encoding="utf-8")))
        read = subprocess.run(["bash", "-n"], input=text, text=True, capture_output=True, check=False)
        assert read.returncode == 0, f"{path}: {read.stderr}"


def test_shell_cells_are_shown_without_their_marker() -> None:
    page = new_document("page")
    page += [
        nodes.container("", nodes.literal_block("", text)) for text in ("%%bash\ngrind facts\n", "print('%%bash')")
    ]
    unmarked(page)
    shell, python = page.findall(nodes.literal_block)
    assert (shell.rawsource, shell.astext(), shell["language"]) == ("grind facts\n", "grind facts\n", "bash")
    assert shell.parent["classes"] == ["shell"] and python.parent["classes"] == []


def test_paths_of_the_build_machine_are_replaced() -> None:
    text = f"{ROOT}/runs] {Path.home()}/.cache/grind_env) in {gettempdir()}/tmpab_1 https://example.com{ROOT}/x"
    assert anywhere(text) == f"runs] ~/.cache/grind_env) in /tmp/... https://example.com{ROOT}/x"


def test_bibtex_follows_from_the_citation_file() -> None:
    root = DOCS.parent
    cited = read_citation(root / "CITATION.cff")
    entry = bibtex(cited, (root / "LICENSE").read_text(encoding="utf-8"))
    assert cited["title"].replace("_", r"\_") in entry and cited["version"] in entry and "year = {2026}" in entry
    assert "year = {2031}" in bibtex({**cited, "date-released": "2031-02-03"}, "Copyright (c) 2026")
    authors = [{"family-names": "Doe", "given-names": "Jo"}, {"name": "A Group"}]
    assert "{Doe, Jo and {A Group}}" in bibtex({**cited, "authors": authors}, "Copyright (c) 2026")


def test_a_lean_page_keeps_the_text() -> None:
    name = '<span class="n"><span class="pre">x</span></span><span class="pre">&lt;int&gt;</span>'
    page = f'<p>{name}</p><dt class="sig sig-object py" id="x">{name}</dt><dt class="field-odd">{name}</dt>'
    made = lean(page)
    assert re.sub("<[^>]+>", "", made) == re.sub("<[^>]+>", "", page)
    assert made.count('class="pre"') == page.count('class="pre"') - 2

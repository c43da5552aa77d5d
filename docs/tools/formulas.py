"""Sphinx extension: the equations of the process as formulas, from their code, drawn by the browser without a script.

`latexify` turns the code of a function into LaTeX, so that what a page shows is what the simulation runs, and
`latex2mathml` turns LaTeX into MathML, which needs neither network nor JavaScript.
"""

import inspect
import re
from typing import Any

import latexify
from docutils import nodes
from latex2mathml.converter import convert
from sphinx.application import Sphinx

from grind_env.process import equations

NAME = re.compile(r"\\mathrm\{((?:[^{}\\]|\\_)+)\}")
SYMBOL = re.compile(r"[A-Za-z][A-Z]?[a-z]?\d?|[A-Za-z]+(ref|max|film)|alw0?|krw")
"""Names that are one letter and its index."""
GREEK = {"lam": r"\lambda", "beta": r"\beta"}
KEPT = ("by", "if", "max", "min", "per")
"""Words that look like symbols."""
NUMBER = re.compile(r"(?<![\w.])\d+(?:\.\d+)?(?:e[+-]?\d+)?(?![\w.])")
FACTOR = r"(?:[A-Za-z]|\\mathrm\{\w+\})(?:_\{\\mathrm\{[\w,]+\}\})?"
SQUARE = re.compile(rf"(?<![\w}}])({FACTOR})(?: \\cdot)? \1(?![\w_])")
WRAPPED = re.compile(r"\\mathrm\{float\} \\left\( (.*) \\right\)$")


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the renderer and the formulas."""
    app.add_html_math_renderer("mathml", inline_renderers=(_inline, None), block_renderers=(_block, None))
    app.config["html_math_renderer"] = "mathml"
    app.connect("autodoc-process-docstring", _insert)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def formula(function: Any) -> str:
    """LaTeX of a function of scalars: its symbols with their indices, constants as numbers."""
    plain = inspect.unwrap(function)
    text = latexify.get_latex(plain, use_math_symbols=True, identifiers={"power": "pow"})
    text = text.replace(r"\mathopen{}", "").replace(r"\mathclose{}", "")
    text = re.sub(rf"{re.escape(_word(plain.__name__))}\([^()]*\) = ", "", text).replace(r"\mathrm{math}.\pi", r"\pi ")
    constants = {name: value for name, value in plain.__globals__.items() if isinstance(value, float)}
    text = NUMBER.sub(lambda match: _number(float(match[0])), WRAPPED.sub(r"\1", text))
    text = NAME.sub(lambda match: _symbol(match[1].replace(r"\_", "_"), constants), text)
    return SQUARE.sub(r"{\1}^{2}", text)


def _symbol(name: str, constants: dict[str, float]) -> str:
    if name in constants:
        return _number(constants[name])
    if name in GREEK:
        return GREEK[name]
    if name.startswith("per_"):
        return rf"{{{_symbol(name[4:], constants)}}}^{{-1}}"
    head, _, index = name.partition("_")
    if head not in KEPT and len(head) > 1 and SYMBOL.fullmatch(head):
        head, index = head[0], ",".join(filter(None, (head[1:], index)))
    base = GREEK.get(head) or (head if len(head) == 1 else rf"\mathrm{{{head}}}")
    return rf"{base}_{{\mathrm{{{index.replace('_', ',')}}}}}" if index else base


def _word(name: str) -> str:
    return rf"\mathrm{{{name.replace('_', chr(92) + '_')}}}"


def _number(value: float) -> str:
    mantissa, _, exponent = f"{value:g}".partition("e")
    power = rf"10^{{{int(exponent)}}}" if exponent else ""
    return rf"{mantissa} \cdot {power}" if power and mantissa != "1" else power or mantissa


def _insert(_app: Sphinx, what: str, name: str, value: Any, _options: Any, lines: list[str]) -> None:
    """Put the formula of an equation below the first paragraph of its docstring."""
    if what == "function" and getattr(equations, name.rpartition(".")[2], None) is value:
        place = lines.index("") if "" in lines else len(lines)
        lines[place:place] = ["", ".. math::", "", *(f"   {line}" for line in formula(value).splitlines()), ""]


def _inline(translator: Any, node: nodes.math) -> None:
    translator.body.append(convert(node.astext()))
    raise nodes.SkipNode


def _block(translator: Any, node: nodes.math_block) -> None:
    translator.body.append(f'<div class="math">{convert(node.astext(), display="block")}</div>')
    raise nodes.SkipNode

"""Sphinx extension: formulas of the equations of the process, made from their code.

`latexify` turns expressions of the code into LaTeX, so that a page shows the equations that the simulation computes.
Symbols come from `symbols.toml`. `latex2mathml` makes MathML, which needs neither network nor JavaScript.
"""

import ast
import inspect
import re
from pathlib import Path
from typing import Any

from docutils import nodes
from latex2mathml.converter import convert
from latexify.codegen.expression_codegen import ExpressionCodegen
from sphinx.application import Sphinx
from textbook import keeps_finite, lines

from grind_env.process import equations
from grind_env.toml import read_toml

SYMBOLS = read_toml(Path(__file__).parent / "symbols.toml")
EQUATIONS = frozenset(name for name, value in vars(equations).items() if callable(value))
#: pattern of a name that is one letter with an index
INDEXED = re.compile(r"([A-Za-z])(?:_([a-z]+)|([A-Z]?[a-z]?\d?|max))$")
INDEX = re.compile(r"_(?:(\w)|\{([\w,]+)\})")
LN = r"\ln "
SPACE = r" \\, "
DOTS = re.compile(r" \\cdot (?!\d)")


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the renderer and the formulas."""
    app.add_html_math_renderer("mathml", inline_renderers=(_inline, None), block_renderers=(_block, None))
    app.config["html_math_renderer"] = "mathml"
    app.connect("autodoc-process-docstring", _insert)
    app.connect("autodoc-skip-member", _hide_guard)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def formula(function: Any) -> str:
    """Return the LaTeX of a function of scalars: a line for each intermediate value, and then the results."""
    name = inspect.unwrap(function).__name__
    results = map(_upright, SYMBOLS[name]["is"])
    write = _Writer(name)
    found = [
        f"{next(results) if left is None else write.visit(left)} = {DOTS.sub(SPACE, write.visit(right))}"
        for left, right in lines(function, EQUATIONS)
    ]
    return found[0] if len(found) == 1 else r"\begin{array}{l} " + r" \\ ".join(found) + r" \end{array}"


def words(function: Any) -> dict[str, str]:
    """Return the symbols of the arguments whose symbol does not follow from their name."""
    plain = inspect.unwrap(function)
    found = {name: symbol(name.removeprefix("per_"), plain.__name__) for name in inspect.signature(plain).parameters}
    return {name: text for name, text in found.items() if text != _indexed(name.removeprefix("per_"))}


def symbol(name: str, equation: str) -> str:
    """Return the LaTeX of a name in an equation: a quantity, or the result of another equation."""
    if name in EQUATIONS:
        return _upright(SYMBOLS[name]["is"][0])
    given = SYMBOLS[equation].get(name) or SYMBOLS["names"].get(name)
    return _upright(given) if given else _indexed(name)


def _indexed(name: str) -> str:
    match = INDEXED.match(name)
    return _upright(f"{match[1]}_{{{match[2] or match[3]}}}" if match and len(name) > 1 else name)


def _upright(text: str) -> str:
    return INDEX.sub(lambda match: rf"_{{\mathrm{{{match[1] or match[2]}}}}}", text)


class _Writer(ExpressionCodegen):
    """Writer of LaTeX with symbols for names and readable numbers."""

    def __init__(self, equation: str) -> None:
        super().__init__(use_math_symbols=True)
        self.equation = equation

    def visit_Name(self, node: ast.Name) -> str:
        if node.id in ("min", "max"):
            return rf"\{node.id}"
        return r"\pi" if node.id == "pi" else symbol(node.id, self.equation)

    def visit_Constant(self, node: ast.Constant) -> str:
        mantissa, _, exponent = f"{node.value:g}".partition("e")
        power = rf"10^{{{int(exponent)}}}" if exponent else ""
        return rf"{mantissa} \cdot {power}" if power and mantissa != "1" else power or mantissa

    def visit_UnaryOp(self, node: ast.UnaryOp) -> str:
        fraction = isinstance(node.operand, ast.BinOp) and isinstance(node.operand.op, ast.Div)
        return f"-{self.visit(node.operand)}" if fraction else super().visit_UnaryOp(node)

    def visit_Call(self, node: ast.Call) -> str:
        first = self.visit(node.args[0])
        if node.func.id == "exp" and first.startswith(LN):
            return first.removeprefix(LN)
        text = super().visit_Call(node).replace(r"\mathopen{}", "").replace(r"\mathclose{}", "")
        return rf"\ln{text.removeprefix(chr(92) + 'log')}" if node.func.id == "log" else text

    def visit_BinOp(self, node: ast.BinOp) -> str:
        return super().visit_BinOp(node).replace(r"\mathopen{}", "").replace(r"\mathclose{}", "")


def _insert(_app: Sphinx, what: str, name: str, value: Any, _options: Any, lines: list[str]) -> None:
    """Put formula and symbols of an equation below the first paragraph of its docstring."""
    if what == "function" and getattr(equations, name.rpartition(".")[2], None) is value:
        place = lines.index("") if "" in lines else len(lines)
        known = ", ".join(f":math:`{text}` = {_code(argument)}" for argument, text in words(value).items())
        told = [f"Symbols: {known}.", ""] if known else []
        lines[place:place] = ["", ".. math::", "", f"   {formula(value)}", "", *told]


def _hide_guard(_app: Sphinx, _what: str, _name: str, value: Any, _skip: bool, _options: Any) -> bool | None:
    """Hide constants that only keep quotients finite, as the formulas do."""
    return True if isinstance(value, float) and keeps_finite(value) else None


def _code(argument: str) -> str:
    return f"1/``{argument}``" if argument.startswith("per_") else f"``{argument}``"


def _inline(translator: Any, node: nodes.math) -> None:
    translator.body.append(convert(node.astext()))
    raise nodes.SkipNode


def _block(translator: Any, node: nodes.math_block) -> None:
    translator.body.append(f'<div class="math">{convert(node.astext(), display="block")}</div>')
    raise nodes.SkipNode

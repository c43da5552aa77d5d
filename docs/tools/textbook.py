"""Equations as a textbook has them: what the code does only to be fast or never to divide by nothing is undone.

A product with `per_x` is a quotient by x, a factor that stands twice is a power, `power(a, b)` is one, too, a call of
another equation is its symbol. Left out is what keeps a quotient or a logarithm a number, and what is said of nothing
(`0 where nothing is cut`). What is computed in another order is restated below; a test holds it to the code.
"""

import ast
import inspect
import math
from collections.abc import Callable, Iterator
from textwrap import dedent
from typing import Any

GUARD = 1e-6
"""Beside a sum or as the least that a number may be, what is no larger only keeps quotients numbers."""
PER = "per_"
Line = tuple[ast.expr | None, ast.expr]
"""What is on the left, None of the result, and on the right."""


def temperature(heat: float, work: float, film: float, kfilm: float, Tb: float) -> float:
    """`equations.temperature`, whose quotients the code takes together."""
    wet = 1e6 * heat / (work + film)
    dry = 1e6 * heat / (work + kfilm * film)
    y = min(max((wet - Tb) / 20.0 + 0.5, 0.0), 1.0)
    return wet + (dry - wet) * y**2 * (3.0 - 2.0 * y)


def conductances(
    lc: float, vw: float, beta: float, jaeger: float, A: float, vs: float, krw: float
) -> tuple[float, float]:
    """`equations.conductances`."""
    return beta * math.sqrt(vw * lc / jaeger), krw / math.sqrt((1.0 + 20.8 * A) * vs)


def slowing(free: float, rubbing: float, rs: float) -> tuple[float, float]:
    """`equations.slowing`."""
    return min(max(free / rubbing, rs), 1.0), min(max(rubbing / free, 1.0), 1.0 / rs)


def early_wear(loss: float, V: float, dV: float, per_Vi: float) -> float:
    """`equations.early_wear`, as the difference of what is left before and after."""
    return loss * (1.0 / (1.0 + V * per_Vi) ** 2 - 1.0 / (1.0 + (V + dV) * per_Vi) ** 2)


RESTATED: dict[str, Callable[..., Any]] = {
    each.__name__: each for each in (temperature, conductances, slowing, early_wear)
}


def lines(function: Any, equations: frozenset[str]) -> Iterator[Line]:
    """Left and right of each line of an equation; the last ones, those of its results, have no left.

    Args:
        function: of scalars, whose body assigns and returns.
        equations: names of all of them.
    """
    plain = inspect.unwrap(function)
    constants = {name: value for name, value in plain.__globals__.items() if isinstance(value, float)}
    (definition,) = ast.parse(dedent(inspect.getsource(RESTATED.get(plain.__name__, plain)))).body
    undo = _Undo(constants, equations)
    for statement in definition.body:
        if isinstance(statement, ast.Assign):
            yield from zip(_each(statement.targets[0]), map(undo.visit, _each(statement.value)), strict=True)
        elif isinstance(statement, ast.Return) and statement.value is not None:
            yield from ((None, undo.visit(value)) for value in _each(statement.value))


def _each(node: ast.expr) -> list[ast.expr]:
    return node.elts if isinstance(node, ast.Tuple) else [node]


class _Undo(ast.NodeTransformer):
    def __init__(self, constants: dict[str, float], equations: frozenset[str]) -> None:
        self.constants, self.equations = constants, equations

    def visit_Name(self, node: ast.Name) -> ast.expr:
        return ast.Constant(self.constants[node.id]) if node.id in self.constants else node

    def visit_Attribute(self, node: ast.Attribute) -> ast.expr:
        return ast.Name(node.attr)

    def visit_IfExp(self, node: ast.IfExp) -> ast.expr:
        return self.visit(node.body) if isinstance(node.orelse, ast.Constant) else self.generic_visit(node)

    def visit_Call(self, node: ast.Call) -> ast.expr:
        name = node.func.id if isinstance(node.func, ast.Name) else node.func.attr
        if name in self.equations:
            return ast.Name(name)
        given = [self.visit(each) for each in node.args]
        if name == "float":
            return given[0]
        if name == "power":
            return ast.BinOp(given[0], ast.Pow(), given[1])
        if name == "sqrt" and isinstance(given[0], ast.Call) and given[0].func.id == "sqrt":
            return ast.BinOp(given[0].args[0], ast.Pow(), ast.BinOp(ast.Constant(1), ast.Div(), ast.Constant(4)))
        if name == "max":
            inner = [each.args if isinstance(each, ast.Call) and each.func.id == "max" else [each] for each in given]
            given = [each for args in inner for each in args if not _guard(each)]
            if len(given) == 1:
                return given[0]
        return ast.Call(ast.Name(name), given, [])

    def visit_BinOp(self, node: ast.BinOp) -> ast.expr:
        if isinstance(node.op, ast.Mult | ast.Div):
            return self._quotient(node)
        left, right = self.visit(node.left), self.visit(node.right)
        if isinstance(node.op, ast.Add) and _guard(right):
            return left
        return ast.BinOp(left, node.op, right)

    def _quotient(self, node: ast.BinOp) -> ast.expr:
        above, below = list[ast.expr](), list[ast.expr]()
        self._factors(node, above, below)
        negative = bool(above) and isinstance(above[0], ast.UnaryOp)
        if negative:
            above[0] = above[0].operand
        found = _product(above)
        if below:
            found = ast.BinOp(found, ast.Div(), _product(below))
        return ast.UnaryOp(ast.USub(), found) if negative else found

    def _factors(self, node: ast.expr, above: list[ast.expr], below: list[ast.expr]) -> None:
        if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Mult | ast.Div):
            self._factors(node.left, above, below)
            turned = isinstance(node.op, ast.Div)
            self._factors(node.right, *((below, above) if turned else (above, below)))
        elif isinstance(node, ast.Name) and node.id.startswith(PER):
            below.append(ast.Name(node.id.removeprefix(PER)))
        elif not (isinstance(node, ast.Constant) and node.value == 1.0):
            above.append(self.visit(node))


def _product(factors: list[ast.expr]) -> ast.expr:
    """The product, each factor once, with its power."""
    found: ast.expr | None = None
    texts = [ast.dump(each) for each in factors]
    for place, (text, each) in enumerate(zip(texts, factors, strict=True)):
        if text in texts[:place]:
            continue
        count = texts.count(text)
        term = each if count == 1 else ast.BinOp(each, ast.Pow(), ast.Constant(count))
        found = term if found is None else ast.BinOp(found, ast.Mult(), term)
    return found or ast.Constant(1)


def keeps_finite(value: float) -> bool:
    """Whether a number of the code is there only so that no quotient and no logarithm is of nothing."""
    return 0.0 < value <= GUARD


def _guard(node: ast.expr) -> bool:
    return isinstance(node, ast.Constant) and keeps_finite(node.value)

"""Equations as in a textbook, without the parts of the code that only save time or avoid a division by zero.

A product with `per_x` becomes a quotient by x, a repeated factor and `power(a, b)` become powers, and a call of another
equation becomes its symbol. Guards of quotients and logarithms are left out, and so are special cases such as 0 without
a cut. Equations that the code computes in another order are restated below; a test compares them with the code.
"""

import ast
import inspect
import math
from collections.abc import Callable, Iterator
from textwrap import dedent
from typing import Any

GUARD = 1e-6  #: largest constant that counts as a guard, in a sum or as a lower bound
PER = "per_"
Line = tuple[ast.expr | None, ast.expr]  #: left side (None for a result) and right side


def temperature(heat: float, work: float, film: float, kfilm: float, Tb: float) -> float:
    """Restate `equations.temperature`, whose quotients the code combines."""
    wet = 1e6 * heat / (work + film)
    dry = 1e6 * heat / (work + kfilm * film)
    y = min(max((wet - Tb) / 20.0 + 0.5, 0.0), 1.0)
    return wet + (dry - wet) * y**2 * (3.0 - 2.0 * y)


def conductances(
    lc: float, vw: float, beta: float, jaeger: float, A: float, vs: float, krw: float
) -> tuple[float, float]:
    """Restate `equations.conductances`."""
    return beta * math.sqrt(vw * lc / jaeger), krw / math.sqrt((1.0 + 20.8 * A) * vs)


def slowing(free: float, rubbing: float, rs: float) -> tuple[float, float]:
    """Restate `equations.slowing`."""
    return min(max(free / rubbing, rs), 1.0), min(max(rubbing / free, 1.0), 1.0 / rs)


def early_wear(loss: float, V: float, dV: float, per_Vi: float) -> float:
    """Restate `equations.early_wear` as a difference between before and after."""
    return loss * (1.0 / (1.0 + V * per_Vi) ** 2 - 1.0 / (1.0 + (V + dV) * per_Vi) ** 2)


RESTATED: dict[str, Callable[..., Any]] = {
    each.__name__: each for each in (temperature, conductances, slowing, early_wear)
}


def lines(function: Any, equations: frozenset[str]) -> Iterator[Line]:
    """Yield both sides of each line of an equation; the last lines, the results, have no left side.

    Args:
        function: function of scalars whose body only assigns and returns.
        equations: names of all equations.
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
    """Return the product with each factor once, as a power if it is repeated."""
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
    """Return whether a constant only keeps quotients and logarithms finite."""
    return 0.0 < value <= GUARD


def _guard(node: ast.expr) -> bool:
    return isinstance(node, ast.Constant) and keeps_finite(node.value)

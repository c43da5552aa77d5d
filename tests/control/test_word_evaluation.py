from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from grind_env.control import numbers
from grind_env.control.block_words import Block, read_block
from grind_env.control.errors import ControlError
from grind_env.control.macro_variables import Foreseen, Variables
from grind_env.control.numbers import NumberFormat
from grind_env.control.program_reader import read
from grind_env.control.word_evaluation import evaluated

VARIABLES = Variables({1: 2.0, 2: 0.1, 3: 0.2, 4: 1e-7, 12: -3.5, 100: 84.1}, Foreseen())


def block_of(text: str) -> Block:
    (source,) = read(text).main.blocks
    return read_block(source)


def written(text: str) -> str:
    """Return the value of the only word, as sign, digits and point."""
    (word,) = evaluated(block_of(text), VARIABLES).words
    assert word.point
    return f"{word.sign}{word.whole}.{word.decimals}"


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("X[#12+6]", "2.5"),
        ("X#12", "-3.5"),
        ("X-#12", "3.5"),
        ("X+#1", "2."),
        ("X[#1*[#2-3]/4]", "-1.45"),
        ("X-[1--2]", "-3."),
        ("X#[#1*50]", "84.1"),
        ("X[ 1 2 + # 1 2 ]", "8.5"),
        ("X[#2+#3]", "0.3"),
        ("X[#2*100000000000-10000000000]", "0."),
        ("X[0" + "+[1]" * 30 + "]", "30."),
        ("X[1." + "0" * 29 + "+0]", "1."),
        ("X[1/3*3]", "1."),
        ("X[2/3]", "0.6666666667"),
        ("X#4", "0.0000001"),
        ("X[#4/10000]", "0."),
        ("X[-0]", "0."),
        ("X" + "[" * 20 + "1" + "]" * 20, "1."),
    ],
)
def test_expressions_are_evaluated_to_ten_decimals(text: str, value: str) -> None:
    assert written(text) == value


def test_g_codes_are_exact_and_count_as_written_with_a_point() -> None:
    trailing = NumberFormat("trailing")
    for text, code in (("G[#1]", "G02"), ("G[84+.1]", "G84.1"), ("G#100", "G84.1"), ("G[92]", "G92")):
        block = evaluated(block_of(text), VARIABLES)
        assert numbers.g_code(block, block.words[0], trailing) == code
    block = evaluated(block_of("X[123]"), VARIABLES)
    for suppression in ("neither", "leading", "trailing"):
        assert numbers.length(block, block.words[0], False, NumberFormat(suppression)) == 123.0


def test_integers_and_tool_numbers_may_be_expressions() -> None:
    block = evaluated(block_of("D[#1+1] L[#2+#2] T[100+#1]"), VARIABLES)
    dresses, spark_out, tool = block.words
    assert numbers.integer(block, dresses, 0, 9) == 3
    assert numbers.tool_numbers(block, tool) == (1, 2)
    with pytest.raises(ControlError, match=r"^program:1:9: L\[#2\+#2\] is not an integer"):
        numbers.integer(block, spark_out, 0, 9)


def test_only_expressions_are_replaced() -> None:
    block = block_of("N7 G01 X[#1] Y-3.20 (SEE #5 [6]) F[100]")
    found = evaluated(block, VARIABLES)
    assert [str(word) for word in found.words] == ["G01", "X[#1]", "Y-3.20", "F[100]"]
    assert (found.source, found.place) == (block.source, block.place)
    assert (found.words[0], found.words[2]) == (block.words[0], block.words[2])
    assert [word.column for word in found.words] == [word.column for word in block.words]
    assert evaluated(found, VARIABLES) is found


@pytest.mark.parametrize("text", ["G01 X5.", "(#1 [2]) X1", "M30"])
def test_a_block_without_expressions_is_the_same_object(text: str) -> None:
    block = block_of(text)
    assert evaluated(block, VARIABLES) is block


tree = st.recursive(
    st.integers(0, 99_999).map(lambda n: (f"{n // 100}.{n % 100:02d}", Fraction(n, 100)))
    | st.sampled_from([("#1", Fraction(2)), ("#12", Fraction(-7, 2)), ("#[1+#1*49.5]", Fraction(841, 10))]),
    lambda inner: st.tuples(inner, st.sampled_from("+-*/"), inner, st.sampled_from(["", "-", "+"])),
    max_leaves=8,
)


def written_and_exact(node: tuple) -> tuple[str, Fraction | None]:
    """Return an expression with every operation in brackets, and its exact value; None for a division by 0."""
    if len(node) == 2:
        return node
    (left, a), operator, (right, b), sign = written_and_exact(node[0]), node[1], written_and_exact(node[2]), node[3]
    text = (
        f"{sign}[{left}{operator}{right}]" if not left.startswith(("+", "-")) else f"{sign}[{left} {operator} {right}]"
    )
    if a is None or b is None or (operator == "/" and b == 0):
        return text, None
    value = {"+": a + b, "-": a - b, "*": a * b, "/": a / b if b else a}[operator]
    return text, -value if sign == "-" else value


@given(tree)
def test_values_agree_with_exact_fractions(node: tuple) -> None:
    text, exact = written_and_exact(node)
    block = block_of(f"X[{text}]")
    if exact is None:
        with pytest.raises(ControlError, match="divided by 0"):
            evaluated(block, VARIABLES)
        return
    (word,) = evaluated(block, VARIABLES).words
    found = Fraction(f"{word.sign}{word.whole}.{word.decimals or '0'}")
    assert abs(found - exact) <= Fraction(1, 2 * 10**10) + abs(exact) / 10**30


@pytest.mark.parametrize(
    ("text", "column"),
    [("X[]", 3), ("X[1+]", 5), ("X[--1]", 4), ("X[1+[2*]]", 8), ("X[1.2.3]", 6), ("X[1,2]", 4), ("X[1(A)]", 4)],
)
def test_refusals_name_the_column_within_the_expression(text: str, column: int) -> None:
    with pytest.raises(ControlError) as caught:
        evaluated(block_of(text), VARIABLES)
    assert (caught.value.name, caught.value.column) == ("expression", column)


@pytest.mark.parametrize(("text", "name"), [("X[SINE[30]]", "SINE"), ("X[#1 DIV 2]", "DIV"), ("X[1E3]", "E")])
def test_unknown_names_are_not_supported(text: str, name: str) -> None:
    with pytest.raises(ControlError, match=f"{name} is no part of an expression here") as caught:
        evaluated(block_of(text), VARIABLES)
    assert caught.value.name == "not-supported"

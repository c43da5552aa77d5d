import pytest

from grind_env.control import numbers
from grind_env.control.block_words import Block, read_block
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


def test_only_expressions_are_replaced() -> None:
    block = block_of("N7 G01 X[#1] Y-3.20 (SEE #5 [6]) F[100]")
    found = evaluated(block, VARIABLES)
    assert [str(word) for word in found.words] == ["G01", "X[#1]", "Y-3.20", "F[100]"]
    assert (found.source, found.place) == (block.source, block.place)
    assert (found.words[0], found.words[2]) == (block.words[0], block.words[2])
    assert [word.column for word in found.words] == [word.column for word in block.words]
    assert evaluated(found, VARIABLES) is found

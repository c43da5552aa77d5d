from decimal import Decimal
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from grind_env.control import Message, execute, numbers
from grind_env.control.block_words import Block, Word, read_block
from grind_env.control.errors import ControlError
from grind_env.control.numbers import NumberFormat
from grind_env.control.program_reader import read

SUPPRESSIONS = ("neither", "leading", "trailing")


def read_word(text: str) -> tuple[Block, Word]:
    (source,) = read(text).main.blocks
    block = read_block(source)
    (word,) = block.words
    return block, word


def length(text: str, form: NumberFormat, inch: bool = False) -> float:
    return numbers.length(*read_word(text), inch, form)


def refusal(text: str, form: NumberFormat) -> ControlError:
    with pytest.raises(ControlError) as caught:
        length(text, form)
    return caught.value


TABLE_10_A = """
    X123456.   ERROR     ERROR     ERROR
    X12345.6   12345.60  12345.60  12345.60
    X1234.56   1234.56   1234.56   1234.56
    X123.456   123.45    123.45    123.45
    X12345     12345.00  123.45    12345.00
    X012345    ERROR     123.45    1234.50
    X123456    ERROR     1234.56   12345.60
    X1234567   ERROR     12345.67  12345.67
    X12345678  ERROR     ERROR     ERROR
"""
ROWS = [
    (row.split()[0], suppression, value)
    for row in TABLE_10_A.strip().splitlines()
    for suppression, value in zip(SUPPRESSIONS, row.split()[1:], strict=True)
]


@pytest.mark.parametrize(("word", "suppression", "value"), ROWS)
def test_length_words_follow_table_10_a(word: str, suppression: str, value: str) -> None:
    form = NumberFormat(zero_suppression=suppression, metric=(5, 2))
    if value == "ERROR":
        error = refusal(word, form)
        assert (error.name, error.column) == ("number-format", 1)
    else:
        assert length(word, form) == float(value)
        assert length(word.replace("X", "X-"), form) == -float(value)


@pytest.mark.parametrize(
    ("word", "leading", "trailing"),
    [
        ("G02", "G02", "G02"),
        ("G2", "G02", "G20"),
        ("G2.", "G02", "G02"),
        ("G92", "G92", "G92"),
        ("G920", "G920", "G92"),
        ("G92.1", "G92.1", "G92.1"),
        ("G921", "G921", "G92.1"),
        ("G0", "G00", "G00"),
    ],
)
def test_g_codes_are_read_under_each_zero_suppression(word: str, leading: str, trailing: str) -> None:
    block, g = read_word(word)
    codes = [numbers.g_code(block, g, NumberFormat(zero_suppression=each)) for each in SUPPRESSIONS]
    assert codes == [leading, leading, trailing]


digits = st.tuples(st.integers(1, 9), st.integers(0, 9))


@given(digits, st.integers(0, 10**12), st.integers(0, 12))
def test_excess_decimals_are_cut_or_rounded(form: tuple[int, int], number: int, places: int) -> None:
    whole, decimals = form
    exact = Fraction(number, 10**places) % 10**whole
    text = f"{Decimal(exact.numerator) / Decimal(exact.denominator):.{places}f}"
    unit = Fraction(1, 10**decimals)
    cut = exact // unit * unit
    rounded = (exact + unit / 2) // unit * unit
    word = f"X{text}" if "." in text else f"X{text}."
    assert length(word, NumberFormat(metric=form)) == float(cut)
    assert length(f"X-{word[1:]}", NumberFormat(metric=form)) == -float(cut)
    rounding = NumberFormat(metric=form, excess_decimals="round")
    if rounded < 10**whole:
        assert length(word, rounding) == float(rounded)
        assert length(f"X-{word[1:]}", rounding) == -float(rounded)
    else:
        assert refusal(word, rounding).name == "number-format"


def test_inch_words_have_their_own_format() -> None:
    assert length("X1234", NumberFormat("leading", inch=(2, 4)), inch=True) == pytest.approx(0.1234 * 25.4)
    assert length("X1234", NumberFormat("trailing", inch=(2, 4)), inch=True) == pytest.approx(12.34 * 25.4)
    assert length("X.12345", NumberFormat(excess_decimals="round"), inch=True) == pytest.approx(0.1235 * 25.4)
    assert length("X.3", NumberFormat(), inch=True) == 7.62
    assert refusal("X12345.", NumberFormat(metric=(4, 4))).message.endswith("4 are allowed")


def test_feeds_and_speeds_have_the_format_of_lengths() -> None:
    leading = NumberFormat("leading")
    assert numbers.feed(*read_word("F100"), False, leading) == 0.1
    assert numbers.plain(*read_word("S1000"), leading) == 1.0
    assert numbers.plain(*read_word("S1000."), leading) == 1000.0
    assert numbers.feed(*read_word("F.0006"), False, NumberFormat(excess_decimals="round")) == 0.001
    for word, form, least in (
        ("F.0006", NumberFormat(), "0.001"),
        ("F.5", NumberFormat(metric=(5, 0)), "1"),
        ("F0.", NumberFormat(metric=(5, 9)), "0.000000001"),
        ("F-1.", NumberFormat(), "0.001"),
    ):
        with pytest.raises(ControlError, match=f"it must be {least} or more") as caught:
            numbers.feed(*read_word(word), False, form)
        assert caught.value.name == "out-of-range"
    with pytest.raises(ControlError, match=r"it must be 0\.0001 or more"):
        numbers.feed(*read_word("F.00001"), True)


@pytest.mark.parametrize(
    ("word", "radius", "length_entry"),
    [("T1", 1, 1), ("T01", 1, 1), ("T33", 33, 33), ("T105", 1, 5), ("T0105", 1, 5), ("T3307", 33, 7), ("T0000", 0, 0)],
)
def test_t_words_give_the_radius_and_length_entries(word: str, radius: int, length_entry: int) -> None:
    assert numbers.tool_numbers(*read_word(word)) == (radius, length_entry)


def test_an_unevaluated_expression_is_refused() -> None:
    for text, reading in (("G[0]", numbers.g_code), ("S[0]", numbers.plain), ("T#1", numbers.tool_numbers)):
        with pytest.raises(ControlError, match="has a paramacro value"):
            reading(*read_word(text))


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ("G71 G00 X1.2345", "line 1: X1.2345 has more decimals than are read, and is taken for X1.234"),
        ("G70 G00 X-.12345", "line 1: X-.12345 has more decimals than are read, and is taken for X-0.1234"),
        ("G71 G01 X1.5000000 F100.00", None),
        ("G70 G00 X.1234", None),
        ("G71 G00 X[1/3] Y-[2/3]", None),
        ("G71 G00 X[1/3] Y 1.2345", "line 1: Y1.2345 has more decimals than are read, and is taken for Y1.234"),
    ],
)
def test_cut_decimals_are_reported(words: str, told: str | None) -> None:
    messages = [event.text for event in execute(read(f"{words}\nM30\n")) if isinstance(event, Message)]
    assert messages == ([] if told is None else [told])

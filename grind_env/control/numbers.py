"""Numbers of words by the formats of their addresses (lathe manual 10-17, setting "neither").

Decimal arithmetic on the text keeps 0.3 what it is until the value is complete; decimals in excess of the
format are cut off, and without a decimal point a number means whole units.
"""

from decimal import Decimal

from grind_env.control.reader import Block, Word

MILLIMETRES_PER_INCH = Decimal("25.4")
METRIC_DIGITS = (5, 3)
"""Integer digits and decimals of a metric length or feed."""
INCH_DIGITS = (4, 4)


def length(block: Block, word: Word, inch: bool) -> float:
    """A coordinate or pick in mm, or a feed in mm per minute or revolution.

    Raises:
        ControlError: number-format, more integer digits than the format has.
    """
    value = _truncated(block, word, INCH_DIGITS if inch else METRIC_DIGITS)
    return float(value * MILLIMETRES_PER_INCH if inch else value) + 0.0


def feed(block: Block, word: Word, inch: bool) -> float:
    """The feed of an F or E word, mm per minute or revolution.

    Raises:
        ControlError: number-format, or out-of-range when the value is not positive after truncation.
    """
    value = length(block, word, inch)
    if value <= 0.0:
        least = "0.0001" if inch else "0.001"
        raise block.error("out-of-range", f"{word} is no feedrate; it must be {least} or more", word)
    return value


def plain(block: Block, word: Word) -> float:
    """A number without unit of length: a spindle speed or a dwell.

    Raises:
        ControlError: number-format, or out-of-range when negative.
    """
    value = float(_truncated(block, word, METRIC_DIGITS)) + 0.0
    if value < 0.0:
        raise block.error("out-of-range", f"{word} is negative; it must be 0 or more", word)
    return value


def integer(block: Block, word: Word, lowest: int, highest: int) -> int:
    """A whole number such as that of D, L, P or M.

    Raises:
        ControlError: number-format when it has a fraction, out-of-range outside `lowest` to `highest`.
    """
    if word.decimals.strip("0"):
        raise block.error("number-format", f"{word} is not an integer; {word.letter} takes a whole number", word)
    value = int(f"{word.sign}{word.whole or '0'}")
    if not lowest <= value <= highest:
        raise block.error("out-of-range", f"{word} is out of range; {word.letter} takes {lowest} to {highest}", word)
    return value


def g_code(block: Block, word: Word) -> str:
    """The code of a G word in the form ``G01`` or ``G81.1``.

    Raises:
        ControlError: unknown-word when it is negative or has more than one decimal digit.
    """
    decimals = word.decimals.rstrip("0")
    if word.sign == "-" or len(decimals) > 1 or len(word.whole) > 4:
        raise block.error("unknown-word", f"{word} is not a G code of this control", word)
    return f"G{int(word.whole or '0'):02d}{'.' if decimals else ''}{decimals}"


def _truncated(block: Block, word: Word, digits: tuple[int, int]) -> Decimal:
    whole, decimals = digits
    if len(word.whole) > whole:
        raise block.error("number-format", f"{word} has {len(word.whole)} integer digits; {whole} are allowed", word)
    return Decimal(f"{word.sign}{word.whole or '0'}.{word.decimals[:decimals] or '0'}")

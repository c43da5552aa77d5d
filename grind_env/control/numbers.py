"""Numbers of words by the formats of their addresses (10-7; lathe manual 10-17).

A number stays text until its point is placed and its decimals are cut; only the complete value becomes a float. So
0.3 gets no rounding error on the way.
"""

from dataclasses import dataclass
from decimal import ROUND_HALF_UP, Decimal

from grind_env.control.block_words import Block, Word
from grind_env.control.errors import ControlError
from grind_env.control.modes import ACTIONS, MACHINE_COORDINATES, MACRO_CALL, SWITCHES, listed

MILLIMETRES_PER_INCH = Decimal("25.4")
METRES_PER_FOOT = 0.3048
METRIC_DIGITS = (5, 3)  #: integer digits and decimals of a metric length or feed
INCH_DIGITS = (4, 4)
ZERO_SUPPRESSIONS = ("neither", "leading", "trailing")
EXCESS_DECIMALS = ("truncate", "round")
G_CODE_DIGITS = 2  #: digits of a G code to the left of its point under trailing zero suppression
LONGEST_T_WORD = 4


@dataclass(frozen=True, slots=True)
class NumberFormat:
    """Format of the numbers of a part program (AMP).

    Zero suppression concerns numbers written without a point: "neither" takes them for whole units, "leading" puts
    their last digit at the last decimal, "trailing" their first digit at the first integer digit. It applies to
    lengths, feeds, S and dwells; `g_code` says how it applies to G words. D, L, M, N, O, P and T words are integers
    that no setting changes (D). An evaluated expression counts as written with a point (D).

    Raises:
        ControlError: setting, an illegal value.
    """

    zero_suppression: str = "neither"  #: "neither", "leading" (LZS) or "trailing" (TZS)
    #: integer digits and decimals of a length or feed under G71, and of S and dwells
    metric: tuple[int, int] = METRIC_DIGITS
    inch: tuple[int, int] = INCH_DIGITS  #: integer digits and decimals of a length or feed under G70
    excess_decimals: str = "truncate"  #: "truncate" as in the manual's table, or "round" half away from zero (D)

    def __post_init__(self) -> None:
        for name, choices in (("zero_suppression", ZERO_SUPPRESSIONS), ("excess_decimals", EXCESS_DECIMALS)):
            choice = getattr(self, name)
            if choice not in choices:
                raise ControlError("setting", f"{name} is {choice!r}; it must be one of {', '.join(choices)}")
        for name, digits in (("metric", self.metric), ("inch", self.inch)):
            if len(digits) != 2 or not all(type(count) is int for count in digits):
                raise ControlError("setting", f"{name} is {digits}; it must be two whole numbers such as 5 and 3")
            if not (1 <= digits[0] <= 9 and 0 <= digits[1] <= 9):
                raise ControlError(
                    "setting", f"{name} is {digits}; it must be 1 to 9 integer digits and 0 to 9 decimals"
                )


STANDARD = NumberFormat()


def length(block: Block, word: Word, inch: bool, form: NumberFormat = STANDARD) -> float:
    """Return a coordinate or pick in mm, or a feed in mm per minute or revolution."""
    if inch:
        return float(Decimal(_formatted(block, word, form.inch, form)) * MILLIMETRES_PER_INCH) + 0.0
    return float(_formatted(block, word, form.metric, form)) + 0.0


def feed(block: Block, word: Word, inch: bool, form: NumberFormat = STANDARD) -> float:
    """Return the feed of an F or E word, mm per minute or revolution."""
    if inch and len(word.whole) > form.inch[0] and (word.point or form.zero_suppression == "neither"):
        meant = f"{word.letter}{Decimal(f'{word.whole}.{word.decimals}') / MILLIMETRES_PER_INCH:.1f}"
        message = (
            f"{word} has {len(word.whole)} integer digits; {form.inch[0]} are allowed under G70 in inches per minute"
        )
        raise block.error("number-format", f"{message}: write {meant} if mm/min are meant, or G71 before it", word)
    value = length(block, word, inch, form)
    if value <= 0.0:
        least = Decimal(1).scaleb(-(form.inch if inch else form.metric)[1])
        raise block.error("out-of-range", f"{word} is no feedrate; it must be {least:f} or more", word)
    return value


def plain(block: Block, word: Word, form: NumberFormat = STANDARD) -> float:
    """Return a number without unit of length, in the metric format (D): a spindle speed or a dwell."""
    value = float(_formatted(block, word, form.metric, form)) + 0.0
    if value < 0.0:
        raise block.error("out-of-range", f"{word} is negative; it must be 0 or more", word)
    return value


def integer(block: Block, word: Word, lowest: int, highest: int) -> int:
    """Return a whole number such as D, L, P or M; zero suppression does not apply (D)."""
    _refuse_unevaluated(block, word)
    if word.decimals.strip("0"):
        raise block.error("number-format", f"{word} is not an integer; {word.letter} takes a whole number", word)
    value = int(f"{word.sign}{word.whole or '0'}")
    if not lowest <= value <= highest:
        raise block.error("out-of-range", f"{word} is out of range; {word.letter} takes {lowest} to {highest}", word)
    return value


def tool_numbers(block: Block, word: Word) -> tuple[int, int]:
    """Return the entries of the radius and of the length table that a T word selects (15-12).

    One or two digits select the same entry of both tables; of four, the first two are the radius entry and the last
    two the length entry; three digits are four without the leading zero (D).
    """
    if len(word.whole) > LONGEST_T_WORD:
        digits = len(word.whole)
        raise block.error("number-format", f"{word} has {digits} digits; T takes up to {LONGEST_T_WORD}", word)
    number = integer(block, word, 0, 9999)
    if len(word.whole) <= 2:
        return number, number
    return divmod(number, 100)


def g_code(block: Block, word: Word, form: NumberFormat = STANDARD) -> str:
    """Return the code of a G word in the form ``G01`` or ``G81.1``.

    A number without a point has no decimals. Under trailing zero suppression, however, it is two digits and
    decimals: G2 is G20, and G920 is G92, because there are no G code macros (lathe manual 10-17).
    """
    _refuse_unevaluated(block, word)
    whole, decimals = word.whole, word.decimals
    if form.zero_suppression == "trailing" and not word.point:
        whole, decimals = _left_aligned(whole, G_CODE_DIGITS)
    decimals = decimals.rstrip("0")
    if word.sign == "-" or len(decimals) > 1 or len(whole) > 4:
        raise unknown_code(block, word)
    return f"G{int(whole or '0'):02d}{'.' if decimals else ''}{decimals}"


def unknown_code(block: Block, word: Word, hint: str = "") -> ControlError:
    """Return the error for an unknown G word; without a hint it lists the known codes."""
    legal = hint or f"{listed((*SWITCHES, *ACTIONS, MACHINE_COORDINATES, MACRO_CALL))} are"
    return block.error("unknown-word", f"{word} is not a G code of this control; {legal}", word)


def without_excess(block: Block, word: Word, inch: bool, form: NumberFormat = STANDARD) -> str | None:
    """Return a length or feed word with the decimals that the control reads; None if it has no more than these."""
    digits = form.inch if inch else form.metric
    if not word.decimals[digits[1] :].strip("0"):
        return None
    return f"{word.letter}{_formatted(block, word, digits, form)}"


def _formatted(block: Block, word: Word, digits: tuple[int, int], form: NumberFormat) -> str:
    """Return the number with its point and at most the integer digits and decimals of the format."""
    whole_digits, decimal_digits = digits
    whole, decimals = word.whole, word.decimals
    _refuse_unevaluated(block, word)
    if word.point or form.zero_suppression == "neither":
        if len(whole) > whole_digits:
            raise block.error(
                "number-format", f"{word} has {len(whole)} integer digits; {whole_digits} are allowed", word
            )
    elif len(whole) > whole_digits + decimal_digits:
        raise block.error(
            "number-format", f"{word} has {len(whole)} digits; {whole_digits + decimal_digits} are allowed", word
        )
    elif form.zero_suppression == "leading":
        split = max(len(whole) - decimal_digits, 0)
        whole, decimals = whole[:split], whole[split:].rjust(decimal_digits, "0")
    else:
        whole, decimals = _left_aligned(whole, whole_digits)
    if len(decimals) > decimal_digits:
        if form.excess_decimals == "round":
            return _rounded(block, word, digits)
        decimals = decimals[:decimal_digits]
    return f"{word.sign}{whole or '0'}.{decimals}"


def _left_aligned(digits: str, whole_digits: int) -> tuple[str, str]:
    """Return integer digits and decimals of a number whose first digit is its first integer digit."""
    return digits[:whole_digits].ljust(whole_digits, "0"), digits[whole_digits:]


def _rounded(block: Block, word: Word, digits: tuple[int, int]) -> str:
    """Return the nearest number with the decimals of the format; only numbers with a point can have more decimals."""
    whole_digits, decimal_digits = digits
    exact = Decimal(f"{word.sign}{word.whole or '0'}.{word.decimals}")
    value = exact.quantize(Decimal(1).scaleb(-decimal_digits), ROUND_HALF_UP)
    if abs(value) >= 10**whole_digits:
        raise block.error(
            "number-format", f"{word} is rounded to {whole_digits + 1} integer digits; {whole_digits} are allowed", word
        )
    return f"{value:f}"


def _refuse_unevaluated(block: Block, word: Word) -> None:
    """Raise an error for a word whose expression has not been evaluated; it would count as 0."""
    if not word.whole and not word.decimals:
        raise block.error("not-supported", f"{word} has a paramacro value; a plain number must stand here", word)

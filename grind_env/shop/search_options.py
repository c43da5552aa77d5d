"""Search options from values or command-line texts; an unknown option raises an `OptionError`."""

import math
import re
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, field
from decimal import Decimal
from numbers import Real
from typing import TypeAlias, TypeVar

from grind_env.errors import GrindError
from grind_env.message_text import did_you_mean, quoted

INTERVAL = "interval"  #: name of the dress interval, which counts parts or blocks
#: values that a search can vary: words of cycle blocks, settings of the dress program, the dress interval
VARIED = ("E", "D", "J", "L", "lead", "depth", "passes", INTERVAL)
USUAL = ("E", "D", INTERVAL)
LIMITS = ("power", "rise", "Ra", "size")
#: quantities that a search can reduce, each with the name of its mean per part in `Measures`
OBJECTIVES = {"cost": "cost", "time": "seconds"}

LEAST_SPEED = 60.0  #: least upper end of a range of E, mm/min; a range that ends below is taken for one in m/min
#: default probability that a part keeps a limit, and that each end of an interval holds for the machine
CONFIDENCE = 0.95
#: lowest and highest legal confidence; tens of machines and thousands of parts do not resolve values beyond
CONFIDENCES = 0.5, 0.999

Number: TypeAlias = float | Decimal
Ends: TypeAlias = Collection[Number]  #: lowest and highest value
NUMBER = r"(\d+\.?\d*|\.\d+)"

T = TypeVar("T")


class OptionError(GrindError):
    """Option with an unknown name or an illegal value."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SearchOptions:
    """Options of a search."""

    words: tuple[str, ...] = USUAL  #: values to vary, from `VARIED`
    add: bool = False  #: whether words that a cycle block lacks may be added to it
    # lowest and highest value by word, in the units of the program; lead in mm or inches a revolution
    bounds: Mapping[str, tuple[Decimal, Decimal]] = field(default_factory=dict)
    fixed: frozenset[int] = frozenset()  #: N words of the cycle blocks that stay as they are
    # share of each limit that parts must keep, by name of the limit; at most 1, and 1 for limits not named
    margins: Mapping[str, float] = field(default_factory=dict)
    # probability that a part of any lot on any machine keeps each limit, and that each end of an interval holds
    confidence: float = CONFIDENCE
    untried: bool = False  #: whether the program has never run on the machine
    objective: str = "cost"  #: quantity to reduce, from `OBJECTIVES`
    # highest mean cost, $, and time, s, of a part, by the names cost and seconds
    constraint: Mapping[str, float] = field(default_factory=dict)
    free: bool = False  #: whether equal blocks of equal parts may have different words

    @property
    def quantity(self) -> str:
        return OBJECTIVES[self.objective]


def options_of(
    words: Collection[str] | None = None,
    bounds: Mapping[str, Ends] = {},
    fixed: Collection[int] = (),
    margins: Mapping[str, Number] = {},
    objective: str = "cost",
    constraint: Mapping[str, Number] = {},
    free: bool = False,
    confidence: Number = CONFIDENCE,
    untried: bool = False,
) -> SearchOptions:
    """Return the checked options; arguments as in `SearchOptions`, `words` None for those of `USUAL` in the program."""
    for option, names, known in (
        ("--vary", words or (), VARIED),
        ("--bounds", bounds, VARIED),
        ("--margin", margins, LIMITS),
        ("--objective", (objective,), tuple(OBJECTIVES)),
        ("--constraint", constraint, tuple(OBJECTIVES.values())),
    ):
        for name in names:
            if name not in known:
                hint = " (now called rise)" if name == "temp" else did_you_mean(name, known)
                raise OptionError(f"{option}: there is no {quoted(name)}{hint}; there are {', '.join(known)}")
    if words is not None and not words:
        raise OptionError(f"--vary names no word; there are {', '.join(VARIED)}")
    for label in fixed:
        if not isinstance(label, int):
            raise OptionError(f"--fix: {quoted(label)} is no N word; give its number")
    return SearchOptions(
        words=USUAL if words is None else tuple(words),
        add=words is not None,
        bounds={name: ends_of("--bounds", name, ends) for name, ends in bounds.items()},
        fixed=frozenset(fixed),
        margins={name: _share("--margin", name, share) for name, share in margins.items()},
        confidence=confidence_of(confidence),
        untried=untried,
        objective=objective,
        constraint={name: float(_positive("--constraint", name, most)) for name, most in constraint.items()},
        free=free,
    )


def ends_of(option: str, name: str, ends: Ends) -> tuple[Decimal, Decimal]:
    """Return the ends of a range as decimal numbers."""
    try:
        low, high = (Decimal(str(end)) for end in ends)
        is_range = low >= 0 and high.is_finite()
    except (TypeError, ValueError, ArithmeticError):
        is_range = False
    if not is_range:
        raise OptionError(f"{option}: {quoted(ends)} is no range of {name}; give its lowest and its highest value")
    if name == "E" and high < LEAST_SPEED:
        raise OptionError(
            f"{option}: E is in mm/min; did you mean {1000 * low:f}..{1000 * high:f}? "
            f"For a table as slow as that, end the range at {LEAST_SPEED:g} or above"
        )
    if low > high:
        raise OptionError(f"{option}: the range {low}..{high} of {name} begins above its end; write {high}..{low}")
    return low, high


def whole_ends_of(option: str, name: str, ends: Ends) -> tuple[int, int]:
    """Return the ends of a range of whole numbers."""
    low, high = ends_of(option, name, ends)
    if low % 1 or high % 1:
        raise OptionError(f"{option}: the ends of {low}..{high} are no whole numbers, as {name} are")
    return int(low), int(high)


def seconds_of(budget: Number) -> float:
    """Return the time of a search, s."""
    if not (isinstance(budget, Real | Decimal) and budget >= 0):
        raise OptionError(f"--budget: {quoted(budget)} is no time; give the seconds")
    return float(budget)


def confidence_of(value: Number) -> float:
    """Return a checked confidence."""
    low, high = CONFIDENCES
    if not (isinstance(value, Real | Decimal) and low <= value <= high):
        raise OptionError(f"--confidence: {quoted(value)} is none; give a number from {low:g} to {high:g}, such as .95")
    return float(value)


def _positive(option: str, name: str, value: Number) -> Decimal:
    if not (isinstance(value, Real | Decimal) and 0 < value < math.inf):
        raise OptionError(f"{option}: {quoted(value)} is no value of {name}; write a number above 0")
    return Decimal(str(value))


def _share(option: str, name: str, value: Number) -> float:
    share = _positive(option, name, value)
    if share > 1:
        meant = share / 100 if 10 <= share <= 100 else Decimal("0.85")
        raise OptionError(
            f"{option}: {name}={value} is {value} times the limit, and no share of it; write a number up to 1, such as "
            f"{name}={f'{meant:f}'.removeprefix('0')}"
        )
    return float(share)


def listed(texts: Iterable[str]) -> list[str]:
    """Return items separated by commas or given one by one."""
    return [part.strip() for text in texts for part in text.split(",") if part.strip()]


def named(option: str, texts: Iterable[str], read: Callable[[str, str, str], T]) -> dict[str, T]:
    """Return values by name from texts such as E=100,J=.001; `read` makes a value of option, name and text."""
    pairs = [part.partition("=") for part in listed(texts)]
    for name, equals, value in pairs:
        if not (equals and value):
            raise OptionError(f"{option}: {quoted(name)} has no value; write it behind an equals sign")
    return {name.strip(): read(option, name.strip(), value.strip()) for name, _, value in pairs}


def ends(option: str, name: str, text: str) -> tuple[Decimal, Decimal]:
    """Return the ends of a range such as 5000..25000."""
    wrong = f"{option}: {quoted(text)} is no range of {name}; write two numbers with two points between"
    low, high = _matched(rf"{NUMBER}\.\.{NUMBER}", text, wrong)
    return Decimal(low), Decimal(high)


def number(option: str, name: str, text: str) -> Decimal:
    """Return a number such as .001."""
    (value,) = _matched(NUMBER, text, f"{option}: {quoted(text)} is no value of {name}; write a number above 0")
    return Decimal(value)


def label(text: str) -> int:
    """Return the number of a block label such as N80."""
    (digits,) = _matched(r"[Nn]?(\d{1,5})", text, f"--fix: {quoted(text)} is no block label; write it as in N80")
    return int(digits)


def budget(text: str) -> tuple[float, int | None]:
    """Return time, s, and number of programs (None for a time) of a text such as 60, 60s, 2min or 2000 programs."""
    wrong = f"--budget: {quoted(text)} is no time; write 60s, 2min or '2000 programs'"
    number, unit = _matched(rf"{NUMBER}\s*(s|min|programs?|)", text.strip(), wrong)
    if unit.startswith("program"):
        return 0.0, max(int(float(number)), 1)
    return float(number) * (60.0 if unit == "min" else 1.0), None


def _matched(pattern: str, text: str, wrong: str) -> tuple[str, ...]:
    match = re.fullmatch(pattern, text)
    if match is None:
        raise OptionError(wrong)
    return match.groups()

"""What a user asks of a search: words to be varied, bounds and steps of their values, blocks to be kept, margins."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from decimal import Decimal

from grind_env.errors import GrindError, did_you_mean, quoted

WORDS = ("E", "D", "J", "L", "lead", "depth", "passes")
"""What may be varied: words of cycle blocks, then what the dress program says."""
USUAL = ("E", "D")
LIMITS = ("power", "temp", "Ra", "size")

_NUMBER = r"(\d+\.?\d*|\.\d+)"
_RANGE = re.compile(rf"{_NUMBER}\.\.{_NUMBER}")
_LABEL = re.compile(r"[Nn]?(\d{1,5})")
_SECONDS = re.compile(rf"{_NUMBER}\s*(s|min|)")


class WishError(GrindError):
    """An option that asks for what there is not."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Wishes:
    """What is asked of a search.

    Attributes:
        words: of `WORDS`.
        add: whether words that a cycle block lacks may be added to it.
        bounds: lowest and highest value by word, in the units of the program; lead in mm or inches a revolution.
        steps: of which values are multiples, likewise.
        kept: N words of the cycle blocks that stay as they are.
        margins: share of its limit that 95 parts of 100 must keep, by name, 1 at most; 1 for those not named.
    """

    words: tuple[str, ...] = USUAL
    add: bool = False
    bounds: Mapping[str, tuple[Decimal, Decimal]] = field(default_factory=dict)
    steps: Mapping[str, Decimal] = field(default_factory=dict)
    kept: frozenset[int] = frozenset()
    margins: Mapping[str, float] = field(default_factory=dict)

    def margin(self, limit: str) -> float:
        """Of one of `LIMITS`."""
        return self.margins.get(limit, 1.0)


def wishes_of(
    vary: str | None = None,
    bounds: Sequence[str] = (),
    steps: Sequence[str] = (),
    keep: Sequence[str] = (),
    margins: Sequence[str] = (),
) -> Wishes:
    """Read the options of the command line; lists may be separated by commas or given one by one.

    Raises:
        WishError: one of them cannot be read.
    """
    words = USUAL if vary is None else tuple(_known("--vary", word, WORDS) for word in _parts([vary]))
    if not words:
        raise WishError(f"--vary names no word; there are {', '.join(WORDS)}")
    return Wishes(
        words=words,
        add=vary is not None,
        bounds={name: range_of("--bounds", name, text) for name, text in _pairs("--bounds", bounds, WORDS)},
        steps={name: _positive("--round", name, text) for name, text in _pairs("--round", steps, WORDS)},
        kept=frozenset(_label(text) for text in _parts(keep)),
        margins={name: _share("--margin", name, text) for name, text in _pairs("--margin", margins, LIMITS)},
    )


def range_of(option: str, name: str, text: str) -> tuple[Decimal, Decimal]:
    """The ends of a range such as 5000..25000.

    Raises:
        WishError: it is none.
    """
    match = _RANGE.fullmatch(text)
    if match is None:
        raise WishError(f"{option}: {quoted(text)} is no range of {name}; write two numbers with two points between")
    low, high = Decimal(match[1]), Decimal(match[2])
    if low > high:
        raise WishError(f"{option}: the range {text} of {name} begins above its end; write {high}..{low}")
    return low, high


def whole_range_of(option: str, name: str, text: str) -> tuple[int, int]:
    """The ends of a range such as 1..20 of whole numbers.

    Raises:
        WishError: it is none.
    """
    low, high = range_of(option, name, text)
    if low % 1 or high % 1:
        raise WishError(f"{option}: the ends of {text} are no whole numbers, as {name} are")
    return int(low), int(high)


def seconds_of(text: str) -> float:
    """A time such as 60, 60s or 2min, s.

    Raises:
        WishError: it is none.
    """
    match = _SECONDS.fullmatch(text.strip())
    if match is None:
        raise WishError(f"--budget: {quoted(text)} is no time; write 60s or 2min")
    return float(match[1]) * (60.0 if match[2] == "min" else 1.0)


def _parts(texts: Sequence[str]) -> list[str]:
    return [part.strip() for text in texts for part in text.split(",") if part.strip()]


def _pairs(option: str, texts: Sequence[str], names: Sequence[str]) -> list[tuple[str, str]]:
    pairs = [part.partition("=") for part in _parts(texts)]
    for name, equals, value in pairs:
        if not (equals and value):
            raise WishError(f"{option}: {quoted(name)} has no value; write it as in {names[0]}=...")
    return [(_known(option, name.strip(), names), value.strip()) for name, _, value in pairs]


def _known(option: str, name: str, names: Sequence[str]) -> str:
    if name not in names:
        hint = did_you_mean(name, names)
        raise WishError(f"{option}: there is no {quoted(name)}{hint}; there are {', '.join(names)}")
    return name


def _positive(option: str, name: str, text: str) -> Decimal:
    if re.fullmatch(_NUMBER, text) is None or not Decimal(text) > 0:
        raise WishError(f"{option}: {quoted(text)} is no value of {name}; write a number above 0")
    return Decimal(text)


def _share(option: str, name: str, text: str) -> float:
    share = _positive(option, name, text)
    if share > 1:
        meant = share / 100 if 10 <= share <= 100 else Decimal("0.85")
        raise WishError(
            f"{option}: {name}={text} is {text} times the limit, and no share of it; write a number up to 1, such as "
            f"{name}={f'{meant:f}'.removeprefix('0')}"
        )
    return float(share)


def _label(text: str) -> int:
    match = _LABEL.fullmatch(text)
    if match is None:
        raise WishError(f"--keep: {quoted(text)} is no block label; write it as in N80")
    return int(match[1])

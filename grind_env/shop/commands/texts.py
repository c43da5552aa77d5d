"""What is typed as a text on the command line, read as values.

A text that cannot be read is a `WishError`; what the values may be is checked by what takes them.
"""

import re
from collections.abc import Callable, Iterable
from decimal import Decimal
from typing import TypeVar

from grind_env.errors import quoted
from grind_env.shop.wishes import WishError

NUMBER = r"(\d+\.?\d*|\.\d+)"

T = TypeVar("T")


def listed(texts: Iterable[str]) -> list[str]:
    """What is separated by commas or given one by one."""
    return [part.strip() for text in texts for part in text.split(",") if part.strip()]


def named(option: str, texts: Iterable[str], read: Callable[[str, str, str], T]) -> dict[str, T]:
    """Values by name, as E=100,J=.001; `read` has a value from option, name and text."""
    pairs = [part.partition("=") for part in listed(texts)]
    for name, equals, value in pairs:
        if not (equals and value):
            raise WishError(f"{option}: {quoted(name)} has no value; write it behind an equals sign")
    return {name.strip(): read(option, name.strip(), value.strip()) for name, _, value in pairs}


def ends(option: str, name: str, text: str) -> tuple[Decimal, Decimal]:
    """The ends of a range such as 5000..25000."""
    wrong = f"{option}: {quoted(text)} is no range of {name}; write two numbers with two points between"
    low, high = _matched(rf"{NUMBER}\.\.{NUMBER}", text, wrong)
    return Decimal(low), Decimal(high)


def number(option: str, name: str, text: str) -> Decimal:
    """A number such as .001."""
    (value,) = _matched(NUMBER, text, f"{option}: {quoted(text)} is no value of {name}; write a number above 0")
    return Decimal(value)


def label(text: str) -> int:
    """The number of a block label such as N80."""
    (digits,) = _matched(r"[Nn]?(\d{1,5})", text, f"--keep: {quoted(text)} is no block label; write it as in N80")
    return int(digits)


def budget(text: str) -> tuple[float, int | None]:
    """A time such as 60, 60s or 2min, s, or a number of programs, such as 2000 programs."""
    wrong = f"--budget: {quoted(text)} is no time; write 60s, 2min or '2000 programs'"
    number, unit = _matched(rf"{NUMBER}\s*(s|min|programs?|)", text.strip(), wrong)
    if unit.startswith("program"):
        return 0.0, max(int(float(number)), 1)
    return float(number) * (60.0 if unit == "min" else 1.0), None


def _matched(pattern: str, text: str, wrong: str) -> tuple[str, ...]:
    match = re.fullmatch(pattern, text)
    if match is None:
        raise WishError(wrong)
    return match.groups()

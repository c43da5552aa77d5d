"""The base class of every error from user input, and the quoting and suggestions in messages."""

import difflib
from collections.abc import Iterable, Sequence
from typing import ClassVar

LONGEST_QUOTE = 60
"""Characters that a message quotes of what was found."""
LONGEST_REASON = 160
"""Characters that it quotes of another library's message."""
MOST_LISTED = 20
"""Names from a file that a message lists."""


class GrindError(ValueError):
    """Bad input: program text, job, catalogue, action or file.

    The message is one sentence that names the place and the remedy. The command line prints it and exits
    with status 2, or that of its class; it never shows a traceback for one of these.
    """

    status: ClassVar[int] = 2


class GrindWarning(UserWarning):
    """A remark on input that is used all the same. The command line prints it once, as one line."""


def shortened(text: str, most: int = LONGEST_QUOTE) -> str:
    """Return a text as a message quotes it: on one line, and of a long one the beginning."""
    shown = text[:most]
    shown = shown if shown.isprintable() else repr(shown)[1:-1]
    return shown if len(text) <= most else f"{shown}... ({len(text)} characters)"


def printable(text: str) -> str:
    """Return a text as a terminal or a page may show it: what controls either, such as an escape, as the code of it.

    Line ends and tabs stay. Whatever comes from a file, a name or a message passes through here before it is printed.
    """
    return "".join(letter if letter.isprintable() or letter in "\n\t\xa0" else repr(letter)[1:-1] for letter in text)


def quoted(value: object) -> str:
    """Return a value as a message quotes it: its repr, shortened."""
    try:
        return shortened(repr(value))
    except (RecursionError, ValueError):  # of a table in a table in a table ..., of a number of 5000 digits
        return f"a value of type {type(value).__name__} that is too large to be shown"


def listed(names: Sequence[str], most: int = MOST_LISTED) -> str:
    """Names from a file as a message lists them: the first ones, each shortened, and how many more there are."""
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return ", ".join(shortened(name) for name in names[:most]) + more


def reason(error: BaseException) -> str:
    """Return the error of another library as a message quotes it: its first line, shortened."""
    return shortened(str(error).partition("\n")[0], LONGEST_REASON) or type(error).__name__


def closest(word: str, choices: Iterable[str], likeness: float = 0.6) -> str:
    """Return the choice most like a word; empty if none is that like it, from 0 to 1."""
    return next(iter(difflib.get_close_matches(word, list(choices), 1, likeness)), "")


def did_you_mean(word: str, choices: Iterable[str], likeness: float = 0.6) -> str:
    """Return the choice most like a word, as a remark to put behind it; empty as `closest` is."""
    close = closest(word, choices, likeness)
    return f" (did you mean {close}?)" if close else ""

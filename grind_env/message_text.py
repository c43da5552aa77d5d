"""Text of messages: quotes of the input, lists of names and suggestions."""

import difflib
from collections.abc import Iterable, Sequence

LONGEST_QUOTE = 60  #: greatest number of characters that a message quotes from the input
LONGEST_REASON = 160  #: greatest number of characters that a message quotes from another library's message
MOST_LISTED = 20  #: greatest number of names from a file that a message lists


def shortened(text: str, most: int = LONGEST_QUOTE) -> str:
    """Return a text as a message quotes it: on one line, and only its first `most` characters if it is longer."""
    shown = text[:most]
    shown = shown if shown.isprintable() else repr(shown)[1:-1]
    return shown if len(text) <= most else f"{shown}... ({len(text)} characters)"


def printable(text: str) -> str:
    """Return a text that is safe on a terminal or page: control characters such as escape are replaced by their codes.

    Line ends and tabs stay. Every text from a file, a name or a message passes through this function before it is
    printed.
    """
    return "".join(letter if letter.isprintable() or letter in "\n\t\xa0" else repr(letter)[1:-1] for letter in text)


def quoted(value: object) -> str:
    """Return the shortened repr of a value, for a message."""
    try:
        return shortened(repr(value))
    except (RecursionError, ValueError):  # a deeply nested table, or a number of 5000 digits
        return f"a value of type {type(value).__name__} that is too large to be shown"


def listed(names: Sequence[str], most: int = MOST_LISTED) -> str:
    """Return names from a file as a message lists them: the first ones, each shortened, and the number of others."""
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return ", ".join(shortened(name) for name in names[:most]) + more


def reason(error: BaseException) -> str:
    """Return the first line of another library's error message, shortened."""
    return shortened(str(error).partition("\n")[0], LONGEST_REASON) or type(error).__name__


def closest(word: str, choices: Iterable[str], likeness: float = 0.6) -> str:
    """Return the choice most similar to a word; empty if no similarity (0 to 1) reaches `likeness`."""
    return next(iter(difflib.get_close_matches(word, list(choices), 1, likeness)), "")


def did_you_mean(word: str, choices: Iterable[str], likeness: float = 0.6) -> str:
    """Return a hint such as " (did you mean power?)" with the `closest` choice; empty if there is none."""
    close = closest(word, choices, likeness)
    return f" (did you mean {close}?)" if close else ""

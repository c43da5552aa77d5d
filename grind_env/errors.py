"""The common root of every error that a user's input can cause, and what its message may suggest."""

import difflib
from collections.abc import Iterable


class GrindError(ValueError):
    """Bad input: program text, job, catalogue, action or file.

    The message is one sentence that names the place and the remedy. The command line prints it and exits
    with status 2; it never shows a traceback for one of these.
    """


def did_you_mean(word: str, choices: Iterable[str], likeness: float = 0.6) -> str:
    """The choice most like a word, as a remark to put behind it; empty if none is that like it, from 0 to 1."""
    close = difflib.get_close_matches(word, list(choices), 1, likeness)
    return f" (did you mean {close[0]}?)" if close else ""

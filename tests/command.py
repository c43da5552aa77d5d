"""Commands of `grind` within this process, and the type of the fixture that runs them."""

from collections.abc import Callable

import pytest

from grind_env.cli import main

#: function that takes the words behind `grind` and returns exit status, output and errors
Grind = Callable[..., tuple[int, str, str]]


def status(*words: object) -> int:
    """Run a command; return its exit status."""
    with pytest.raises(SystemExit) as ended:
        main([str(word) for word in words])
    return int(ended.value.code or 0)

"""The type of the fixture `grind`, which runs a command."""

from collections.abc import Callable

Grind = Callable[..., tuple[int, str, str]]
"""From the words behind `grind` to exit status, output and errors."""

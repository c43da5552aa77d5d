"""Starts the command `grind`, from outside its package: Ctrl-C is then quiet while the package is imported, too."""

import sys

INTERRUPTED = 130
"""Exit status of a command that Ctrl-C ends."""


def main() -> None:
    """Console entry."""
    try:
        from grind_env.cli import main as grind
    except KeyboardInterrupt:
        sys.exit(INTERRUPTED)
    grind()

"""The command `grind`, also as `python -m grind_env`."""

import atexit
import gc
import sys

INTERRUPTED = 130
"""Exit status of a command that Ctrl-C ends."""


def main() -> None:
    """Run the command; Ctrl-C is quiet while it is imported, too."""
    _collect_nothing()
    try:
        from grind_env.cli import main as grind
    except KeyboardInterrupt:
        sys.exit(INTERRUPTED)
    grind()


def _collect_nothing() -> None:
    """Let Python look for no cycles of garbage: a command leaves no more of them the longer it runs.

    To look for them among all that is imported, and once more at the end, took a quarter of the time of a short run.
    """
    gc.disable()
    atexit.register(gc.freeze)


if __name__ == "__main__":
    main()

"""The command `grind`, also as `python -m grind_env`."""

import gc
import sys

INTERRUPTED = 130
"""Exit status of a command that Ctrl-C ends."""


def main() -> None:
    """Run the command; Ctrl-C is quiet while it is imported, too."""
    gc.disable()  # a run leaves no cycles behind; to look for some among all that is imported took a tenth of a second
    try:
        from grind_env.cli import main as grind
    except KeyboardInterrupt:
        sys.exit(INTERRUPTED)
    grind()


if __name__ == "__main__":
    main()

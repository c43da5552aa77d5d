"""The command `grind`, also as `python -m grind_env`."""

import atexit
import gc
import sys

from grind_env.command_exit import INTERRUPTED


def main() -> None:
    """Run the command; Ctrl-C prints no traceback, even during the imports."""
    # collections during the imports and at the end took a quarter of the time of a short run
    gc.disable()
    atexit.register(gc.freeze)
    try:
        from grind_env.cli import main as grind
    except KeyboardInterrupt:
        sys.exit(INTERRUPTED)
    grind()


if __name__ == "__main__":
    main()

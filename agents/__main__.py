"""The command `python -m agents`."""

import sys

INTERRUPTED = 130  #: exit status of a command that Ctrl-C ends


def main() -> None:
    """Run the command; a user's mistake, or a file that cannot be written, gives one sentence and exit status 2."""
    try:
        from agents.command_line import app
        from grind_env.command_exit import command
    except KeyboardInterrupt:
        sys.exit(INTERRUPTED)
    with command("agents"):
        app(prog_name="python -m agents")


if __name__ == "__main__":
    main()

"""The commands of `grind` for one's own programs, jobs and logs."""

import typer


def register(app: typer.Typer) -> None:
    """Add the commands to the application."""

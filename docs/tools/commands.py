"""Page of a command-line application, made from its help."""

import re

import typer
from typer.cli import get_docs_for_click
from typer.main import get_command


def commands_page(app: typer.Typer, name: str) -> str:
    """Return the Markdown page: a section for every command with its arguments and options."""
    command = get_command(app)
    context = typer.Context(command, info_name=name)
    text = get_docs_for_click(obj=command, ctx=context, name=name)
    examples = r"^((?:(?:grind|python -m agents) .+\n)+)$"
    return re.sub(
        examples, lambda found: f"```console\n{re.sub('(?m)^', '$ ', found[1].rstrip())}\n```\n", text, flags=re.M
    )

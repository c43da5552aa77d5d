"""Views of objects of lower layers, drawn by `grind_env.notebook`.

That package imports whatever it shows, so nothing that is shown may import it. An object names its presenter instead,
which is imported when a notebook or a user asks for it; `import grind_env` stays fast, too.
"""

from importlib import import_module
from typing import Any


def presenter(name: str) -> Any:
    """Return the module of `grind_env.notebook` by that name."""
    return import_module(f"grind_env.notebook.{name}")


def html(name: str, shown: object) -> str:
    """Return an object as HTML, which its presenter writes."""
    text: str = presenter(name).html(shown)
    return text

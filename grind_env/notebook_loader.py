"""Views of objects of lower layers, drawn by `grind_env.notebook_views`.

It imports the classes that it draws, so these classes cannot import `grind_env.notebook_views`. They name
their presenter module instead, which is imported when an object is drawn. This also keeps `import grind_env` fast.
"""

from importlib import import_module
from typing import Any


def presenter(name: str) -> Any:
    """Return a module of `grind_env.notebook_views` by name."""
    return import_module(f"grind_env.notebook_views.{name}")


def html(name: str, shown: object) -> str:
    """Return an object as HTML, written by its presenter."""
    text: str = presenter(name).html(shown)
    return text

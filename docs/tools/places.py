"""Sphinx extension: remove the folders of the building machine from the pages."""

import re
from pathlib import Path
from tempfile import gettempdir
from typing import Any

from sphinx.application import Sphinx

ROOT = Path(__file__).parents[2]
BEGINS = r"(?<![\w./~-])"
#: replacements of the checkout, of hidden folders in the home folder, and of temporary folders
PLACES = (
    (re.compile(rf"{BEGINS}{re.escape(str(ROOT))}/"), ""),
    (re.compile(rf"{BEGINS}{re.escape(str(Path.home()))}(?=/\.)"), "~"),
    (re.compile(rf"{BEGINS}{re.escape(gettempdir())}/tmp\w+"), "/tmp/..."),
)


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the change of pages."""
    app.connect("html-page-context", _shorten)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def anywhere(text: str) -> str:
    """Return a text without the folders of this machine."""
    for place, short in PLACES:
        text = place.sub(short, text)
    return text


def _shorten(_app: Sphinx, _name: str, _template: str, context: dict[str, Any], _page: Any) -> None:
    if "body" in context:
        context["body"] = anywhere(context["body"])

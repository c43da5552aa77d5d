"""Sphinx extension: remove invisible parts of the site, a tenth of its bytes.

Sphinx puts each word of a signature into a span that only forbids hyphens; the theme adds the sources of its scripts.
Index entries of API names would come before every page in a search, which finds these names anyway.
"""

import re
from typing import Any

from docutils import nodes
from sphinx import addnodes
from sphinx.application import Sphinx

SIGNATURE = re.compile(r'<dt class="sig .*?</dt>', re.DOTALL)
SPAN = re.compile(r'<span class="pre">([^<]*)</span>')


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the changes of pages and files."""
    app.connect("doctree-read", lambda _app, page: unindexed(page))
    app.connect("html-page-context", _lean)
    app.connect("build-finished", _without_sources)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def lean(page: str) -> str:
    """Return a page without the spans around the words of signatures."""
    return SIGNATURE.sub(lambda signature: SPAN.sub(r"\1", signature[0]), page)


def unindexed(page: nodes.document) -> None:
    """Remove the index entries from a page."""
    for entry in list(page.findall(addnodes.index)):
        entry.parent.remove(entry)


def _lean(_app: Sphinx, _name: str, _template: str, context: dict[str, Any], _page: Any) -> None:
    if "body" in context:
        context["body"] = lean(context["body"])


def _without_sources(app: Sphinx, _error: Exception | None) -> None:
    for path in (app.outdir / "_static").rglob("*.map"):
        path.unlink()

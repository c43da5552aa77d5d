"""Sphinx extension: show shell cells without `%%bash`, so that copied cells run in bash.

Notebooks need this mark, but no shell understands it. On a page, a label that is not copied replaces the mark.
"""

from docutils import nodes
from sphinx.application import Sphinx

MARK = "%%bash\n"


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the change of cells."""
    app.connect("doctree-read", lambda _app, page: unmarked(page))
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def unmarked(page: nodes.document) -> None:
    """Remove the mark from every shell cell of a page, and give the cell a class instead."""
    for block in page.findall(nodes.literal_block):
        text = block.astext()
        if text.startswith(MARK):
            block.rawsource = text.removeprefix(MARK)
            block.children = [nodes.Text(block.rawsource)]
            block["language"] = "bash"
            block.parent["classes"].append("shell")

"""Sphinx extension: cells of a shell as what is typed into it, so that what is copied runs in bash as printed.

A notebook marks them by `%%bash`, which no shell understands; on a page a label does that, which is not copied.
"""

from docutils import nodes
from sphinx.application import Sphinx

MARK = "%%bash\n"


def setup(app: Sphinx) -> dict[str, bool]:
    """Register what is done to cells."""
    app.connect("doctree-read", lambda _app, page: unmarked(page))
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def unmarked(page: nodes.document) -> None:
    """Take the mark from every cell of a page that has it, and say in its class what it is."""
    for block in page.findall(nodes.literal_block):
        text = block.astext()
        if text.startswith(MARK):
            block.rawsource = text.removeprefix(MARK)
            block.children = [nodes.Text(block.rawsource)]
            block["language"] = "bash"
            block.parent["classes"].append("shell")

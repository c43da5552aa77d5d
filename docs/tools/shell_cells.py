"""Sphinx extension: cells of a shell as what is typed into it, so that what is copied runs in bash as printed.

A notebook marks them by `%%bash`, which no shell understands; on a page a label does that, which is not copied.
"""

from docutils import nodes
from sphinx.application import Sphinx

MARK = "%%bash\n"


def setup(app: Sphinx) -> dict[str, bool]:
    """Register what is done to cells."""
    app.connect("doctree-read", _unmark)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def _unmark(_app: Sphinx, page: nodes.document) -> None:
    for block in page.findall(nodes.literal_block):
        text = block.astext()
        if text.startswith(MARK):
            block.rawsource = text.removeprefix(MARK)
            block.children = [nodes.Text(block.rawsource)]
            block["language"] = "bash"
            block.parent["classes"].append("shell")

"""Executed notebooks as pages."""

import json
from typing import Any

Output = dict[str, Any]


def as_page(text: bytes) -> bytes:
    """A notebook in which what a cell prints is one text, however it came."""
    notebook = json.loads(text)
    for cell in notebook["cells"]:
        if cell["cell_type"] == "code":
            cell["outputs"] = _joined(cell["outputs"])
    return json.dumps(notebook).encode()


def _joined(outputs: list[Output]) -> list[Output]:
    """Outputs in which successive pieces of a stream are one."""
    found: list[Output] = []
    for output in outputs:
        last = found[-1] if found else {}
        if output["output_type"] == "stream" and last.get("name") == output["name"]:
            last["text"] = [*last["text"], *output["text"]]
        else:
            found.append(output)
    return found

"""Executed notebooks as pages, which have no kernel."""

import json
from collections.abc import Iterator, Mapping
from typing import Any

STATE, VIEW = "application/vnd.jupyter.widget-state+json", "application/vnd.jupyter.widget-view+json"
Output = dict[str, Any]


def as_page(text: bytes) -> bytes:
    """A notebook in which sliders have given way to what they show, and what a cell prints is one text."""
    notebook = json.loads(text)
    widgets = notebook["metadata"].pop("widgets", {}).get(STATE, {}).get("state", {})
    for cell in notebook["cells"]:
        if cell["cell_type"] == "code":
            shown = [each for output in cell["outputs"] for each in _still(output, widgets)]
            cell["outputs"] = _joined(shown)
    return json.dumps(notebook).encode()


def _still(output: Output, widgets: Mapping[str, Any]) -> Iterator[Output]:
    """The output itself, or what the output widgets below a widget have last shown."""
    view = output.get("data", {}).get(VIEW)
    if view is None:
        yield output
        return
    open_ids = [view["model_id"]]
    while open_ids:
        state = widgets.get(open_ids.pop(), {}).get("state", {})
        yield from state.get("outputs", [])
        open_ids += [child.removeprefix("IPY_MODEL_") for child in state.get("children", [])]


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

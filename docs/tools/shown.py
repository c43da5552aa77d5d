"""Outputs of the notebooks in git: `python docs/tools/shown.py keep|compare`.

`make notebooks` executes the notebooks into `build/notebooks`. `keep` copies their outputs into `notebooks/`, so that a
code host shows them. `compare` reports the first text of a notebook that differs from git. Cells with the tag `varies`
are not compared, because they differ between machines: times and results of training.
"""

import json
import re
import sys
from base64 import b64decode, b64encode
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from pictures import lighter

ROOT = Path(__file__).parents[2]
KEPT, EXECUTED = ROOT / "notebooks", ROOT / "build" / "notebooks"
VARIES = "varies"
MOST = 400_000  #: largest permitted size of a notebook in git, bytes
ADDRESS = re.compile(r" at 0x[0-9a-f]+|/tmp/\S+")  #: pattern of texts that differ in every process

Notebook = dict[str, Any]


def shown(executed: Notebook) -> Notebook:
    """Return an executed notebook with only the outputs that a reader needs."""
    count = 0
    for cell in executed["cells"]:
        if cell["cell_type"] != "code":
            continue
        cell["metadata"].pop("execution", None)
        cell["outputs"] = joined([each for output in cell["outputs"] if (each := _seen(output)) is not None])
        if cell["execution_count"] is not None:
            count += 1
            cell["execution_count"] = count
        for output in cell["outputs"]:
            if "execution_count" in output:
                output["execution_count"] = count
    return executed


def joined(outputs: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return outputs in which successive pieces of a stream are joined."""
    found: list[dict[str, Any]] = []
    for output in outputs:
        last = found[-1] if found else {}
        if output["output_type"] == "stream" and last.get("name") == output["name"]:
            last["text"] = [*last["text"], *output["text"]]
        else:
            found.append(output)
    return found


def _seen(output: dict[str, Any]) -> dict[str, Any] | None:
    """Return an output in its smallest form, or None for standard error."""
    if output["output_type"] == "stream":
        return output if output["name"] == "stdout" else None
    data = output["data"]
    if "image/png" in data:
        data = {"image/png": light(data["image/png"])}
    elif "text/html" in data:
        data = {"text/html": data["text/html"], "text/plain": _short(data["text/plain"])}
    return {**output, "data": data, "metadata": {}}


def light(picture: str) -> str:
    """Return a picture in Base64 with few colours."""
    return b64encode(lighter(b64decode(picture))).decode()


def _short(text: list[str] | str) -> str:
    """Return the beginning of a text, which represents an object where HTML is not shown."""
    return "".join(text)[:200]


def texts(notebook: Notebook) -> Iterator[tuple[int, str]]:
    """Yield the cell number and text of every output that is equal on all machines."""
    for number, cell in enumerate(notebook["cells"]):
        if cell["cell_type"] != "code" or VARIES in cell["metadata"].get("tags", []):
            continue
        said = [output for output in cell["outputs"] if output.get("name") != "stderr"]
        for output in joined(said):
            data = output.get("data", {})
            if "image/png" not in data:
                text = output["text"] if "text" in output else data.get("text/html") or data["text/plain"]
                yield number, ADDRESS.sub("", "".join(text))


def keep(executed: Path, kept: Path) -> str:
    """Copy an executed notebook with its outputs.

    Returns:
        What is wrong with the notebook; empty if nothing is.
    """
    text = json.dumps(shown(json.loads(executed.read_text("utf-8"))), indent=1, ensure_ascii=False) + "\n"
    kept.write_text(text, encoding="utf-8")
    size = len(text.encode())
    return f"it has {size / 1000:.0f} kB, more than {MOST / 1000:.0f} kB" if size > MOST else ""


def compare(executed: Path, kept: Path) -> str:
    """Return the first difference between the texts of an execution and of git; empty if there is none."""
    ran, held = (list(texts(json.loads(path.read_text("utf-8")))) for path in (executed, kept))
    for (number, new), (_, old) in zip(ran, held, strict=False):
        if new != old:
            return f"cell {number} shows\n{new[:600]}\ninstead of\n{old[:600]}"
    return "" if len(ran) == len(held) else f"the cells show {len(ran)} texts instead of {len(held)}"


COMMANDS: dict[str, Callable[[Path, Path], str]] = {"keep": keep, "compare": compare}


def main(command: str) -> int:
    """Run a command on all notebooks; return 1 if something is wrong with one."""
    wrong = 0
    for kept in sorted(KEPT.glob("*.ipynb")):
        if said := COMMANDS[command](EXECUTED / kept.name, kept):
            wrong = 1
            print(f"{kept.name}: {said}", file=sys.stderr)
    return wrong


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))

"""The notebooks as they are checked in, with what they have shown: `python docs/tools/shown.py keep|compare`.

`make notebooks` executes them into `build/notebooks`. `keep` takes what they have shown over into `notebooks/`, so that
a code host shows it; `compare` says where an execution shows another text than is checked in. Cells with the tag
`varies` show what differs from machine to machine: times, and what torch has learned.
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
MOST = 400_000
"""Bytes of a notebook that is checked in."""
ADDRESS = re.compile(r" at 0x[0-9a-f]+|/tmp/\S+")
"""What is another one in every process."""

Notebook = dict[str, Any]


def shown(executed: Notebook) -> Notebook:
    """A notebook that has been executed, with no more than what a reader is to see of it."""
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
    """Outputs in which successive pieces of a stream, however it came, are one."""
    found: list[dict[str, Any]] = []
    for output in outputs:
        last = found[-1] if found else {}
        if output["output_type"] == "stream" and last.get("name") == output["name"]:
            last["text"] = [*last["text"], *output["text"]]
        else:
            found.append(output)
    return found


def _seen(output: dict[str, Any]) -> dict[str, Any] | None:
    """An output in its lightest form; None for what a process says of itself."""
    if output["output_type"] == "stream":
        return output if output["name"] == "stdout" else None
    data = output["data"]
    if "image/png" in data:
        data = {"image/png": light(data["image/png"])}
    elif "text/html" in data:
        data = {"text/html": data["text/html"], "text/plain": _short(data["text/plain"])}
    return {**output, "data": data, "metadata": {}}


def light(picture: str) -> str:
    """A picture, in Base64, of few colours."""
    return b64encode(lighter(b64decode(picture))).decode()


def _short(text: list[str] | str) -> str:
    """What stands for an object where no HTML is shown."""
    return "".join(text)[:200]


def texts(notebook: Notebook) -> Iterator[tuple[int, str]]:
    """Number of a cell, and a text that it shows wherever it is executed."""
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
    """Take what a notebook has shown over.

    Returns:
        What is wrong with it; empty if nothing is.
    """
    text = json.dumps(shown(json.loads(executed.read_text("utf-8"))), indent=1, ensure_ascii=False) + "\n"
    kept.write_text(text, encoding="utf-8")
    size = len(text.encode())
    return f"it has {size / 1000:.0f} kB, more than {MOST / 1000:.0f}" if size > MOST else ""


def compare(executed: Path, kept: Path) -> str:
    """Where an execution shows another text than is checked in; empty if nowhere."""
    ran, held = (list(texts(json.loads(path.read_text("utf-8")))) for path in (executed, kept))
    for (number, new), (_, old) in zip(ran, held, strict=False):
        if new != old:
            return f"cell {number} shows\n{new[:600]}\nand not\n{old[:600]}"
    return "" if len(ran) == len(held) else f"{len(ran)} texts are shown, and not {len(held)}"


COMMANDS: dict[str, Callable[[Path, Path], str]] = {"keep": keep, "compare": compare}


def main(command: str) -> int:
    """Run a command on all notebooks; 1 if something is wrong with one."""
    wrong = 0
    for kept in sorted(KEPT.glob("*.ipynb")):
        if said := COMMANDS[command](EXECUTED / kept.name, kept):
            wrong = 1
            print(f"{kept.name}: {said}", file=sys.stderr)
    return wrong


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))

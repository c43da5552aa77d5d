"""Run the blocks of `docs/` that are marked `<!-- not run: nightly -->`, with a given wheel.

A shell block installs a library in a new environment; the Python blocks after it run in this environment.
"""

import os
import re
import runpy
import subprocess
import sys
import tempfile
import venv
from pathlib import Path
from typing import Any

CI = runpy.run_path(str(Path(__file__).with_name("blocks.py")))
TORCH = re.compile(r"^torch==.*$", re.MULTILINE)


def groups(page: Path) -> list[list[Any]]:
    """Return the nightly blocks of a page, grouped by environment."""
    found: list[list[Any]] = []
    for block in CI["blocks"](page):
        if block.not_run == "nightly":
            if block.kind == "sh":
                found.append([])
            found[-1].append(block)
    return found


def run(blocks: list[Any], wheel: str) -> str | None:
    """Run blocks in a new environment that has the wheel; return what is wrong, or None."""
    with tempfile.TemporaryDirectory() as folder:
        pins = Path(folder, "pins.txt")
        pins.write_text(TORCH.findall((CI["ROOT"] / "constraints.txt").read_text("utf-8"))[0], encoding="utf-8")
        venv.create(f"{folder}/venv", with_pip=True)
        path = f"{folder}/venv/bin{os.pathsep}{os.environ['PATH']}"
        environment = {**os.environ, "PATH": path, "PIP_CONSTRAINT": str(pins)}
        environment.pop("PYTHONPATH", None)  # it may lead to a checkout
        subprocess.run(["pip", "install", "--quiet", wheel], env=environment, check=True)
        return CI["run"](blocks, environment)


def main(wheel: str) -> str | None:
    """Run all nightly blocks and print a line for each environment; return what is wrong, or None."""
    failed = []
    for page in CI["PAGES"]:
        for blocks in groups(page):
            wrong = run(blocks, str(Path(wheel).resolve()))
            print(f"{'failed' if wrong else 'OK'}: {blocks[0].place}", flush=True)
            failed += [f"{blocks[0].place}: {wrong}"] if wrong else []
    return "\n".join(failed) or None


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))

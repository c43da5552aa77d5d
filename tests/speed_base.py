"""Speed beside that of an older commit, in turn: `make speed BASE=<commit>`.

Both trees are measured by fresh processes, one after the other and again; the shortest CPU times count. What is
measured is in `speed_public`, of this tree for both. `make speed BASE=HEAD` shows how much the machine itself varies.
"""

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

from rich.console import Console
from rich.table import Table

ROOT = Path(__file__).resolve().parents[1]
ROUNDS, COLD_ROUNDS = 5, 1

SCRIPT = Path(__file__).with_name("speed_public.py")


def measured(tree: Path, *arguments: str) -> dict[str, float]:
    """What a fresh process measures of a tree; imports are looked for in the folder that it stands in."""
    command = [sys.executable, "-c", SCRIPT.read_text(encoding="utf-8"), *arguments]
    environment = {**os.environ, "PYTHONPATH": str(tree)}
    run = subprocess.run(command, cwd=tree, env=environment, check=True, stdout=subprocess.PIPE, text=True)
    found: dict[str, float] = json.loads(run.stdout.splitlines()[-1])
    return found


def table(base: str) -> Table:
    """This tree beside that of a commit."""
    best: dict[str, dict[str, float]] = {base: {}, "now": {}}
    with tempfile.TemporaryDirectory() as folder:
        tree = Path(folder) / "base"
        subprocess.run(["git", "-C", ROOT, "worktree", "add", "--quiet", "--detach", tree, base], check=True)
        try:
            for arguments in [()] * ROUNDS + [("cold",)] * COLD_ROUNDS:
                for name, place in ((base, tree), ("now", ROOT)):
                    for measure, value in measured(place, *arguments).items():
                        best[name][measure] = min(value, best[name].get(measure, value))
        finally:
            subprocess.run(["git", "-C", ROOT, "worktree", "remove", "--force", tree], check=True)
    shown = Table(title=f"Speed beside {base}")
    for heading in ("measure", base, "now", "times as fast"):
        shown.add_column(heading, justify="left" if heading == "measure" else "right")
    for measure, value in best["now"].items():
        before = best[base][measure]
        shown.add_row(measure, f"{before:.4g}", f"{value:.4g}", f"{before / value:.2f}")
    return shown


if __name__ == "__main__":
    Console().print(table(sys.argv[1]))

"""Speed beside that of an older commit, in turn: `make speed BASE=<commit>`.

Both trees are measured by fresh processes, one after the other and again; the shortest CPU times count. What is called
is what users call, so that old commits can be measured, too.
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
ROUNDS = 5

MEASURE = """
import json, os, subprocess, sys, time
from pathlib import Path
import gymnasium as gym
import numpy as np
import grind_env
from grind_env.machine.batch import grind_cycles
from tests.speed import cycles

found = {}

def seconds(call, *arguments):
    begin = time.process_time()
    call(*arguments)
    return time.process_time() - begin

def cycle(name, n, repeats):
    tables = cycles(n)
    strokes = grind_cycles(*(table.copy() for table in tables))
    strokes = (strokes[0] if isinstance(strokes, tuple) else strokes)["strokes"].sum()
    best = min(seconds(grind_cycles, *(table.copy() for table in tables)) for _ in range(repeats))
    found[name] = 1e9 * best / strokes

def step(name, env_id, n, steps):
    env = gym.make_vec(env_id, num_envs=n, autoreset_mode="SameStep")
    env.reset(seed=0)
    actions = np.random.default_rng(0).uniform(-1.0, 1.0, (steps, *env.action_space.shape)).astype(np.float32)
    env.step(actions[0])
    found[name] = 1e6 * sum(seconds(env.step, action) for action in actions) / (steps * n)

for n, repeats in ((256, 20), (4096, 5), (65536, 2)):
    cycle(f"G82 cycles, N = {n}: ns a stroke", n, repeats)
for n, steps in ((1024, 60), (65536, 4)):
    step(f"PowerLimited, N = {n}: us a step", "grind/PowerLimited-v0", n, steps)
for name, steps in (("Reciprocation", 60), ("Stroke", 10), ("WidePlates", 2), ("Job", 2)):
    step(f"{name}, N = 256: us a step", f"grind/{name}-v0", 256, steps)
plate = Path(grind_env.__file__).parent / "examples" / "plate_g82.nc"
subprocess.run([sys.executable, "-m", "grind_env", "run", plate], check=True, stdout=subprocess.DEVNULL)
found["grind run of one plate: s"] = sum(os.times()[2:4])  # of this child, the only one
print(json.dumps(found))
"""


def measured(tree: Path) -> dict[str, float]:
    """What a fresh process measures of a tree."""
    command = [sys.executable, "-c", MEASURE]
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
            for _ in range(ROUNDS):
                for name, place in ((base, tree), ("now", ROOT)):
                    for measure, value in measured(place).items():
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

"""The package is small enough to be read; the bounds may only be lowered."""

import subprocess
from pathlib import Path

ROOT = Path(__file__).parents[1]
MOST_LINES = {
    ("grind_env/*.py", "agents/*.py"): 63_584,
    ("tests/*.py",): 49_447,
    ("docs/tools/*", ".ci/*"): 1_730,
}


def test_no_part_has_more_lines_than_its_bound() -> None:
    for patterns, most in MOST_LINES.items():
        listed = subprocess.check_output(["git", "ls-files", *patterns], cwd=ROOT, text=True).split()
        lines = sum((ROOT / name).read_bytes().count(b"\n") for name in listed)
        assert 0 < lines <= most, f"{patterns}: {lines} lines"

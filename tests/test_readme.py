import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")


def test_the_first_example_runs():
    (example,) = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
    run = subprocess.run([sys.executable, "-c", example], capture_output=True, text=True, check=True, cwd=ROOT)
    lines = run.stdout.splitlines()
    assert sum(line.startswith("G82 ") and line.endswith(" $") for line in lines) == 60
    assert "M30" in lines


def test_the_files_it_names_are_there():
    paths = re.findall(r"\]\(([\w./-]+)\)|`((?:grind_env|agents|notebooks)/[\w./]+)`", README)
    assert paths
    for path in (first or second for first, second in paths):
        assert (ROOT / path).exists(), path


def test_the_commands_it_names_exist():
    targets = re.findall(r"^([\w-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)
    assert set(re.findall(r"make ([a-z]+)", README)) <= set(targets)

"""The tests of hypothesis, with other cases each time: what a long run finds by chance has its hour here."""

import subprocess
import sys
from functools import cache
from pathlib import Path

from tests.soak.part import Part, Tried, broken, clean

ROOT = Path(__file__).parents[2]
OPTIONS = ("-q", "-x", "-p", "tests.soak.given", "-p", "no:cacheprovider")
NOTHING = 5
"""Status of pytest where no test is left."""


@cache
def files() -> tuple[Path, ...]:
    """The files that have such tests."""
    found = (path for path in sorted(ROOT.glob("tests/**/test_*.py")) if "@given" in path.read_text("utf-8"))
    return tuple(path.relative_to(ROOT) for path in found)


def attempt(seed: int) -> Tried:
    """Run a file with the cases of a seed; hypothesis prints the smallest that fails."""
    path = files()[seed % len(files())]
    given = "--hypothesis-profile=long", f"--hypothesis-seed={seed}"
    command = [sys.executable, "-m", "pytest", *OPTIONS, *given, str(path)]
    environment = {**clean(), "HYPOTHESIS_STORAGE_DIRECTORY": "/dev/null"}
    ended = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, check=False)
    if ended.returncode not in (0, NOTHING):
        return broken(str(path), (ended.stdout + ended.stderr)[-8000:])
    return Tried("accepted", sums={str(path): 1})


PART = Part(name="properties", attempt=attempt, seconds=1200.0)

"""Kills a tuning at many of the statements that its database runs: `python -m tests.soak.kills [GROWTH]`.

Each kill comes a step and a share GROWTH of the steps later than the one before, 0.25 of them by default; with 0 every
statement has its kill. `make test` does the same with 1.
"""

import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from tests.agents.test_tune_killed import TRIALS, killed

if __name__ == "__main__":
    with TemporaryDirectory() as folder:
        kills = killed(Path(folder), float(sys.argv[1] if len(sys.argv) > 1 else 0.25))
    for work, count in zip(TRIALS, kills, strict=True):
        print(f"{work.__name__}: killed {count} times, and ended as if it had not been")

"""Random programs that grind, on all their ways: `python -m tests.soak --programs 20000 --seed 1`.

What `check` passes, `machine.grind` grinds or refuses in one sentence; stroke by stroke the same comes of it to the bit
and so it does block by block, compiled or not: wheels to the bit, sums over a run to 1e-9. The results of every hundred
programs are added to a file of the commit, so that a run which was interrupted goes on where it stopped. Exit status 1
tells of findings, 130 of an interruption.
"""

import os
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path

from rich.console import Console
from rich.table import Table

from grind_env.machine.job.text import job_text
from tests.campaign import Record, run
from tests.soak.examine import SLOW, examine
from tests.soak.writer import case

CHUNK = 100
KEPT = 3
"""Findings of a kind whose program and job are kept, of each chunk."""
WARM = 60
"""Programs after which what they need has been compiled."""


def run_chunk(seeds: range) -> Record:
    """Examine the programs of some seeds."""
    warm_up()
    ends: Counter[str] = Counter()
    replays: Counter[str] = Counter()
    constructs: Counter[str] = Counter()
    kinds: Counter[str] = Counter()
    kept: list[Record] = []
    exact, strokes, slowest = [0, 0], 0, (0.0, seeds.start)
    began = time.process_time()
    for seed in seeds:
        before = time.process_time()
        drawn = case(seed)
        examined = examine(drawn)
        slowest = max(slowest, (time.process_time() - before, seed))
        ends[examined.end or "fell"] += 1
        replays[examined.replay or "none"] += 1
        constructs.update(drawn.constructs | examined.happened)
        exact = [a + b for a, b in zip(exact, examined.exact, strict=True)]
        strokes += examined.strokes
        for kind in {finding.kind for finding in examined.findings}:
            kinds[kind] += 1
            if kinds[kind] <= KEPT:
                details = next(finding.details for finding in examined.findings if finding.kind == kind)
                job = job_text(drawn.job)
                kept.append({"kind": kind, "seed": seed, "details": details, "text": drawn.text, "job": job})
    return {
        "first": seeds.start,
        "programs": len(seeds),
        "ends": ends,
        "replays": replays,
        "constructs": constructs,
        "kinds": kinds,
        "exact": exact,
        "strokes": strokes,
        "slowest": list(slowest),
        "cpu": time.process_time() - began,
        "findings": kept,
    }


def warm_up() -> None:
    """Let numba compile, once in each process, what the limit of time is not for."""
    if not WARMED:
        WARMED.append(os.getpid())
        for seed in range(WARM):
            examine(case(seed), seconds=600.0)


WARMED: list[int] = []


def commit() -> str:
    """The commit of the working tree, marked if there are changes."""
    words = ("git", "describe", "--always", "--dirty", "--abbrev=8", "--exclude=*")
    return subprocess.run(words, capture_output=True, text=True, check=True).stdout.strip()


def main() -> int:
    """Run what is not yet done, and report all of it."""
    records, console = run(__doc__, Path("build/soak"), run_chunk, CHUNK, mark=f"{commit()}-")
    _report(records, console)
    return int(any(record["kinds"] for record in records))


def _report(records: list[Record], console: Console) -> None:
    programs, cpu = sum(record["programs"] for record in records), sum(record["cpu"] for record in records)
    strokes = sum(record["strokes"] for record in records)
    for title, key in (("end", "ends"), ("replay", "replays"), ("construct", "constructs"), ("finding", "kinds")):
        counts: Counter[str] = sum((Counter(record[key]) for record in records), Counter())
        table = Table(title, "programs")
        for name, count in counts.most_common():
            table.add_row(name, str(count))
        console.print(table)
    seconds, seed = max(record["slowest"] for record in records)
    same, compared = (sum(record["exact"][k] for record in records) for k in range(2))
    console.print(f"{programs} programs, {strokes} strokes, {programs / cpu:.1f} programs a CPU-second")
    console.print(f"slowest: {seconds:.2f} s (seed {seed}); at most {SLOW:g} s a way")
    console.print(f"wheels after a block, number by number: {same} of {compared} to the bit")


if __name__ == "__main__":
    sys.exit(main())

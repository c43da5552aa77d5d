"""Random programs against the control: `python -m tests.control.fuzz --programs 1000000 --seed 1 --jobs 2`.

Whatever a program holds, the control answers with motions or with a `ControlError` that names line and column; it
does not take long, nor outrun its block budget, nor keep memory. The results of each thousand programs are added to a
file, so that a run which was interrupted goes on where it stopped. Exit status 1 tells of findings, 130 of an
interruption.
"""

import gc
import os
import resource
import sys
import time
from collections import Counter
from pathlib import Path

from rich.console import Console
from rich.table import Table

from tests.campaign import Record, run
from tests.control.fuzz_cases import case
from tests.control.fuzz_examine import Finding, examine, smallest

CHUNK = 1000
WARM = 5
"""Chunks after which the caches of a worker are full."""
MOST_GROWTH = 50.0
"""MB by which a worker may grow after that."""
MEGABYTE = 1 << 20


def run_chunk(seeds: range) -> Record:
    """Examine the programs of some seeds; what is found more than once is shown once, by a small program."""
    ends: Counter[str] = Counter()
    counts: Counter[str] = Counter()
    first: dict[str, Finding] = {}
    slowest = (0.0, seeds.start)
    for seed in seeds:
        begin = time.process_time()
        end, finding = examine(case(seed), seed)
        slowest = max(slowest, (time.process_time() - begin, seed))
        ends[end] += 1
        if finding is not None:
            counts[finding.signature] += 1
            first.setdefault(finding.signature, finding)
    gc.collect()
    return {
        "first": seeds.start,
        "programs": len(seeds),
        "worker": os.getpid(),
        "memory": _memory(),
        "ends": ends,
        "slowest": list(slowest),
        "counts": counts,
        "findings": [smallest(finding).record() for finding in first.values()],
    }


def growth(records: list[Record]) -> dict[int, float]:
    """MB that each worker has grown by since its caches were full."""
    series: dict[int, list[float]] = {}
    for record in records:
        series.setdefault(record["worker"], []).append(record["memory"])
    return {worker: memory[-1] - memory[WARM] for worker, memory in series.items() if len(memory) > WARM + 1}


def main() -> int:
    """Run what is not yet done, and report all of it."""

    def tell(record: Record, console: Console) -> None:
        for finding in record["findings"]:
            console.print(f"[red]{finding['signature']}[/red], seed {finding['seed']}")

    records, console = run(__doc__, Path("build/fuzz"), run_chunk, CHUNK, tell=tell)
    grown = growth(records)
    _report(records, grown, console)
    return int(any(record["counts"] for record in records) or any(mb > MOST_GROWTH for mb in grown.values()))


def _report(records: list[Record], grown: dict[int, float], console: Console) -> None:
    ends: Counter[str] = sum((Counter(record["ends"]) for record in records), Counter())
    counts: Counter[str] = sum((Counter(record["counts"]) for record in records), Counter())
    smallest_of: dict[str, Record] = {}
    for record in records:
        for finding in record["findings"]:
            known = smallest_of.get(finding["signature"])
            if known is None or len(finding["case"]["text"]) < len(known["case"]["text"]):
                smallest_of[finding["signature"]] = finding
    table = Table("end", "programs", title=f"{sum(ends.values())} programs")
    for end, count in ends.most_common():
        table.add_row(end, str(count))
    console.print(table)
    seconds, seed = max(record["slowest"] for record in records)
    console.print(f"slowest: {seconds:.2f} s (seed {seed})")
    console.print("growth of the workers: " + (", ".join(f"{mb:.1f} MB" for mb in grown.values()) or "too few chunks"))
    for signature, count in counts.most_common():
        finding = smallest_of[signature]
        console.rule(f"{signature}, {count} times, seed {finding['seed']}")
        console.print(finding["case"]["text"], markup=False, highlight=False)
        console.print(f"{finding['case']['settings']} {finding['case']['actions']}", markup=False, highlight=False)
        console.print(finding["details"], markup=False, highlight=False)


def _memory() -> float:
    """Memory of this process, MB; where the system does not tell, the most it has had."""
    status = Path("/proc/self/statm")
    if status.exists():
        return int(status.read_text().split()[1]) * resource.getpagesize() / MEGABYTE
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


if __name__ == "__main__":
    sys.exit(main())

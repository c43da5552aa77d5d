"""Random programs against the control: `python -m tests.control.fuzz --programs 1000000 --seed 1 --jobs 2`.

Whatever a program holds, the control answers with motions or with a `ControlError` that names line and column; it
does not take long, nor outrun its block budget, nor keep memory. The results of each thousand programs are added to a
file, so that a run which was interrupted goes on where it stopped. Exit status 1 tells of findings, 130 of an
interruption.
"""

import argparse
import gc
import json
import os
import resource
import sys
import time
from collections import Counter
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import Progress
from rich.table import Table

from tests.control.fuzz_cases import case
from tests.control.fuzz_examine import Finding, examine, smallest

CHUNK = 1000
STREAM = 1 << 32
"""Programs of one --seed; those of different seeds do not meet."""
WARM = 5
"""Chunks after which the caches of a worker are full."""
MOST_GROWTH = 50.0
"""MB by which a worker may grow after that."""
MEGABYTE = 1 << 20
INTERRUPTED = 130

Record = dict[str, Any]


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
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--programs", type=int, default=20_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--out", type=Path, default=Path("build/fuzz"), help="folder of the results")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    path = options.out / f"seed-{options.seed}.jsonl"
    console = Console(stderr=True)
    records = [json.loads(line) for line in path.read_text().splitlines()] if path.exists() else []
    known = {(record["first"], record["programs"]) for record in records}
    origin = options.seed * STREAM
    end = origin + options.programs
    chunks = [range(start, min(start + CHUNK, end)) for start in range(origin, end, CHUNK)]
    left = [chunk for chunk in chunks if (chunk.start, len(chunk)) not in known]
    with (
        Progress(console=console) as progress,
        ProcessPoolExecutor(options.jobs) as pool,
        path.open("a") as results,
    ):
        done = options.programs - sum(map(len, left))
        task = progress.add_task("programs", total=options.programs, completed=done)
        futures = [pool.submit(run_chunk, chunk) for chunk in left]
        try:
            for future in as_completed(futures):
                record = future.result()
                records.append(record)
                results.write(json.dumps(record) + "\n")
                results.flush()
                progress.advance(task, record["programs"])
                for finding in record["findings"]:
                    progress.console.print(f"[red]{finding['signature']}[/red], seed {finding['seed']}")
        except (KeyboardInterrupt, BrokenProcessPool):
            pool.shutdown(wait=False, cancel_futures=True)
            console.print("interrupted; the same command goes on from here")
            return INTERRUPTED
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

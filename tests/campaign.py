"""Runs many random programs in processes, and goes on where a run was interrupted."""

import argparse
import json
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import MofNCompleteColumn, Progress, TimeRemainingColumn

STREAM = 1 << 32
"""Programs of one --seed; those of different seeds do not meet."""
INTERRUPTED = 130

Record = dict[str, Any]


def run(
    description: str | None,
    folder: Path,
    run_chunk: Callable[[range], Record],
    size: int,
    *,
    mark: str = "",
    tell: Callable[[Record, Console], object] = lambda record, console: None,
) -> tuple[list[Record], Console]:
    """Run what the command line asks for and is not yet done.

    Args:
        description: of the command.
        folder: of the results by default.
        run_chunk: the record of the programs of some seeds, with `first` and `programs`.
        size: of a chunk.
        mark: before the name of the file of the results.
        tell: is given each new record.

    Returns:
        All records of the file, and where to report them.

    Raises:
        SystemExit: it was interrupted.
    """
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--programs", type=int, default=20_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--seconds", type=float, help="begin no further chunk of programs after so many s")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--out", type=Path, default=folder, help="folder of the results")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    path = options.out / f"{mark}seed-{options.seed}.jsonl"
    console = Console(stderr=True)
    records = [json.loads(line) for line in path.read_text().splitlines()] if path.exists() else []
    known = {(record["first"], record["programs"]) for record in records}
    origin = options.seed * STREAM
    end = origin + options.programs
    chunks = [range(start, min(start + size, end)) for start in range(origin, end, size)]
    left = [chunk for chunk in chunks if (chunk.start, len(chunk)) not in known]
    columns = (*Progress.get_default_columns()[:3], MofNCompleteColumn(), TimeRemainingColumn())
    began = time.monotonic()
    with (
        Progress(*columns, console=console) as progress,
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
                tell(record, progress.console)
                if options.seconds is not None and time.monotonic() - began > options.seconds:
                    pool.shutdown(cancel_futures=True)
                    break
        except (KeyboardInterrupt, BrokenProcessPool):
            pool.shutdown(wait=False, cancel_futures=True)
            console.print("interrupted; the same command goes on from here")
            raise SystemExit(INTERRUPTED) from None
    console.print(f"results in {path}")
    return records, console

"""Hostile and random cases against everything, for as long as one likes: `python -m tests.soak --minutes 60`.

Parts take turns; each draws case k from seed k, tries it, and has it accepted, refused in a sentence, or fallen. The
counts are kept in a file of the commit, and every further run adds to them, also where it was interrupted. A case is
repeated by `--part NAME --seed K`. Exit status 1 tells that something has fallen, 130 of an interruption.
"""

import argparse
import signal
import sys
from importlib import import_module
from pathlib import Path

from rich.console import Console
from rich.table import Table

from tests.soak.counts import Counts, load
from tests.soak.part import Part, Tried, attempted
from tests.soak.turns import run

NAMES = ["programs", "texts", "files", "calls", "steps", "kills", "surroundings"]
"""Modules beside this one."""
INTERRUPTED = 130


def part_of(name: str) -> Part:
    """The part by that name."""
    found: Part = import_module(f"tests.soak.{name}").PART
    return found


def main(words: list[str] | None = None) -> int:
    """Run, and report all that the file of the commit holds."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--minutes", type=float, default=60.0)
    parser.add_argument("--part", nargs="+", choices=NAMES, default=NAMES, metavar="NAME", help=", ".join(NAMES))
    parser.add_argument("--seed", type=int, help="try this case alone, here, and show how it ends")
    parser.add_argument("--jobs", type=int, default=2, help="processes side by side")
    parser.add_argument("--out", type=Path, default=Path("build/soak"), help="folder of the counts")
    options = parser.parse_args(words)
    parts, console = [part_of(name) for name in options.part], Console(stderr=True, markup=False, highlight=False)
    if options.seed is not None:
        return _repeat(parts, options.seed, console)
    counts = load(options.out)
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(128 + signal.SIGTERM))  # what it has begun ends with it

    def told(name: str, seed: int, tried: Tried) -> None:
        if tried.end == "fallen":
            console.print(f"fallen: {name}, seed {seed}: {tried.kind}")

    run(parts, counts, 60.0 * options.minutes, options.jobs, told)
    report(counts, console)
    return int(any(count.kinds for count in counts.parts.values()))


def _repeat(parts: list[Part], seed: int, console: Console) -> int:
    for part in parts:
        part.prepare()
        tried = attempted(part, seed)
        console.print(f"{part.name}, seed {seed}: {tried.end} {tried.kind}\n{tried.details}")
        console.print({**tried.sums, **tried.most})
    return int(tried.end == "fallen")


def report(counts: Counts, console: Console) -> None:
    """Print what has been tried, how it ended, what was counted on the way, and what has fallen."""
    for name, count in counts.parts.items():
        table = Table("counted", "sum", title=name)
        for each, value in sorted(count.sums.items(), key=lambda item: -item[1]):
            table.add_row(each, f"{value:,.0f}")
        for each, value in count.most.items():
            table.add_row(f"most: {each}", f"{value:.3g}")
        console.print(table)
    table = Table("part", *("tried", "accepted", "refused", "fallen", "hours"))
    for name, count in counts.parts.items():
        ends = [f"{count.ends.get(end, 0):,}" for end in ("accepted", "refused", "fallen")]
        table.add_row(name, f"{count.tried:,}", *ends, f"{count.seconds / 3600.0:.2f}")
    console.print(table)
    for name, count in counts.parts.items():
        for kind, often in count.kinds.items():
            seeds = [fall.seed for fall in count.falls if fall.kind == kind]
            details = next((fall.details for fall in count.falls if fall.kind == kind), "")
            console.rule(f"{name}: {kind}, {often} times, seeds {seeds}")
            console.print(details)
    console.print(f"counts in {counts.path}")


if __name__ == "__main__":
    try:
        sys.exit(main())
    except KeyboardInterrupt:
        print("interrupted; the same command goes on from here", file=sys.stderr)
        sys.exit(INTERRUPTED)

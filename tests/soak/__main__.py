"""Attack the package with hostile and random cases: `python -m tests.soak --minutes 60`.

The parts take turns. Each draws case k from seed k and tries it; the case is accepted, refused with an error sentence,
or it fails. The results of a commit are in one file; later runs add to it, also after an interruption.
`--part NAME --seed K` repeats a case. Exit status: 1 if a case failed, 130 after an interruption.
"""

import argparse
import signal
import sys
from importlib import import_module
from pathlib import Path

from rich.console import Console
from rich.table import Table

from tests.soak.log import Log, log_in
from tests.soak.part import Part, attempted
from tests.soak.turns import run

MODULES = {"texts": "tests.control.fuzz_examine"}
#: names of the parts, which are modules of this folder unless `MODULES` names another
NAMES = ["programs", "texts", "files", "calls", "kills", "surroundings"]
INTERRUPTED = 130


def part_of(name: str) -> Part:
    """Return the part with a name."""
    found: Part = import_module(MODULES.get(name, f"tests.soak.{name}")).PART
    return found


def main(words: list[str] | None = None) -> int:
    """Run the parts and report all results of the commit; return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--minutes", type=float, default=60.0)
    parser.add_argument("--part", nargs="+", choices=NAMES, default=NAMES, metavar="NAME", help=", ".join(NAMES))
    parser.add_argument("--seed", type=int, help="try only this case, in this process, and print its result")
    parser.add_argument("--jobs", type=int, default=2, help="processes side by side")
    parser.add_argument("--out", type=Path, default=Path("build/soak"), help="folder of the results")
    options = parser.parse_args(words)
    parts, console = [part_of(name) for name in options.part], Console(stderr=True, markup=False, highlight=False)
    if options.seed is not None:
        return _repeat(parts, options.seed, console)
    log = log_in(options.out)
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(128 + signal.SIGTERM))  # ends its processes, too
    run(parts, log, 60.0 * options.minutes, options.jobs)
    report(log, console)
    return int(any(count.falls for count in log.counts().values()))


def _repeat(parts: list[Part], seed: int, console: Console) -> int:
    for part in parts:
        part.prepare()
        tried = attempted(part, seed)
        console.print(f"{part.name}, seed {seed}: {tried.end} {tried.kind}\n{tried.details}")
        console.print({**tried.sums, **tried.most})
    return int(tried.end == "fallen")


def report(log: Log, console: Console) -> None:
    """Print the sums, the numbers of results and the failures of each part."""
    counts = log.counts()
    for name, count in counts.items():
        table = Table("counted", "sum", title=name)
        for each, value in sorted(count.sums.items(), key=lambda item: -item[1]):
            table.add_row(each, f"{value:,.0f}")
        for each, value in count.most.items():
            table.add_row(f"most: {each}", f"{value:.3g}")
        console.print(table)
    table = Table("part", *("tried", "accepted", "refused", "failed", "hours"))
    for name, count in counts.items():
        ends = [f"{count.ends[end]:,}" for end in ("accepted", "refused", "fallen")]
        table.add_row(name, f"{len(count.ended):,}", *ends, f"{count.seconds / 3600.0:.2f}")
    console.print(table)
    for name, count in counts.items():
        for kind, falls in count.falls.items():
            console.rule(f"{name}: {kind}, {len(falls)} times, seeds {[seed for seed, _ in falls[:5]]}")
            console.print(falls[0][1])
    console.print(f"results in {log.path}")


if __name__ == "__main__":
    try:
        sys.exit(main())
    except KeyboardInterrupt:
        print("interrupted; the same command resumes the run", file=sys.stderr)
        sys.exit(INTERRUPTED)

"""Judge the process model: `python -m grind_env.validation`. Exit status 1 if a row is not as known."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from grind_env.files import check_target
from grind_env.process.catalogue import load_catalogue
from grind_env.terminal import command, table_console
from grind_env.validation import Rig, is_as_known, validate
from grind_env.validation.export import write_csv
from grind_env.validation.leave_out import left_out
from grind_env.validation.neighbours import neighbours
from grind_env.validation.report import WIDTH, print_report


def main(arguments: Sequence[str]) -> int:
    """Print the report, and write the rows to a file if one is named; returns the exit status."""
    parser = argparse.ArgumentParser(prog="python -m grind_env.validation", description=__doc__)
    parser.add_argument("--csv", type=Path, metavar="FILE", help="write all rows to this CSV file, too")
    file: Path | None = parser.parse_args(arguments).csv
    if file is not None:
        check_target(file)
    catalogue = load_catalogue()
    rows = validate(catalogue)
    console = table_console()
    console.width = min(console.width, WIDTH)
    print_report(rows, left_out(Rig(catalogue)), neighbours(catalogue, rows), console)
    if file is not None:
        write_csv(rows, file)
    return 0 if all(map(is_as_known, rows)) else 1


if __name__ == "__main__":
    with command("validation"):
        status = main(sys.argv[1:])
    sys.exit(status)

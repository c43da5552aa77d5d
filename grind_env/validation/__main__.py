"""`python -m grind_env.validation`: validate the process model. Exit status 1 after an unexpected result."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from grind_env.command_exit import command
from grind_env.files import check_target
from grind_env.terminal_output import table_console
from grind_env.validation import is_expected, validate
from grind_env.validation.mutations import mutate
from grind_env.validation.report import WIDTH, print_mutations, print_report, write_csv


def main(arguments: Sequence[str]) -> int:
    """Print the report, and write the rows to a file if one is named; returns the exit status."""
    parser = argparse.ArgumentParser(prog="python -m grind_env.validation", description=__doc__)
    parser.add_argument("--csv", type=Path, metavar="FILE", help="write all rows to this CSV file, too")
    parser.add_argument(
        "--mutate", action="store_true", help="change one law of the process at a time and list the rows that then fail"
    )
    options = parser.parse_args(arguments)
    console = table_console()
    console.width = min(console.width, WIDTH)
    if options.mutate:
        found = mutate()
        print_mutations(found, console)
        return 0 if all(each.is_expected for each in found) else 1
    file: Path | None = options.csv
    if file is not None:
        check_target(file)
    rows = validate()
    print_report(rows, console)
    if file is not None:
        write_csv(rows, file)
    return 0 if all(map(is_expected, rows)) else 1


if __name__ == "__main__":
    with command("validation"):
        status = main(sys.argv[1:])
    sys.exit(status)

"""Judge the process model: `python -m grind_env.validation`. Exit status 1 if a row is not as known."""

import sys

from grind_env.process.catalogue import load_catalogue
from grind_env.terminal import command, table_console
from grind_env.validation import Rig, is_as_known, validate
from grind_env.validation.neighbours import neighbours
from grind_env.validation.report import print_report
from grind_env.validation.valve_alloys import predictions


def main() -> int:
    """Print the report; returns the exit status."""
    catalogue = load_catalogue()
    rows = validate(catalogue)
    print_report(rows, predictions(Rig(catalogue)), neighbours(catalogue, rows), table_console())
    return 0 if all(map(is_as_known, rows)) else 1


if __name__ == "__main__":
    with command("validation"):
        status = main()
    sys.exit(status)

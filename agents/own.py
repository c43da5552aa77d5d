"""Tables that a command of `python -m agents` writes in a folder that may be somebody's: it replaces its own alone."""

import re
from collections.abc import Mapping
from pathlib import Path

from grind_env.targets import Own, check_own


def check_tables(folder: Path, command: str, begins: Mapping[str, str]) -> None:
    """Find out whether a folder has files under the names of tables that are none of a command's.

    Args:
        folder: that `--results` names.
        command: as `python -m agents` knows it.
        begins: how each file begins, by its name.

    Raises:
        FileError: it has.
    """
    for name, begin in begins.items():
        own = Own(f"table of `python -m agents {command}`", re.compile(re.escape(begin.encode())).match)
        check_own(folder / name, own, "--results")

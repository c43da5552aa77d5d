"""Update the records of environments and programs after an intended change of their behaviour.

    python -m tests.behaviour.record [NAME ...]

NAME is a registered id or a part program, such as `PowerLimited-v0` or `plate_g82`; without names, all are recorded.
The command prints changed columns with their largest difference, for CHANGELOG.md; new columns are listed apart.
If an environment changes, increase `TASK_VERSION`: agents were trained on every entry and every bit of it.
"""

import sys

from tests.behaviour import environments, programs
from tests.behaviour.tables import RECORDS, Tables, additions, changes, load, save
from tests.envs.harness import every_id


def subjects() -> list[str]:
    """Return the names of all records."""
    return [*(env_id.removeprefix("grind/") for env_id in every_id()), *programs.programs()]


def found(name: str) -> Tables:
    """Run the environment or program `name`; return the tables of its behaviour."""
    return programs.recorded(name) if name in programs.programs() else environments.recorded(f"grind/{name}")


def main(names: list[str]) -> int:
    """Record the named environments and programs, all without names; return the exit status."""
    known = subjects()
    unknown = [name for name in names if name not in known]
    if unknown:
        print(f"there is no {unknown[0]} to record; there are {', '.join(known)}", file=sys.stderr)
        return 2
    for name in names or known:
        tables = found(name)
        was = load(name)
        moved, new = changes(was, tables, programs.TOLERANCES.get(name, 0.0)), additions(was, tables)
        if moved or new:
            save(name, tables)
        state = "recorded anew" if moved else "as recorded, with more columns" if new else "as recorded"
        print("\n  ".join([f"{name}: {state}", *moved, *new]))
    for path in () if names else RECORDS.glob("*.npz"):
        if path.stem not in known:
            path.unlink()
            print(f"{path.stem}: removed, because this id or program no longer exists")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

"""Records anew what environments and programs do, after it has been changed on purpose.

    python -m tests.behaviour.record [NAME ...]

A name is that of a registered id or of a part program, such as `PowerLimited-v0` or `plate_g82`; without names all are
recorded. What has moved, and by how much at most, is printed for the line that such a change gets in CHANGELOG.md;
columns that are only new are told apart from it. An environment that moves is a task of another `TASK_VERSION`: agents
have been trained on every entry and every bit of it.
"""

import sys

from tests.behaviour import environments, programs
from tests.behaviour.tables import RECORDS, Tables, additions, changes, load, save
from tests.envs.harness import every_id


def subjects() -> list[str]:
    """The names of all records."""
    return [*(env_id.removeprefix("grind/") for env_id in every_id()), *programs.programs()]


def found(name: str) -> Tables:
    """What the environment or the program of that name does now."""
    return programs.recorded(name) if name in programs.programs() else environments.recorded(f"grind/{name}")


def main(names: list[str]) -> int:
    """Record what is named; returns the exit status."""
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
            print(f"{path.stem}: removed, there is no such id or program any more")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

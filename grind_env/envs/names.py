"""Names of the tasks and ids of their environments: all that registration needs, and quick to import."""

from pathlib import Path

FOLDER = Path(__file__).with_name("tasks")
"""Where the task files lie."""


def task_names() -> list[str]:
    """Names of the tasks that have a file."""
    return sorted(path.stem for path in FOLDER.glob("*.toml"))


def environment_id(name: str) -> str:
    """The Gymnasium id of a task: `power_limited` is `grind/PowerLimited-v0`, `CBN` is `grind/CBN-v0`."""
    return f"grind/{''.join(word[:1].upper() + word[1:] for word in name.split('_'))}-v0"

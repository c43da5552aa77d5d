"""Names of tasks and ids of their environments: all that registration needs, quick to import."""

from pathlib import Path

FOLDER = Path(__file__).with_name("tasks")  #: folder of the task files

#: names of ids with a module of their own in `grind_env.envs.ids`; some have a task file, too
MODULE_NAMES = tuple(sorted({path.stem for path in Path(__file__).with_name("ids").glob("[a-z]*.py")}))

#: tasks of the benchmark, each with a demand of its own; the other tasks are diagnostic
CORE = ("power_limited", "reciprocation", "wide_plates", "wide_rails", "blades", "rush", "job_shop")

ANY_TASK = "grind/Task-v0"  #: id of all tasks in files of users


def task_names() -> list[str]:
    """Return the names of the tasks whose ids have no module of their own."""
    return [name for name in shipped_names() if name not in MODULE_NAMES]


def shipped_names() -> list[str]:
    """Return the names of all task files of the package."""
    return sorted(path.stem for path in FOLDER.glob("*.toml"))


def environment_id(name: str) -> str:
    """Return the Gymnasium id of a task: `power_limited` is `grind/PowerLimited-v0`, `CBN` is `grind/CBN-v0`."""
    return f"grind/{''.join(word[:1].upper() + word[1:] for word in name.split('_'))}-v0"

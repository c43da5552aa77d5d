"""Tuned parameters of the scripted policies: a TOML file for each task, `parameters/<task>.toml`.

Parameters of the package's tasks and example programs come with the package; parameters of a user's files lie below the
current folder.
"""

import re
import shlex
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from grind_env.envs.tasks import Task
from grind_env.envs.tasks.reading import is_file
from grind_env.errors import GrindError
from grind_env.files import ReadError, write_atomically
from grind_env.message_text import reason
from grind_env.output_checks import FileKind
from grind_env.task_version import TASK_VERSION, of_version
from grind_env.toml import TomlError, read_toml, toml_text

CONFIGS = Path(__file__).with_name("parameters")  #: folder of the package's parameters
OWN = Path("runs", "parameters")  #: folder of the parameters of a user's files

HEADING = "# Parameters of the scripted policies for "
VERSION = "task_version"  #: key of the version of the tasks that a file is tuned for
TUNED_FILE = FileKind("file of tuned parameters", re.compile(rf"{HEADING}|{VERSION} *=".encode()).match)

Value = float | int | list[float] | list[int]
Parameters = Mapping[str, Value]


class ConfigError(GrindError):
    """Tuned parameters that are missing or do not fit the policy."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Tuned:
    """Outcome of tuning one policy.

    `training_cost` and `validation_cost` are $ per episode, means over the training and the validation seeds, given as
    [first, count]; `parameters` are in the units of the policy.
    """

    parameters: Parameters
    training_cost: float
    validation_cost: float
    evaluations: int
    training_seeds: list[int]
    validation_seeds: list[int]


def tuned_folder(task: Task, folder: Path | None = None) -> Path:
    """Return the folder of a task's parameters: the given one, the package's, or the user's."""
    return folder or (OWN if task.file else CONFIGS)


def tune_command(name: str, task: Task, folder: Path | None = None) -> str:
    """Return the command that tunes a policy for a task, for messages."""
    words = ["python", "-m", "agents", "tune", "--task", task.file or task.name, "--policies", name]
    words += [] if folder is None else ["--parameters", str(folder)]
    with_job = " with the same --job and --parts" if task.file and not is_file(task.file) else ""
    return f"`{shlex.join(words)}`{with_job}"


def read_tuned(task: str, folder: Path = CONFIGS) -> dict[str, Tuned]:
    """Return the tuned policies of a task by name; empty if the task has no file of the present task version.

    Raises:
        ConfigError: if the file is not what `write_tuned` writes.
    """
    version, tuned = _read(task, folder)
    return tuned if version == TASK_VERSION else {}


def _read(task: str, folder: Path) -> tuple[object, dict[str, Tuned]]:
    """Return the task version of a file of parameters, None if it is missing, and the policies of the file."""
    path = folder / f"{task}.toml"
    if not path.exists():
        return TASK_VERSION, {}
    try:
        document = dict(read_toml(path))
        version = document.pop(VERSION, None)
        return version, {name: Tuned(**table) for name, table in document.items()}
    except (ReadError, TomlError, TypeError) as error:
        raise ConfigError(f"{path} is damaged ({reason(error)}): tune again with --fresh") from error


def tuned_arguments(name: str, task: Task, folder: Path | None = None) -> dict[str, Any]:
    """Return keyword arguments of a policy, as tuned for the task; the folder comes from `tuned_folder` if None.

    Raises:
        ConfigError: if the policy has not been tuned for the task yet, or for another version of it.
    """
    place = tuned_folder(task, folder)
    version, tuned = _read(task.name, place)
    path, remedy = f"{place / task.name}.toml", f"run {tune_command(name, task, folder)}"
    if version != TASK_VERSION:
        raise ConfigError(f"the parameters in {path} are {of_version(version)}: {remedy}")
    if name not in tuned:
        raise ConfigError(f"{name} has no parameters in {path}: {remedy}")
    return arguments(tuned[name].parameters)


def write_tuned(task: str, tuned: Mapping[str, Tuned], folder: Path = CONFIGS) -> None:
    """Write the file of a task in one atomic step."""
    heading = f"{HEADING}{task}, written by `python -m agents tune`."
    units = "# E is in mm/min; costs are $ per episode; seeds are [first, count]."
    content = toml_text({VERSION: TASK_VERSION, **{name: asdict(entry) for name, entry in tuned.items()}})
    write_whole(folder / f"{task}.toml", f"{heading}\n{units}\n{content}\n")


def write_whole(path: Path, text: str) -> None:
    """Write a file in one atomic step; make its folder if necessary.

    Raises:
        GrindError: the folder cannot be made or written to.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ConfigError(f"the folder {path.parent} cannot be made: {error.strerror}") from None
    write_atomically(path, lambda partial: partial.write_text(text, encoding="utf-8", newline="\n"))


def arguments(parameters: Parameters) -> dict[str, Any]:
    """Return parameters as keyword arguments of a policy; lists, with one entry per kind of block, become tuples."""
    return {key: tuple(value) if isinstance(value, list) else value for key, value in parameters.items()}

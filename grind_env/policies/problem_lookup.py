"""Problems by name: an environment, a task file, or a part program with its job."""

import functools
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import gymnasium as gym

from grind_env.envs.arguments import check_file, check_parts
from grind_env.envs.job.loading import EXAMPLE
from grind_env.envs.job.repeated_program import MOST_PARTS, batch_name
from grind_env.envs.simulation import Simulation
from grind_env.envs.task_names import ANY_TASK, environment_id, shipped_names
from grind_env.envs.tasks.reading import is_file as is_task_file
from grind_env.errors import GrindError
from grind_env.files import is_file, missing
from grind_env.message_text import did_you_mean, quoted

JOB = "grind/Job-v0"


class ProblemError(GrindError):
    """Unknown environment, or an environment in which E and D cannot be chosen."""


@dataclass(frozen=True)
class Problem:
    """Environment with its arguments; after an edit of its file find the problem again."""

    name: str  #: name in tables and folders
    id: str  #: id of Gymnasium
    arguments: tuple[tuple[str, Any], ...] = ()  #: arguments of `gym.make` that differ between problems

    def make(self, **arguments: Any) -> gym.Env[Any, Any]:
        """Return the environment with measured observations; further arguments as for `gym.make`.

        Raises:
            GrindError: a file of the problem is faulty.
        """
        return gym.make(self.id, **{"observation": "measured", **dict(self.arguments), **arguments})

    def make_vec(self, num_envs: int, **arguments: Any) -> Any:
        """Return the native vector environment, without wrappers; further arguments as for `gym.make_vec`.

        Raises:
            GrindError: a file of the problem is faulty.
        """
        return gym.make_vec(
            self.id,
            num_envs,
            vectorization_mode="vector_entry_point",
            **{"observation": "measured", **dict(self.arguments), **arguments},
        )

    def simulation(self) -> Simulation:
        """Return the simulation on which policies are evaluated.

        Raises:
            GrindError: a file of the problem is faulty.
        """
        return self._simulation

    @functools.cached_property
    def _simulation(self) -> Simulation:
        made: Any = self.make().unwrapped
        simulation: Simulation = made.simulation
        return simulation

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle the inputs: another process makes its own simulation."""
        return Problem, (self.name, self.id, self.arguments)


def find_problem(text: str, job: str | None = None, parts: int = 1) -> Problem:
    """Return the problem of a name.

    Args:
        text: an id such as `grind/PowerLimited-v0`, the name of its task (`power_limited`), a task file (.toml), or a
            part program (any other file).
        job: job file of a part program; its name with `.toml` if None.
        parts: number of runs of a part program.

    Raises:
        ProblemError: no problem with choices of E and D has this name, or a task of the package has the file's name.
        TaskError: `parts` is out of range, or `job` is not the name of a file.
        ReadError: the file does not exist.
    """
    if not isinstance(text, str):
        raise ProblemError(f"a problem is named by a text, but not by {quoted(text)}: give an id or the path of a file")
    names = shipped_names()
    of_package = next((name for name in names if text in (name, environment_id(name))), None)
    program = None if of_package or is_task_file(text) else text
    if program is None and (job is not None or parts != 1):
        raise ProblemError(f"{quoted(text)} is no part program: leave out its job and its parts")
    if of_package:
        return Problem(of_package, environment_id(of_package))
    if program is None:
        path = Path(text).absolute()
        return Problem(_own_name(path, path.stem), ANY_TASK, (("task", str(path)),))
    if program == JOB or is_file(Path(program)):
        return _of_program(None if program == JOB else program, job, parts)
    if Path(text).suffix:
        raise missing(Path(text))
    like = did_you_mean(text, [*names, *map(environment_id, names)])
    raise ProblemError(
        f"there is no problem {quoted(text)}{like}: give one of {', '.join(names)}, an id, a task file (.toml), or"
        " a part program"
    )


def _of_program(program: str | None, job: str | None, parts: int) -> Problem:
    check_file("job", job)
    check_parts(parts, MOST_PARTS)
    path = EXAMPLE if program is None else Path(program).absolute()
    given = {"program": program and str(path), "job": job and str(Path(job).absolute()), "parts": parts}
    return Problem(
        _own_name(path, batch_name(path, parts)),
        JOB,
        tuple((key, value) for key, value in given.items() if value is not None),
    )


def _own_name(path: Path, name: str) -> str:
    """Return the name of a file's problem, for tables and folders."""
    if not name.isprintable():
        raise ProblemError(f"{quoted(str(path))} has a name that cannot be printed: rename the file")
    if environment_id(name) in map(environment_id, shipped_names()):
        raise ProblemError(
            f"{path} has the name of a task of this package, and its results would take the place"
            f" of those of {name}: rename the file"
        )
    return name

"""What is to be decided: an environment, a task file, or a part program with its job, as one names it anywhere."""

import functools
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import gymnasium as gym

from grind_env.envs.job.env import EXAMPLE
from grind_env.envs.job.text import batch_name
from grind_env.envs.names import OTHERS, environment_id, task_names
from grind_env.envs.simulation import Simulation
from grind_env.errors import GrindError, quoted

JOB, TASK = "grind/Job-v0", "grind/Task-v0"


class ProblemError(GrindError):
    """There is no such environment, or none in which E and D are chosen."""


@dataclass(frozen=True, slots=True)
class Problem:
    """An environment with its arguments.

    Attributes:
        name: in tables and folders.
        id: of Gymnasium.
        arguments: of `gym.make`, beside those that are the same for all problems.
    """

    name: str
    id: str
    arguments: tuple[tuple[str, Any], ...] = ()

    def make(self, **arguments: Any) -> gym.Env[Any, Any]:
        """The environment, with what is measured; further arguments as for `gym.make`.

        Raises:
            GrindError: a file of it is faulty.
        """
        return gym.make(self.id, **{"observation": "measured", **dict(self.arguments), **arguments})

    def make_vec(self, num_envs: int, **arguments: Any) -> Any:
        """Its native vector environment, without wrappers; further arguments as for `gym.make_vec`.

        Raises:
            GrindError: a file of it is faulty.
        """
        return gym.make_vec(
            self.id,
            num_envs,
            vectorization_mode="vector_entry_point",
            **{"observation": "measured", **dict(self.arguments), **arguments},
        )

    def simulation(self) -> Simulation:
        """What policies are evaluated on.

        Raises:
            GrindError: a file of it is faulty.
        """
        return _simulation(self)


@functools.lru_cache(maxsize=16)
def _simulation(problem: Problem) -> Simulation:
    made: Any = problem.make().unwrapped
    simulation: Simulation = made.simulation
    return simulation


def find_problem(text: str, job: str | None = None, parts: int = 1) -> Problem:
    """The problem that a text names.

    Args:
        text: an id such as `grind/PowerLimited-v0`, the name of its task (`power_limited`), a task file (.toml), or a
            part program (any other file).
        job: job file of a part program; its name with `.toml` if None.
        parts: how often a part program is run.

    Raises:
        ProblemError: it names none in which E and D are chosen.
    """
    names = [name for name in (*task_names(), *OTHERS) if name not in ("job", "wen")]
    for name in names:
        if text in (name, environment_id(name)):
            return Problem(name, environment_id(name))
    if text == JOB:
        return _of_program(None, job, parts)
    path = Path(text)
    if path.suffix == ".toml":
        if path.stem in names:
            raise ProblemError(
                f"{text} has the name of a task of this package, and its results would take the place"
                f" of those of {path.stem}: rename the file"
            )
        return Problem(path.stem, TASK, (("task", text),))
    if path.is_file():
        return _of_program(text, job, parts)
    raise ProblemError(
        f"there is no problem {quoted(text)}: give one of {', '.join(names)}, an id, a task file (.toml), or"
        " a part program"
    )


def _of_program(program: str | None, job: str | None, parts: int) -> Problem:
    given = {"program": program, "job": job, "parts": parts}
    return Problem(
        batch_name(EXAMPLE if program is None else Path(program), parts),
        JOB,
        tuple((key, value) for key, value in given.items() if value is not None),
    )

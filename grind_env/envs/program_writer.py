"""Protocol for writing an episode as a part program, for tasks and users' programs."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any, NamedTuple

from grind_env.envs.episode_state import Episodes
from grind_env.machine.job import Job
from grind_env.machine.record import GrindingRecord


class Written(NamedTuple):
    """An episode for the machine: `machine.grind` runs it to the same record."""

    program: str  #: the part program
    job: Job  #: its job, with the wheel, the lots and the stocks of the episode
    #: times of the control, s, at which the operator asks for a dress while the program runs
    requests: tuple[float, ...] = ()


class ProgramWriter(ABC):
    """Writer of episodes of a simulation as part programs."""

    @abstractmethod
    def block(self, episodes: Episodes, i: int, speed: float, executions: float, pre_dress: float = 0.0) -> Any:
        """Return the next step of episode i, in the form that the methods below take."""

    @abstractmethod
    def text(self, block: Any) -> str:
        """Return the program text of a step."""

    @abstractmethod
    def program(self, blocks: Sequence[Any]) -> str:
        """Return the part program of an episode of these steps, with its dress program.

        Steps of a user's program that have not been taken keep their own words.

        Raises:
            GrindError: no single text can hold these steps.
        """

    @abstractmethod
    def written(self, episodes: Episodes, i: int, blocks: Sequence[Any]) -> Written:
        """Return program and job of episode i after these steps, at least one."""

    @abstractmethod
    def record(self, episodes: Episodes, i: int, blocks: Sequence[Any]) -> GrindingRecord:
        """Return strokes, dresses and finished parts of episode i up to the coming block, as `machine.grind` would."""

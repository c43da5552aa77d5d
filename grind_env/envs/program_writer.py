"""Protocol for writing an episode as a part program, for tasks and users' programs."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any, NamedTuple

from grind_env.envs.episodes import Episodes
from grind_env.machine.job import Job
from grind_env.machine.record import GrindingRecord


class Written(NamedTuple):
    """An episode as one takes it to the machine: `machine.grind` makes of it what the episode was."""

    program: str
    """The part program."""
    job: Job
    """Its job, with the wheel, the lots and the stocks of the episode."""
    requests: tuple[float, ...] = ()
    """Times of the control, s, at which the operator asks for a dress while the program runs."""


class ProgramWriter(ABC):
    """Writes episodes of a simulation down."""

    @abstractmethod
    def block(self, episodes: Episodes, i: int, speed: float, executions: float, pre_dress: float = 0.0) -> Any:
        """Return the step that episode i takes next, as the methods below take it."""

    @abstractmethod
    def text(self, block: Any) -> str:
        """Return what the control reads for a step."""

    @abstractmethod
    def program(self, blocks: Sequence[Any]) -> str:
        """Return the part program of an episode of these steps, with its dress program.

        Steps of a user's program that have not been taken keep their own words.

        Raises:
            GrindError: no one text says them.
        """

    @abstractmethod
    def written(self, episodes: Episodes, i: int, blocks: Sequence[Any]) -> Written:
        """Return episode i, of which these steps have been taken: at least one."""

    @abstractmethod
    def record(self, episodes: Episodes, i: int, blocks: Sequence[Any]) -> GrindingRecord:
        """Return its strokes, dresses and finished parts as `machine.grind` records them, up to the coming block."""
